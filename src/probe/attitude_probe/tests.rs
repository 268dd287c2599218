//! Attitude without identification is that of the whole probe.

extern crate std;
use super::*;
use crate::{Probe, sample::SampleFlags};
use std::boxed::Box;

/// Samples of a steady turn about a tilted axis, with a dozen gyro readings missing.
fn samples() -> impl Iterator<Item = Sample> {
    (1..4_000_u32).map(|k| {
        let angle = k as f32 * 0.004;
        let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
        // A little noise, so that no sensor counts as frozen.
        let noise = (k.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-6;
        Sample {
            t_us: 5_000 * u64::from(k),
            gyro_rad_s: [noise, 0.0 - noise, 0.8],
            accel_m_s2: [-3.0 * cos, 3.0 * sin, -9.3 + noise],
            mag_ut: [20.0 * cos, -20.0 * sin, 40.0 + noise],
            temperature_c: 25.0,
            flags: if k % 300 == 0 { SampleFlags::GYRO_MISSING } else { SampleFlags::empty() },
        }
    })
}

/// Until a model is identified both probes fly the factory's, and their attitudes are equal to the bit.
#[test]
fn attitude_is_the_pipelines_while_nothing_is_learnt() {
    let config = Config { effects: false, ..Config::default() };
    let (mut small, mut whole) = (Box::new(AttitudeProbe::new()), Box::new(Probe::new()));
    small.configure(&config).unwrap_or_default();
    whole.configure(&config).unwrap_or_default();
    let mut compared = 0;
    for sample in samples() {
        // `Probe::poll` is not called, so that nothing is identified.
        let (a, b) = (small.push(&sample), whole.push(&sample));
        assert_eq!(a, b, "{}", sample.t_us);
        compared += u32::from(a.is_some_and(|output| output.attitude.is_some()));
        if let Some(output) = a {
            assert_eq!(small.survey_input(&sample, &output), whole.survey_input(&sample, &output));
        }
    }
    assert!(compared > 3_900, "{compared}");
}

#[test]
fn a_clock_that_goes_back_begins_afresh_and_an_old_sample_is_not_taken() {
    let mut probe = Box::new(AttitudeProbe::new());
    assert!(probe.push(&Sample::default()).is_none(), "not configured");
    probe.configure(&Config::default()).unwrap_or_default();
    let at = |t_us| Sample { t_us, accel_m_s2: [0.0, 0.0, -9.8], ..Sample::default() };
    assert!(probe.push(&at(20_000_000)).is_some());
    assert!(probe.push(&at(19_000_000)).is_none());
    assert!(probe.push(&at(1_000)).is_some(), "afresh");
    assert!(probe.push(&at(6_000)).is_some());
}

#[test]
fn a_model_flies_from_the_next_sample_on() {
    let mut probe = Box::new(AttitudeProbe::new());
    let model = GyroModel { b_rad_s: [0.1, 0.0, 0.0], ..GyroModel::IDENTITY };
    assert!(!probe.fly(&model, &[0.01; 12]), "not configured");
    probe.configure(&Config::default()).unwrap_or_default();
    assert!(probe.fly(&model, &[0.01; 12]));
    let sample = Sample { gyro_rad_s: [0.1, 0.0, 0.0], ..Sample::default() };
    assert_eq!(probe.push(&sample).map(|output| output.rate_rad_s), Some([0.0; 3]));
    assert!(!probe.fly(&GyroModel { p: [[0.0; 3]; 3], ..model }, &[0.01; 12]));
}

/// A probe at rest whose gyro reads its bias keeps its attitude, whatever the model that is flown from the start on
/// says of P.
#[test]
fn the_bias_of_a_model_that_flies_from_the_start_is_not_taken_back() {
    for scale in [1.0, 1.01, 1.1] {
        let mut probe = Box::new(AttitudeProbe::new());
        probe.configure(&Config::default()).unwrap_or_default();
        let p = [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]];
        assert!(probe.fly(&GyroModel { p, b_rad_s: [0.0, 0.0, 0.05] }, &[0.01; 12]));
        let mut stayed = true;
        for mut sample in samples().take(1_000) {
            sample.gyro_rad_s[2] = 0.05;
            (sample.accel_m_s2, sample.mag_ut) = ([-3.0, 0.0, -9.3 + sample.gyro_rad_s[0]], [20.0, 0.0, 40.0]);
            let attitude = probe.push(&sample).and_then(|output| output.attitude);
            stayed &= attitude.is_none_or(|attitude| libm::fabsf(attitude.magnetic_toolface_rad) < 0.02);
        }
        let residual = probe.pipeline.filter.residual_bias_rad_s().norm();
        assert!(stayed && residual < 0.002, "{scale}: {residual}");
    }
}

/// Attitude after a turn about the tool axis at 60 deg of inclination whose rate grows to 180 rpm in a second, read at
/// 100 Hz; one sample of this number is lost, 0: none.
fn spun_up(every: u32) -> [f32; 4] {
    let latency = crate::config::Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) };
    let config = Config { sample_period_us: 10_000, effects: false, latency, ..Config::default() };
    let mut probe = Box::new(AttitudeProbe::new());
    probe.configure(&config).unwrap_or_default();
    let mut last = [0.0; 4];
    for k in 1..=600_u32 {
        let t_s = 0.01 * (f64::from(k) - 500.0).max(0.0);
        let angle = 0.5 * 18.8 * t_s * t_s;
        let body = nalgebra::UnitQuaternion::from_euler_angles(0.0, 60_f64.to_radians(), 0.0)
            * nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, angle);
        let read = |v: [f64; 3]| body.inverse_transform_vector(&v.into()).cast::<f32>().into();
        let noise = (k.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-7;
        let sample = Sample {
            t_us: 10_000 * u64::from(k),
            gyro_rad_s: [noise, -noise, 18.8 * t_s as f32 + noise],
            accel_m_s2: read([0.0, 0.0, -9.806_65]),
            mag_ut: read([20.0, 0.0, 45.0]),
            ..Sample::default()
        };
        if k <= 500 || every == 0 || k % every != 1 {
            last = probe.push(&sample).and_then(|output| output.attitude).map_or(last, |attitude| attitude.q);
        }
    }
    last
}

/// A delay that is known says at which instant each rate was true.
#[test]
fn lost_samples_of_a_gyro_of_known_delay_turn_nothing() {
    let whole = spun_up(0);
    for every in [2, 3, 5] {
        let lossy = spun_up(every);
        // A quaternion and its negative are the same attitude.
        let apart = |sign: f32| whole.iter().zip(&lossy).map(|(a, b)| (a - sign * b) * (a - sign * b)).sum::<f32>();
        let (square, other) = (apart(1.0), apart(-1.0));
        let angle = 2.0 * libm::sqrtf(if square < other { square } else { other });
        assert!(angle < 1e-3, "{every}: {angle}");
    }
}
