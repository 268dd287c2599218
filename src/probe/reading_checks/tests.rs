//! What a reading counts as.

use super::*;

/// Readings of a vector sensor after half a second of the same one, the last sample with these flags.
fn after_repeats(sensor: Sensor, flags: SampleFlags) -> Reading {
    let mut checks = ReadingChecks::new(&Config { sample_period_us: 5_000, ..Config::default() });
    let mut sample = Sample { accel_m_s2: [0.1, 0.2, -9.8], mag_ut: [20.0, 1.0, 40.0], flags, ..Sample::default() };
    for k in 0..100 {
        sample.t_us = 5_000 * k;
        checks.update(&sample);
    }
    checks.vector(sensor, &VectorModel::IDENTITY, &sample)
}

/// The estimator takes an unusable force for a blow beyond the full scale.
#[test]
fn a_stale_force_is_missing_and_a_clipped_one_is_unusable() {
    assert_eq!(after_repeats(Sensor::Accelerometer, SampleFlags::empty()), Reading::Missing);
    assert_eq!(after_repeats(Sensor::Accelerometer, SampleFlags::ACCEL_CLIPPED), Reading::Unusable);
    assert_eq!(after_repeats(Sensor::Magnetometer, SampleFlags::empty()), Reading::Unusable);
}
