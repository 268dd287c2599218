//! Drilling dynamics of known motions.

use super::*;
use crate::{
    attitude::AttitudeFlags,
    survey::{BurstRecorder, VibrationDose, WhirlKind},
};

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

/// First interval of a motion, given as axial rate and vibration at a time in seconds.
fn interval(reading: impl Fn(f64) -> (f64, [f64; 3])) -> DrillingDynamics {
    let mut dynamics = DynamicsInterval::new();
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
    let d = interval(|t| (0.0, [3.0 * libm::sin(w * t), 4.0 * libm::cos(w * t), 2.0 * libm::sin(1.3 * w * t)]));
    assert!((d.axial_rms_m_s2.unwrap() - 2.0 / core::f32::consts::SQRT_2).abs() < 0.01);
    assert!((d.lateral_rms_m_s2.unwrap() - libm::sqrtf(12.5)).abs() < 0.02);
    assert!((d.peak_m_s2.unwrap() - libm::sqrtf(20.0)).abs() < 0.1);
    assert_eq!((d.shocks, d.clipped, d.t_end_us - d.t_start_us), (0, 0, 30_000_000));
}

#[test]
fn stick_slip_is_half_the_swing_over_the_mean() {
    // A speed of 120 rpm that swings by 60 rpm at 0.2 Hz, six swings in the interval; averaging over 0.1 s takes 0.1 %
    // off the swing.
    let w = core::f64::consts::TAU * 0.2;
    let rpm = core::f64::consts::TAU / 60.0;
    let rotation = interval(|t| (rpm * (120.0 + 60.0 * libm::sin(w * t)), [0.0; 3])).rotation.unwrap();
    assert!((rotation.stick_slip_index.unwrap() - 0.5).abs() < 0.01, "{rotation:?}");
    assert!((rotation.min_rpm - 60.0).abs() < 1.0 && (rotation.max_rpm - 180.0).abs() < 1.0);
    assert!((rotation.mean_rpm - 120.0).abs() < 3.0);
    let backwards = interval(|t| (-rpm * (120.0 + 60.0 * libm::sin(w * t)), [0.0; 3])).rotation.unwrap();
    assert!((backwards.stick_slip_index.unwrap() - 0.5).abs() < 0.01 && backwards.mean_rpm < -100.0);
    assert_eq!(interval(|_| (0.01, [0.0; 3])).rotation.unwrap().stick_slip_index, None);
}

#[test]
fn a_blow_counts_once_with_its_ringing_and_blows_apart_count_each() {
    // Every 2 s from 1 s on: 300 m/s^2 that rings down at 60 Hz within some hundredths of a second.
    let ringing = |t: f64| {
        let since = libm::fmod(t + 1.0, 2.0);
        300.0 * libm::exp(-since / 0.02) * libm::cos(core::f64::consts::TAU * 60.0 * since)
    };
    let d = interval(|t| (0.0, [ringing(t), 0.0, 0.0]));
    assert_eq!(d.shocks, 15, "{d:?}");
    assert!(d.peak_m_s2.unwrap() > 290.0);
}

#[test]
fn clipping_is_a_shock_and_a_window_without_readings_claims_nothing() {
    let mut dynamics = DynamicsInterval::new();
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

#[test]
fn a_clipped_blow_counts_at_every_level_that_the_range_reaches() {
    let (earth, config) = (Earth::default(), DynamicsConfig::default());
    // Ranges of 32, 80 and 320 g.
    for (range_m_s2, shocks_over) in [(313.8, [1, 0, 0]), (784.5, [1, 1, 0]), (3_138.0, [1, 1, 1])] {
        let mut dynamics = DynamicsInterval::new();
        let at = |k: u64| {
            let clips =
                SurveyInput { accel_clipped: true, raw_accel_m_s2: [0.0, -range_m_s2, 30.0], ..Default::default() };
            SurveyInput { t_us: k * STEP_US, ..if k == 1_000 { clips } else { SurveyInput::default() } }
        };
        let d = (1..10_000).find_map(|k| dynamics.push(&at(k), &earth, &config, ROTATING_RAD_S)).unwrap();
        assert_eq!((d.shocks, d.shocks_over), (1, shocks_over), "{range_m_s2}");
    }
}

#[test]
fn peaks_are_told_apart_and_shocks_count_at_every_level_that_they_reach() {
    // Blows along the axis of 15, 30, 60 and 120 g in turn, two seconds apart, each of a hundredth of a second, over a
    // vibration of 3 m/s^2 across.
    let blow = |t: f64| match libm::fmod(t, 2.0) < 0.01 {
        true => [15.0, 30.0, 60.0, 120.0].get((t / 2.0) as usize % 4).copied().unwrap_or(0.0) * 9.806_65,
        false => 0.0,
    };
    let d = interval(|t| (0.0, [3.0 * libm::sin(300.0 * t), 0.0, blow(t)]));
    assert_eq!((d.shocks, d.shocks_over), (16, [12, 8, 4]), "{d:?}");
    assert!((d.axial_peak_m_s2.unwrap() / 9.806_65 - 120.0).abs() < 0.01);
    assert!((d.lateral_peak_m_s2.unwrap() - 3.0).abs() < 0.01);
    assert_eq!((d.lateral_severity(), d.axial_severity()), (Some(0), Some(5)));
    let mut dose = VibrationDose::NONE;
    dose.add(&d);
    dose.add(&d);
    assert_eq!((dose.shocks, dose.shocks_over), (32, [24, 16, 8]));
    assert!((dose.axial_s[5] - 60.0).abs() < 1e-3 && dose.axial_s.iter().sum::<f32>() < 60.1);
}

/// Window of vibration in tool axes, whose direction turns in space at one speed while the string turns at another.
fn whirling(around_rpm: f64, string_rpm: f64, size: f64) -> DrillingDynamics {
    let rpm = core::f64::consts::TAU / 60.0;
    interval(move |t| {
        let angle = (around_rpm - string_rpm) * rpm * t;
        (string_rpm * rpm, [size * libm::cos(angle), size * libm::sin(angle), 0.0])
    })
}

#[test]
fn whirl_has_its_speed_and_direction_and_other_vibration_is_none() {
    // Collar of 171 mm in a hole of 216 mm that rolls: 3.8 times as fast as the string, against it.
    let backward = whirling(-3.8 * 120.0, 120.0, 50.0);
    assert_eq!(backward.whirl_kind(), Some(WhirlKind::Backward));
    let whirl = backward.whirl.unwrap();
    assert!((whirl.rpm + 456.0).abs() < 1.0 && (whirl.circularity + 1.0).abs() < 1e-3, "{whirl:?}");
    let mirrored = whirling(3.8 * 120.0, -120.0, 50.0);
    assert_eq!(mirrored.whirl_kind(), Some(WhirlKind::Backward));
    let forward = whirling(300.0, 120.0, 50.0);
    assert_eq!(forward.whirl_kind(), Some(WhirlKind::Forward));
    assert!((forward.whirl.unwrap().rpm - 300.0).abs() < 1.0);
    // No whirl: vibration too weak; and gravity left by an attitude error, whose direction in space is fixed.
    assert_eq!(whirling(-456.0, 120.0, 4.0).whirl_kind(), None);
    assert_eq!(whirling(0.0, 120.0, 50.0).whirl_kind(), None);
    let rate = 120.0 * core::f64::consts::TAU / 60.0;
    // To and fro in tool axes, and the centrifugal force of an accelerometer off the axis.
    let to_and_fro = interval(|t| (rate, [20.0 + 40.0 * libm::sin(47.0 * t), 10.0, 0.0]));
    assert!(to_and_fro.whirl.unwrap().circularity.abs() < 0.05, "{to_and_fro:?}");
    assert_eq!(to_and_fro.whirl_kind(), None);
}

#[test]
fn a_burst_holds_the_worst_second_in_order() {
    let mut recorder = BurstRecorder::<200>::new();
    let mut push = |k: u32| {
        let t = f64::from(k) * 0.005;
        // A blow at 12.34 s over weak vibration; gravity turns slowly.
        let blow = if (12.3..12.4).contains(&t) { 150.0 * libm::sin(400.0 * t) } else { libm::sin(60.0 * t) };
        let gravity = [9.8 * libm::cos(0.1 * t), 9.8 * libm::sin(0.1 * t)];
        recorder.push(&SurveyInput {
            t_us: u64::from(k) * STEP_US,
            raw_accel_m_s2: [gravity[0] as f32, gravity[1] as f32, blow as f32],
            force_m_s2: Some([gravity[0] as f32, gravity[1] as f32, blow as f32]),
            ..SurveyInput::default()
        });
        recorder.worst().count()
    };
    assert_eq!((1..200).map(&mut push).max(), Some(0));
    for k in 200..6_000 {
        assert_eq!(push(k), 200);
    }
    let mut times = recorder.worst().map(|sample| sample.t_us);
    let first = times.next().unwrap();
    assert!((11_400_000..=12_300_000).contains(&first), "{first}");
    assert!(times.enumerate().all(|(k, t_us)| t_us == first + (k as u64 + 1) * STEP_US));
    assert!(recorder.worst_rms_m_s2().unwrap() > 20.0);
}

#[test]
fn a_reading_that_is_missing_is_no_blow_and_one_that_clips_is() {
    let mut recorder = BurstRecorder::<200>::new();
    for k in 0..6_000_u32 {
        let shaking = if (4_000..4_100).contains(&k) { 5.0 * libm::sinf(k as f32) } else { 0.0 };
        let force = [shaking, 0.0, -9.8];
        let (is_missing, accel_clipped) = ((1_000..1_100).contains(&k), k == 4_050);
        recorder.push(&SurveyInput {
            t_us: u64::from(k) * STEP_US,
            raw_accel_m_s2: if is_missing { [0.0; 3] } else { force },
            force_m_s2: (!is_missing && !accel_clipped).then_some(force),
            accel_clipped,
            ..SurveyInput::default()
        });
    }
    assert!(recorder.worst().all(|sample| sample.accel_m_s2 != [0.0; 3]));
    assert!(recorder.worst().any(|sample| sample.t_us == 4_050 * STEP_US));
}

/// A pause does not count as time at the level of the interval that it falls into.
#[test]
fn a_window_lasts_as_long_as_was_measured() {
    let mut dynamics = DynamicsInterval::new();
    let mut t_us = 0;
    let (mut intervals, mut spans_s) = (0, 0.0);
    for k in 1..20_000_u32 {
        t_us += if k == 5_000 { 7_200_000_000 } else { STEP_US };
        let force = Some([20.0 * libm::sinf(k as f32), 0.0, -9.806_65]);
        let input = SurveyInput { t_us, force_m_s2: force, attitude: Some(attitude()), ..SurveyInput::default() };
        if let Some(interval) = dynamics.push(&input, &Earth::default(), &DynamicsConfig::default(), ROTATING_RAD_S) {
            (intervals, spans_s) = (intervals + 1, spans_s + (interval.t_end_us - interval.t_start_us) as f32 * 1e-6);
        }
    }
    assert!(intervals == 3 && (spans_s - 90.0).abs() < 0.1, "{intervals} {spans_s}");
}
