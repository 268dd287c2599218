//! Rotating surveys of a tool with known errors.

use super::*;
use crate::survey::Grade;
use crate::survey::Survey;

const TAU64: f64 = core::f64::consts::TAU;
const STEP_S: f64 = 0.005;

/// Turning tool with biased, off-axis sensors; their readings at an angle by elementary rotations in f64.
struct Rig {
    azimuth: f64,
    inclination: f64,
    /// Steady rate, rad/s, and the relative amplitude of its swing at 0.2 Hz.
    rate: f64,
    swing: f64,
    accel_bias: [f64; 3],
    mag_bias: [f64; 3],
    radius_m: f64,
    gyro_bias: f64,
    gyro_scale: f64,
}

impl Rig {
    const fn still(azimuth: f64, inclination: f64, rate: f64) -> Self {
        Self {
            azimuth,
            inclination,
            rate,
            swing: 0.0,
            accel_bias: [0.0; 3],
            mag_bias: [0.0; 3],
            radius_m: 0.0,
            gyro_bias: 0.0,
            gyro_scale: 1.0,
        }
    }

    fn input(&self, t: f64) -> SurveyInput {
        let swinging = TAU64 * 0.2;
        let angle = self.rate * (t + self.swing / swinging * libm::sin(swinging * t));
        let before = self.rate * (t - STEP_S + self.swing / swinging * libm::sin(swinging * (t - STEP_S)));
        let rate = self.rate * (1.0 + self.swing * libm::cos(swinging * t));
        let into_tool = |v: [f64; 3]| {
            let about_z = |v: [f64; 3], angle: f64| {
                let (s, c) = libm::sincos(angle);
                [c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]]
            };
            let v = about_z(v, self.azimuth);
            let (s, c) = libm::sincos(self.inclination);
            about_z([c * v[0] - s * v[2], v[1], c * v[2] + s * v[0]], angle)
        };
        let (force, field) = (into_tool([0.0, 0.0, -9.81]), into_tool([20.0, 0.0, 45.0]));
        let centripetal = [-self.radius_m * rate * rate, 0.0, 0.0];
        let single = |v: [f64; 3], add: [f64; 3], more: [f64; 3]| {
            Some(core::array::from_fn(|k| (v[k] + add[k] + more[k]) as f32))
        };
        SurveyInput {
            t_us: 1_000_000 + libm::round(t * 1e6) as u64,
            // Mean over the interval, as a gyro reads it.
            rate_rad_s: Some([0.0, 0.0, (self.gyro_scale * (angle - before) / STEP_S + self.gyro_bias) as f32]),
            force_m_s2: single(force, self.accel_bias, centripetal),
            field_ut: single(field, self.mag_bias, [0.0; 3]),
            ..SurveyInput::default()
        }
    }

    fn first(&self, config: &SurveyConfig, change: impl Fn(u32, &mut SurveyInput)) -> Option<SurveyReport> {
        let (mut survey, mut switch) = (RotatingSurvey::new(), ToolfaceSwitch::new());
        (1..40_000).find_map(|k| {
            let mut input = self.input(f64::from(k) * STEP_S);
            change(k, &mut input);
            survey.push(&input, &mut switch, (&Earth::default(), config))
        })
    }
}

fn errors_deg(survey: &Survey, rig: &Rig) -> (f64, f64) {
    let apart = |a: f32, b: f64| libm::remainder(f64::from(a) - b, TAU64).to_degrees();
    let azimuth = survey.magnetic_azimuth_rad.unwrap().value;
    (apart(survey.inclination_rad.value, rig.inclination), apart(azimuth, rig.azimuth))
}

#[test]
fn angles_are_exact_in_all_directions_and_both_senses_of_rotation() {
    let config = SurveyConfig::default();
    for azimuth in [0.2, 1.9, 3.5, 5.1] {
        for inclination in [0.1, 0.8, 1.57, 2.3] {
            for rate in [2.0, 12.0, -12.0, 25.0] {
                let rig = Rig::still(azimuth, inclination, rate);
                let SurveyReport { survey, quality, .. } = rig.first(&config, |_, _| {}).unwrap();
                let (i, a) = errors_deg(&survey, &rig);
                assert!(i.abs() < 0.005 && a.abs() < 0.02, "{azimuth} {inclination} {rate}: {i} {a}");
                assert!(survey.rotating && survey.gravity_toolface_rad.is_none());
                assert_eq!(quality.grade, Grade::Good);
                let turns = (survey.t_end_us - survey.t_start_us) as f64 * 1e-6 * rate.abs() / TAU64;
                assert!((turns - 10.0).abs() < 0.1, "{turns}");
            }
        }
    }
}

#[test]
fn biases_across_the_axis_and_centrifugal_force_cancel_even_in_stick_slip() {
    for swing in [0.0, 0.95] {
        let rig = Rig { swing, accel_bias: [0.5, -0.3, 0.0], mag_bias: [3.0, -2.0, 0.0], ..Rig::still(0.7, 0.6, 12.0) };
        let SurveyReport { survey, .. } = rig.first(&SurveyConfig::default(), |_, _| {}).unwrap();
        let (i, a) = errors_deg(&survey, &rig);
        assert!(i.abs() < 0.01 && a.abs() < 0.05, "swing {swing}: {i} {a}");
    }
    // 3 mm off the axis: 0.43 m/s^2 at 12 rad/s, 2.5 deg in one reading.
    let rig = Rig { radius_m: 0.003, ..Rig::still(0.7, 0.6, 12.0) };
    let (i, _) = errors_deg(&rig.first(&SurveyConfig::default(), |_, _| {}).unwrap().survey, &rig);
    assert!(i.abs() < 0.01, "{i}");
}

/// The field is read 4 ms late.
#[test]
fn a_delay_that_nobody_knows_is_in_the_azimuths_sigma() {
    for (swing, rate) in [(0.0, 12.0), (0.1, -7.0)] {
        let rig = Rig { swing, ..Rig::still(3.5, 0.6, rate) };
        let late = |sigma_s: f32| {
            let read = |k: u32, input: &mut SurveyInput| {
                input.field_ut = rig.input(f64::from(k) * STEP_S - 0.004).field_ut;
                input.mag_delay_sigma_s = sigma_s;
            };
            let SurveyReport { survey, .. } = rig.first(&SurveyConfig::default(), read).unwrap();
            errors_deg(&survey, &rig).1.abs() / f64::from(survey.magnetic_azimuth_rad.unwrap().sigma).to_degrees()
        };
        assert!((0.9..1.1).contains(&late(0.004)) && late(0.0) > 3.0, "{swing}: {} {}", late(0.004), late(0.0));
    }
}

#[test]
fn a_gyro_bias_smears_little_and_turns_nothing() {
    // 0.3 deg/s over the 5 s of ten turns.
    let rig = Rig { gyro_bias: 0.005, ..Rig::still(2.0, 0.9, 12.0) };
    let (i, a) = errors_deg(&rig.first(&SurveyConfig::default(), |_, _| {}).unwrap().survey, &rig);
    assert!(i.abs() < 0.01 && a.abs() < 0.02, "{i} {a}");
}

/// Ten turns of a gyro that is off by 1 % end 36 deg beside where they began. The sensors' biases, which no longer
/// cancel over whole turns, are left out.
#[test]
fn an_error_of_the_gyros_scale_does_not_bend_the_inclination() {
    for (inclination_deg, scale, has_field) in
        [(10.0_f64, 1.01, true), (10.0, 0.99, true), (10.0, 1.01, false), (40.0, 1.01, true), (90.0, 0.99, true)]
    {
        let rig = Rig { gyro_scale: scale, ..Rig::still(1.0, inclination_deg.to_radians(), 12.0) };
        let without_field = |_, input: &mut SurveyInput| {
            if !has_field {
                input.field_ut = None;
            }
        };
        let survey = rig.first(&SurveyConfig::default(), without_field).unwrap().survey;
        let off_deg = f64::from(survey.inclination_rad.value).to_degrees() - inclination_deg;
        assert!(off_deg.abs() < 0.02, "{inclination_deg} {scale} {has_field}: {off_deg}");
        if has_field {
            assert!(errors_deg(&survey, &rig).1.abs() < 0.05, "{:?}", errors_deg(&survey, &rig));
        }
    }
    // With 10 % what is left is the turning within one turn, sinc(0.1 pi).
    let rig = Rig { gyro_scale: 1.1, ..Rig::still(1.0, 4_f64.to_radians(), 12.0) };
    let (off_deg, _) = errors_deg(&rig.first(&SurveyConfig::default(), |_, _| {}).unwrap().survey, &rig);
    assert!(off_deg.abs() < 0.1, "{off_deg}");
}

#[test]
fn missing_readings_are_bridged_and_a_dead_magnetometer_leaves_the_inclination() {
    let rig = Rig::still(2.0, 0.9, 12.0);
    let config = SurveyConfig::default();
    let sparse = |k: u32, input: &mut SurveyInput| {
        if k.is_multiple_of(7) {
            input.force_m_s2 = None;
        }
        if k.is_multiple_of(5) {
            input.field_ut = None;
        }
        input.accel_clipped = k.is_multiple_of(11);
    };
    let (i, a) = errors_deg(&rig.first(&config, sparse).unwrap().survey, &rig);
    assert!(i.abs() < 0.05 && a.abs() < 0.1, "{i} {a}");
    let dead = rig.first(&config, |_, input| input.field_ut = None).unwrap().survey;
    assert!(dead.magnetic_azimuth_rad.is_none());
    assert!((f64::from(dead.inclination_rad.value) - 0.9).abs() < 1e-4);
}

#[test]
fn the_stated_azimuth_sigma_has_the_delay_of_the_magnetometer_in_it() {
    // 1 ms at 12 rad/s turns the field across the axis by 0.012 rad.
    let mut config = SurveyConfig::default();
    let rig = Rig::still(1.0, 1.2, 12.0);
    let azimuth = |config: &SurveyConfig, delay_s: f64| {
        let (mut survey, mut switch) = (RotatingSurvey::new(), ToolfaceSwitch::new());
        let report = (1..40_000).find_map(|k| {
            let t = f64::from(k) * STEP_S;
            let input = SurveyInput { field_ut: rig.input(t - delay_s).field_ut, ..rig.input(t) };
            survey.push(&input, &mut switch, (&Earth::default(), config))
        });
        report.unwrap().survey.magnetic_azimuth_rad.unwrap()
    };
    let turned = (azimuth(&config, 0.001).value - azimuth(&config, 0.0).value).abs();
    let with = azimuth(&config, 0.0).sigma;
    config.errors.mag_timing_s = 1e-9;
    let without = azimuth(&config, 0.0).sigma;
    let stated = libm::sqrtf(with * with - without * without);
    assert!((stated / turned - 1.0).abs() < 0.05, "{stated} {turned}");
}

/// Across the axis a constant error cancels over whole turns; along it, it stays.
#[test]
fn of_a_correction_only_the_uncertainty_along_the_axis_stays() {
    let rig = Rig::still(1.0, 1.2, 6.0);
    let sigma = |config: &SurveyConfig, of_field: [f32; 3]| {
        let report = rig.first(config, |_, input| input.field_correction_sigma_ut = of_field);
        report.unwrap().survey.magnetic_azimuth_rad.unwrap().sigma
    };
    let config = SurveyConfig::default();
    let mut stated = config;
    stated.errors.axial_interference_ut = libm::hypotf(config.errors.axial_interference_ut, 0.7);
    assert_eq!(sigma(&config, [0.7, 0.7, 0.0]), sigma(&config, [0.0; 3]));
    let (corrected, stated) = (sigma(&config, [0.0, 0.0, 0.7]), sigma(&stated, [0.0; 3]));
    assert!(
        (corrected / stated - 1.0).abs() < 1e-4 && corrected > 1.2 * sigma(&config, [0.0; 3]),
        "{corrected} {stated}"
    );
}

#[test]
fn sliding_is_not_rotating() {
    let rig = Rig::still(1.0, 1.2, 0.2);
    assert!(rig.first(&SurveyConfig::default(), |_, _| {}).is_none());
}
