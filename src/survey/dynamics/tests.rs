//! Drilling dynamics of known motions.

use super::*;
use crate::attitude::AttitudeFlags;

const STEP_US: u64 = 5_000;
const ROTATING_RAD_S: f32 = 0.5;

const fn attitude() -> Attitude {
    Attitude {
        // Straight down.
        q: [1.0, 0.0, 0.0, 0.0],
        inclination_rad: 0.0,
        azimuth_rad: 0.0,
        gravity_toolface_rad: 0.0,
        magnetic_toolface_rad: 0.0,
        sigma_inclination_rad: 0.01,
        sigma_azimuth_rad: 0.01,
        sigma_toolface_rad: 0.01,
        flags: AttitudeFlags::empty(),
    }
}

/// First window of a motion, given as axial rate and vibration at a time in seconds.
fn window(reading: impl Fn(f64) -> (f64, [f64; 3])) -> DrillingDynamics {
    let mut dynamics = DynamicsWindow::new();
    let (earth, config) = (Earth::default(), DynamicsConfig::default());
    (1..10_000_u32)
        .find_map(|k| {
            let (rate, v) = reading(f64::from(k) * 0.005);
            let input = SurveyInput {
                t_us: u64::from(k) * STEP_US,
                rate_rad_s: Some([0.0, 0.0, rate as f32]),
                force_m_s2: Some([v[0] as f32, v[1] as f32, v[2] as f32 - 9.806_65]),
                attitude: Some(attitude()),
                ..SurveyInput::default()
            };
            dynamics.push(&input, &earth, &config, ROTATING_RAD_S)
        })
        .unwrap()
}

#[test]
fn rms_and_peak_are_those_of_a_known_vibration_and_gravity_is_not_in_them() {
    let w = core::f64::consts::TAU * 17.3;
    let d = window(|t| (0.0, [3.0 * libm::sin(w * t), 4.0 * libm::cos(w * t), 2.0 * libm::sin(1.3 * w * t)]));
    assert!((d.axial_rms_m_s2.unwrap() - 2.0 / core::f32::consts::SQRT_2).abs() < 0.01);
    assert!((d.lateral_rms_m_s2.unwrap() - libm::sqrtf(12.5)).abs() < 0.02);
    assert!((d.peak_m_s2.unwrap() - libm::sqrtf(20.0)).abs() < 0.1);
    assert_eq!((d.shocks, d.clipped, d.t_end_us - d.t_start_us), (0, 0, 30_000_000));
}

#[test]
fn stick_slip_is_half_the_swing_over_the_mean() {
    // 120 rpm that swings by 60 at 0.2 Hz, six swings in the window; averaging over 0.1 s takes 0.1 % off the
    // swing.
    let w = core::f64::consts::TAU * 0.2;
    let rpm = core::f64::consts::TAU / 60.0;
    let rotation = window(|t| (rpm * (120.0 + 60.0 * libm::sin(w * t)), [0.0; 3])).rotation.unwrap();
    assert!((rotation.stick_slip_index.unwrap() - 0.5).abs() < 0.01, "{rotation:?}");
    assert!((rotation.min_rpm - 60.0).abs() < 1.0 && (rotation.max_rpm - 180.0).abs() < 1.0);
    assert!((rotation.mean_rpm - 120.0).abs() < 3.0);
    let backwards = window(|t| (-rpm * (120.0 + 60.0 * libm::sin(w * t)), [0.0; 3])).rotation.unwrap();
    assert!((backwards.stick_slip_index.unwrap() - 0.5).abs() < 0.01 && backwards.mean_rpm < -100.0);
    assert_eq!(window(|_| (0.01, [0.0; 3])).rotation.unwrap().stick_slip_index, None);
}

#[test]
fn a_blow_counts_once_with_its_ringing_and_blows_apart_count_each() {
    // Every 2 s from 1 s on: 300 m/s^2 that rings down at 60 Hz within some hundredths of a second.
    let ringing = |t: f64| {
        let since = libm::fmod(t + 1.0, 2.0);
        300.0 * libm::exp(-since / 0.02) * libm::cos(core::f64::consts::TAU * 60.0 * since)
    };
    let d = window(|t| (0.0, [ringing(t), 0.0, 0.0]));
    assert_eq!(d.shocks, 15, "{d:?}");
    assert!(d.peak_m_s2.unwrap() > 290.0);
}

#[test]
fn clipping_is_a_shock_and_a_window_without_readings_claims_nothing() {
    let mut dynamics = DynamicsWindow::new();
    let (earth, config) = (Earth::default(), DynamicsConfig::default());
    let d = (1..10_000_u64)
        .find_map(|k| {
            let input =
                SurveyInput { t_us: k * STEP_US, accel_clipped: (1_000..1_003).contains(&k), ..SurveyInput::default() };
            dynamics.push(&input, &earth, &config, ROTATING_RAD_S)
        })
        .unwrap();
    assert_eq!((d.shocks, d.clipped), (1, 3));
    assert_eq!((d.axial_rms_m_s2, d.lateral_rms_m_s2, d.peak_m_s2, d.rotation), (None, None, None, None));
}
