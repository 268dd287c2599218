//! Effects that depend on force or temperature, in samples without one.

use super::*;
use crate::compensation::{
    FoundEffect,
    effects::{GSensitivity, GyroBiasTemperature},
};

const GRAVITY: Vector3<f32> = Vector3::new(3.0, -4.0, -8.0);

fn found(index: u8) -> Found {
    let mut effect = FoundEffect { index, ..Default::default() };
    (effect.parameters[0], effect.parameters[1]) = (0.002, 0.001);
    let mut found = Found::ZERO;
    assert!(found.effects.add(effect));
    found
}

/// Corrected sample of a gyro that turns about z at this rate, 10 ms after the one before.
fn corrected(found: &mut Found, sample: &Sample, rate_rad_s: f32, accel: Reading) -> Snapshot {
    let motion = [&Vector3::new(0.0, 0.0, rate_rad_s), &Vector3::zeros()];
    found.correct(&[&GSensitivity, &GyroBiasTemperature], sample, motion, [accel, Reading::Missing], 0.01)
}

#[test]
fn g_sensitivity_is_taken_out_of_a_sample_without_a_force_by_the_last_one() {
    for odd in [Reading::Missing, Reading::Unusable] {
        let mut found = found(0);
        let sample = Sample::default();
        let with = corrected(&mut found, &sample, 0.0, Reading::Usable(GRAVITY)).rate_rad_s;
        assert!((with.x - (0.001 * 4.0 - 0.002 * 3.0)).abs() < 1e-6, "{with}");
        let model = found.model_here(&GyroModel::IDENTITY, &[&GSensitivity]);
        assert_eq!(corrected(&mut found, &sample, 0.0, odd).rate_rad_s, with);
        assert_eq!(found.model_here(&GyroModel::IDENTITY, &[&GSensitivity]), model);
        // A quarter of a turn about z brings gravity's x to -y.
        for _ in 0..100 {
            corrected(&mut found, &sample, core::f32::consts::FRAC_PI_2, odd);
        }
        let turned = Vector3::new(GRAVITY.y, -GRAVITY.x, GRAVITY.z);
        assert!((found.last_force_m_s2 - turned).norm() < 1e-3, "{}", found.last_force_m_s2);
    }
}

#[test]
fn the_last_temperature_holds_while_none_is_read() {
    let mut found = found(1);
    let warm = Sample { temperature_c: 60.0, ..Sample::default() };
    let none = Sample { temperature_c: 0.0, flags: SampleFlags::TEMPERATURE_MISSING, ..warm };
    let with = corrected(&mut found, &warm, 0.0, Reading::Usable(GRAVITY)).rate_rad_s;
    assert!(with.x.abs() > 0.01, "{with}");
    assert_eq!(corrected(&mut found, &none, 0.0, Reading::Usable(GRAVITY)).rate_rad_s, with);
}
