//! A tool in its hole, drawn whole: motion, place, sensors and up to three effects.

use crate::bench::effects::cases::{CASES, Case, is_of_vectors};
use testbed::simulate::{
    Accelerometer, EarthSettings, Gyro, Hole, Magnetometer, Random, Rotation, Scenario, ShockSettings, Vibration,
    Wobble,
};

/// Speed at which [`Vibration`]'s chatter is as its default says, rpm: what a tool touches at each turn it meets with
/// the square of its speed.
const CHATTER_RPM: f64 = 30.0;

/// Speed that the sizes of [`CASES`] are meant for, rpm.
const CASES_RPM: f64 = 30.0;

/// Speed up to which chatter comes fifteen times a turn, as from a bit's cutters; above it three times, as from blades,
/// which is below half of the slowest rate of samples.
const CUTTERS_UP_TO_RPM: f64 = 60.0;

/// Errors of the vector sensors that every second tool has, as what is left after a calibration: standard deviations.
const ACCEL_BIAS_M_S2: f64 = 0.02;
const ACCEL_SCALE: f64 = 2e-3;
const HARD_IRON_UT: f64 = 0.3;
const MAG_SCALE: f64 = 5e-3;

/// A tool that was drawn.
pub(super) struct Drawn {
    pub scenario: Scenario,
    /// Its effects.
    pub cases: Vec<&'static Case>,
    /// True if its vector sensors have errors as after a calibration, too.
    pub are_vectors_off: bool,
}

impl Drawn {
    /// Returns true if what has this name is there, or cannot be told from what is.
    pub fn allows(&self, name: &str) -> bool {
        self.cases.iter().any(|case| case.allows(name)) || (self.are_vectors_off && is_of_vectors(name))
    }

    /// Description for the reader of a table.
    pub fn told(&self) -> String {
        let Scenario { hole, rotation, earth, sample_period_us, rest_s, .. } = &self.scenario;
        let effects: Vec<&str> = self.cases.iter().map(|case| case.name).collect();
        format!(
            "{:.0} deg, dip {:.0}, {:.0} rpm, stick-slip {:.1}, rest {rest_s:.0} s, {:.0} Hz: {}",
            hole.inclination_deg,
            earth.dip_deg,
            rotation.mean_rpm,
            rotation.stick_slip,
            1e6 / f64::from(*sample_period_us),
            if effects.is_empty() { "nothing".to_owned() } else { effects.join(", ") }
        )
    }
}

/// One of these.
fn one<T: Copy>(random: &mut Random, of: &[T]) -> T {
    of[random.index(of.len())]
}

fn scaled(random: &mut Random, sigma: f64) -> [[f64; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { sigma * random.normal() } else { 0.0 }))
}

/// The tool of a seed.
pub(super) fn draw(seed: u64) -> Drawn {
    // A stream apart from the simulator's own.
    let random = &mut Random::new(seed ^ 0x5eed_d8a7);
    let mean_rpm = one(random, &[5.0, 15.0, 30.0, 30.0, 60.0, 90.0, 120.0, 150.0]);
    let shaken = one(random, &[0.3, 1.0, 1.0, 2.0]);
    let gyro_off = one(random, &[0.01, 0.02, 0.04, 0.04]);
    let stepped = random.uniform() < 0.5;
    let mut scenario = Scenario {
        duration_s: one(random, &[120.0, 180.0, 300.0]),
        sample_period_us: one(random, &[20_000, 10_000, 10_000, 10_000, 5_000, 2_500]),
        rest_s: one(random, &[0.0, 2.0, 10.0, 10.0, 20.0]),
        hole: Hole {
            inclination_deg: one(random, &[0.0, 0.0, 1.0, 3.0, 10.0, 30.0, 45.0, 60.0, 85.0, 90.0]),
            azimuth_deg: random.between(0.0, 360.0),
            build_rate_deg_h: one(random, &[0.0, 3.0, 30.0]),
            ..Hole::default()
        },
        rotation: Rotation {
            toolface_deg: random.between(0.0, 360.0),
            mean_rpm,
            stick_slip: one(random, &[0.0, 0.3, 0.6, 0.95, 1.0]),
            stick_slip_hz: one(random, &[0.1, 0.25, 0.5]),
        },
        wobble: Wobble { rms_deg: one(random, &[0.1, 0.3, 1.0, 1.0, 2.0]), ..Wobble::default() },
        vibration: Vibration {
            lateral_m_s2: 3.0 * shaken,
            axial_m_s2: 2.0 * shaken,
            chatter_m_s2: shaken * (mean_rpm / CHATTER_RPM).powi(2).min(1.0),
            chatter_order: if mean_rpm > CUTTERS_UP_TO_RPM { 3 } else { 15 },
            angular_deg_s: shaken,
            ..Vibration::default()
        },
        shocks: ShockSettings { per_minute: one(random, &[0.0, 20.0, 60.0]), ..ShockSettings::default() },
        earth: EarthSettings {
            magnetic_field_ut: random.between(25.0, 62.0),
            dip_deg: one(random, &[-60.0, 0.0, 20.0, 45.0, 65.0, 65.0, 75.0, 82.0]),
            ..EarthSettings::default()
        },
        gyro: Gyro {
            diagonal_sigma: gyro_off,
            off_diagonal_sigma: gyro_off / 2.0,
            bias_sigma_deg_s: one(random, &[0.2, 1.0, 1.0, 3.0]),
            noise_deg_s_rthz: one(random, &[0.003, 0.007, 0.01, 0.02]),
            // Steps of 16 bits over 2,000 deg/s, 16 g and 1,300 uT.
            resolution_deg_s: stepped.then_some(0.061),
            ..Gyro::default()
        },
        accel: Accelerometer {
            noise_ug_rthz: one(random, &[60.0, 110.0, 200.0]),
            resolution_m_s2: stepped.then_some(0.0048),
            ..Accelerometer::default()
        },
        mag: Magnetometer {
            noise_ut: one(random, &[0.05, 0.2, 0.2, 0.5]),
            resolution_ut: stepped.then_some(0.04),
            ..Magnetometer::default()
        },
        ..Scenario::default()
    };
    if random.uniform() < 0.2 {
        scenario.stop_s = Some(scenario.duration_s - 20.0);
    }
    let alone: Vec<&Case> = CASES.iter().filter(|case| case.is_alone()).collect();
    let mut cases: Vec<&Case> = Vec::new();
    for _ in 0..one(random, &[0, 0, 1, 1, 1, 2, 2, 3]) {
        let case = one(random, &alone);
        if cases.iter().all(|other| other.name != case.name) {
            (case.add)(&mut scenario, random);
            cases.push(case);
        }
    }
    // The sizes of a nonlinearity are for a slow tool, and what they add to a reading grows with the square of the
    // speed.
    let slower = (CASES_RPM / mean_rpm).min(1.0);
    scenario.effects.gyro_scale_nonlinearity_s2_rad2.iter_mut().for_each(|size| *size *= slower * slower);
    let are_vectors_off = random.uniform() < 0.5;
    if are_vectors_off {
        let effects = &mut scenario.effects;
        for (size, sigma) in
            [(&mut effects.accel_bias_m_s2, ACCEL_BIAS_M_S2), (&mut effects.hard_iron_ut, HARD_IRON_UT)]
        {
            size.iter_mut().for_each(|x| *x += sigma * random.normal());
        }
        for (size, sigma) in [(&mut effects.accel_matrix, ACCEL_SCALE), (&mut effects.mag_matrix, MAG_SCALE)] {
            let more = scaled(random, sigma);
            for (x, more) in size.iter_mut().flatten().zip(more.iter().flatten()) {
                *x += more;
            }
        }
    }
    Drawn { scenario, cases, are_vectors_off }
}
