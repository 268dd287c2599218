//! Random drilling runs with faults and effects, each absent in some runs.

use std::array;

use testbed::simulate::{
    Dropouts, Effects, Gyro, Hole, MagneticBursts, Rotation, Scenario, ShockSettings, Vibration, Wobble, random::Random,
};

/// Length of a run, seconds: a window, the latency of its result and six minutes.
const DURATION_S: f64 = 416.0;

/// Share of runs without any effect, and probability of each effect in the others.
const NONE: f64 = 0.2;
const EACH: f64 = 0.3;

/// Classes that runs are counted under: the gyro's errors, then each effect present.
pub const CLASSES: [&str; 15] = [
    "P exact",
    "P off by tenths of a percent",
    "P off by percents",
    "no effect",
    "hard iron",
    "soft iron, misalignment of the magnetometer",
    "magnetometer lag",
    "magnetic bursts",
    "accelerometer bias, misalignment",
    "g-sensitivity",
    "lever arm",
    "gyro lag",
    "bias step at a shock",
    "dropouts, clipping",
    "no rest",
];

/// Index of the first class that is an effect, and number of such classes.
const FIRST_EFFECT: usize = 4;
const EFFECTS: usize = 10;

/// A drawn run.
pub struct Drawn {
    /// The scenario.
    pub scenario: Scenario,
    /// Which of [`CLASSES`] it belongs to.
    pub classes: [bool; CLASSES.len()],
}

/// Draws a run; the same seed gives the same run.
#[must_use]
pub fn draw(seed: u64) -> Drawn {
    let mut random = Random::new(seed);
    let mut classes = [false; CLASSES.len()];
    let gyro_class = random.between(0.0, 3.0) as usize;
    classes[gyro_class] = true;
    let mut scenario = motion(&mut random);
    scenario.gyro = gyro(gyro_class);
    if random.uniform() < 0.5 {
        scenario.rest_s = random.between(0.0, 1.0);
        classes[CLASSES.len() - 1] = true;
    }
    if random.uniform() < NONE {
        classes[FIRST_EFFECT - 1] = true;
        return Drawn { scenario, classes };
    }
    for effect in 0..EFFECTS {
        if random.uniform() < EACH {
            classes[FIRST_EFFECT + effect] = true;
            add(&mut scenario, effect, &mut random);
        }
    }
    classes[FIRST_EFFECT - 1] = classes.iter().skip(FIRST_EFFECT).take(EFFECTS).all(|present| !present);
    Drawn { scenario, classes }
}

/// Draws the motion of the tool.
fn motion(random: &mut Random) -> Scenario {
    let some = |random: &mut Random, low, high| if random.uniform() < 0.8 { random.between(low, high) } else { 0.0 };
    Scenario {
        duration_s: DURATION_S,
        rest_s: random.between(2.0, 15.0),
        hole: Hole {
            inclination_deg: if random.uniform() < 0.25 { 0.0 } else { random.between(0.0, 90.0) },
            azimuth_deg: random.between(0.0, 360.0),
            ..Hole::default()
        },
        rotation: Rotation {
            toolface_deg: random.between(0.0, 360.0),
            mean_rpm: random.between(5.0, 60.0),
            stick_slip: some(random, 0.2, 1.0),
            stick_slip_hz: random.between(0.1, 0.5),
        },
        wobble: Wobble { rms_deg: some(random, 0.2, 2.0), ..Wobble::default() },
        vibration: Vibration {
            lateral_m_s2: some(random, 0.5, 6.0),
            axial_m_s2: some(random, 0.5, 4.0),
            chatter_m_s2: some(random, 0.2, 2.0),
            angular_deg_s: some(random, 0.2, 3.0),
            ..Vibration::default()
        },
        shocks: ShockSettings { per_minute: some(random, 1.0, 40.0), ..ShockSettings::default() },
        ..Scenario::default()
    }
}

fn gyro(class: usize) -> Gyro {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sigmas = |diagonal_sigma, off_diagonal_sigma| Gyro { diagonal_sigma, off_diagonal_sigma, ..Gyro::default() };
    match class {
        0 => Gyro { p: Some(identity), ..Gyro::default() },
        1 => sigmas(0.002, 0.001),
        _ => sigmas(0.04, 0.02),
    }
}

/// Adds one effect, by its number in [`CLASSES`].
fn add(scenario: &mut Scenario, effect: usize, random: &mut Random) {
    // A vector of length up to `largest`; below, a matrix of such elements.
    let vector = |random: &mut Random, largest: f64| {
        let length = random.between(0.0, largest);
        random.direction().map(|x| length * x)
    };
    let matrix = |random: &mut Random, largest: f64| -> [[f64; 3]; 3] {
        array::from_fn(|_| array::from_fn(|_| random.between(-largest, largest)))
    };
    let rest_s = scenario.rest_s;
    let effects: &mut Effects = &mut scenario.effects;
    match effect {
        0 => effects.hard_iron_ut = vector(random, 30.0),
        1 => effects.mag_matrix = matrix(random, 0.03),
        2 => effects.mag_lag_ms = random.between(0.0, 20.0),
        3 => {
            let (per_minute, length_s) = (random.between(1.0, 10.0), random.between(0.5, 5.0));
            effects.magnetic_bursts = MagneticBursts { per_minute, length_s, peak_ut: random.between(2.0, 30.0) };
        }
        4 => {
            // 20 mg, and the same of misalignment.
            effects.accel_bias_m_s2 = vector(random, 0.2);
            effects.accel_matrix = matrix(random, 0.02);
        }
        5 => effects.g_sensitivity_deg_s_g = matrix(random, 0.1),
        6 => effects.lever_arm_mm = vector(random, 50.0),
        7 => effects.gyro_lag_ms = random.between(0.0, 5.0),
        8 => {
            effects.bias_step_deg_s = vector(random, 1.0);
            effects.bias_step_after_s = random.between(rest_s, 50.0);
        }
        _ => {
            effects.dropouts = Dropouts { per_minute: random.between(1.0, 30.0), length_s: random.between(0.01, 0.5) };
            // The speed swings up to twice its mean, which partly clips.
            let peak_deg_s = 2.0 * 6.0 * scenario.rotation.mean_rpm;
            scenario.gyro.full_scale_deg_s = Some(peak_deg_s * random.between(0.9, 1.2));
            scenario.accel.full_scale_g = Some(random.between(2.0, 8.0));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_draw_is_a_scenario_and_every_class_is_drawn_and_left_out() {
        let drawn: Vec<Drawn> = (0..300).map(draw).collect();
        for one in &drawn {
            one.scenario.validate().unwrap();
            assert_eq!(one.classes.iter().take(3).filter(|c| **c).count(), 1);
        }
        for (class, name) in CLASSES.iter().enumerate() {
            let count = drawn.iter().filter(|one| one.classes[class]).count();
            assert!((30..200).contains(&count), "{name}: {count}");
        }
        assert_eq!(draw(4).scenario, draw(4).scenario);
    }
}
