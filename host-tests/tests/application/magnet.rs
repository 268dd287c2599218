//! A magnet on the tool is told over the line when it comes, and when it leaves.

use super::desk_board::{Desk, fly};
use meerkat_mwd::{Sample, telemetry::Message};
use nalgebra::{UnitQuaternion, Vector3};

/// Times between which a magnet is on the tool, seconds.
const THERE_S: [f64; 2] = [22.0, 41.0];
/// Period of the samples, seconds.
const STEP_S: f64 = 0.005;

#[test]
fn a_magnet_is_told_when_it_comes_and_when_it_leaves() {
    let magnet_ut = Vector3::new(6.0, -4.0, 9.0);
    let mut attitude = UnitQuaternion::<f64>::identity();
    let turned = move |at_rest: Sample| {
        let t_s = at_rest.t_us as f64 * 1e-6;
        let wave = |hz: f64, phase: f64| (core::f64::consts::TAU * hz * t_s + phase).sin();
        let moves = if t_s > 10.0 { 1.0 } else { 0.0 };
        let rate =
            Vector3::new(1.2 * wave(0.21, 0.3) + 0.3, wave(0.17, 1.7) - 0.2, 1.5 * wave(0.13, 2.9) + 0.4) * moves;
        attitude *= UnitQuaternion::from_scaled_axis(rate * STEP_S);
        let there = (THERE_S[0]..THERE_S[1]).contains(&t_s);
        let field = attitude.inverse_transform_vector(&Vector3::new(20.0, 0.0, 45.0));
        let field = field + if there { magnet_ut } else { Vector3::zeros() };
        let force = attitude.inverse_transform_vector(&Vector3::new(0.0, 0.0, -9.8));
        // The noise of the tool at rest stays.
        let with_noise = |noisy: [f32; 3], at_rest: [f64; 3], truth: Vector3<f64>| {
            [0, 1, 2].map(|axis| (f64::from(noisy[axis]) - at_rest[axis] + truth[axis]) as f32)
        };
        Sample {
            gyro_rad_s: with_noise(at_rest.gyro_rad_s, [0.0; 3], rate),
            accel_m_s2: with_noise(at_rest.accel_m_s2, [4.0, 1.0, -8.9], force),
            mag_ut: with_noise(at_rest.mag_ut, [20.0, 1.0, 45.0], field),
            ..at_rest
        }
    };
    let seen = fly(Desk { reads: Box::new(turned), ..Desk::default() }, 60);
    let told = seen.messages.iter().filter_map(|(left_us, message)| match message {
        Message::HardIron(interval) => Some((*left_us, *interval)),
        _ => None,
    });
    let told: Vec<_> = told.collect();
    let [(came_us, came), (left_us, left)] = told[..] else { panic!("{told:?}") };
    let near = |t_us: u64, t_s: f64| (t_us as f64 * 1e-6 - t_s).abs() < 0.3;
    for interval in [&came, &left] {
        assert!(near(interval.from_us, THERE_S[0]), "{told:?}");
        assert!((interval.offset() - magnet_ut.cast()).norm() < 1.0, "{told:?}");
    }
    assert_eq!(came.to_us, None);
    assert!(left.to_us.is_some_and(|to_us| near(to_us, THERE_S[1])), "{told:?}");
    // Each within ten seconds: it has to be told from a change of the earth's field.
    assert!(came_us < 32_000_000 && left_us < 51_000_000, "{told:?}");
}
