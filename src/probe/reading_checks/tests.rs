//! Readings that are missing, clipped, frozen or wrong, and sound ones.

use super::*;

/// Readings of a vector sensor after half a second of the same one, the last sample with these flags.
fn after_repeats(sensor: Sensor, flags: SampleFlags) -> Reading {
    let mut checks = ReadingChecks::new(&Config { sample_period_us: 5_000, ..Config::default() });
    let mut sample = Sample { accel_m_s2: [0.1, 0.2, -9.8], mag_ut: [20.0, 1.0, 40.0], flags, ..Sample::default() };
    for k in 0..100 {
        sample.t_us = 5_000 * k;
        checks.update(&sample, 0.005);
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

/// Milliseconds after which a sensor that is read every `interval` milliseconds beside a gyro of 1 kHz counts as stale
/// and as frozen, where it changes its reading every `change` readings.
fn times_ms(sensor: Sensor, interval: u16, change: u16) -> [Option<u16>; 2] {
    let mut checks = ReadingChecks::new(&Config { sample_period_us: 1_000, ..Config::default() });
    let [mut stale, mut frozen] = [None; 2];
    for k in 0..2_500_u16 {
        let live = f32::from(k) + 0.1;
        let held = f32::from(k / interval / change) + 7.0;
        let mut sample =
            Sample { gyro_rad_s: [live; 3], accel_m_s2: [live; 3], mag_ut: [live; 3], ..Sample::default() };
        match sensor {
            Sensor::Gyro => sample.gyro_rad_s = [held; 3],
            Sensor::Accelerometer => sample.accel_m_s2 = [held; 3],
            Sensor::Magnetometer => sample.mag_ut = [held; 3],
        }
        if k % interval > 0 {
            sample.flags = SampleFlags::missing(sensor);
        }
        let is_frozen = checks.update(&sample, 0.001);
        assert!(frozen.is_none() || is_frozen, "the verdict holds between readings: {k}");
        frozen = frozen.or(is_frozen.then_some(k));
        let is_stale =
            k % interval == 0 && !matches!(checks.vector(sensor, &VectorModel::IDENTITY, &sample), Reading::Usable(_));
        stale = stale.or(is_stale.then_some(k));
    }
    [stale, frozen]
}

#[test]
fn a_sensor_that_is_read_less_often_than_the_gyro_is_stale_as_soon() {
    let never = u16::MAX;
    // Six equal readings, where they take longer than a quarter of a second.
    for (interval, stale_ms) in [(1, 250), (10, 250), (100, 500)] {
        let [stale, frozen] = times_ms(Sensor::Magnetometer, interval, never).map(Option::unwrap);
        assert!((stale_ms..=stale_ms + 20).contains(&stale), "{interval}: {stale}");
        assert!((1_000..=1_100).contains(&frozen), "{interval}: {frozen}");
    }
    let [stale, frozen] = times_ms(Sensor::Accelerometer, 80, never).map(Option::unwrap);
    assert!(stale == 400 && (1_000..=1_080).contains(&frozen), "{stale} {frozen}");
    // Five equal readings are chance.
    assert_eq!(times_ms(Sensor::Accelerometer, 80, 5), [None; 2]);
    assert_eq!(times_ms(Sensor::Magnetometer, 100, 5), [None; 2]);
}

/// A second in which a sensor is silent is not one in which it repeats itself.
#[test]
fn equal_readings_before_and_after_a_silence_are_not_frozen() {
    let mut checks = ReadingChecks::new(&Config { sample_period_us: 10_000, ..Config::default() });
    let live = Sample { gyro_rad_s: [0.01; 3], accel_m_s2: [0.1, 0.2, -9.8], mag_ut: [20.0; 3], ..Sample::default() };
    let silent = Sample { flags: SampleFlags::MAG_MISSING, ..live };
    for k in 0..600_u16 {
        let mut sample = if (2..500).contains(&k) { silent } else { live };
        let change = f32::from(k) * 1e-3;
        (sample.gyro_rad_s, sample.accel_m_s2) = ([change + 0.01; 3], [change - 9.0; 3]);
        let is_frozen = checks.update(&sample, 0.01);
        assert!(!is_frozen || k > 570, "{k}");
    }
}

/// Reading of a gyro whose noise shows, after 400 samples at 200 Hz about a tool axis that is horizontal or vertical.
/// It turns at 180 rpm; where `dead`, the axis along it reads the same for ever.
fn turned(dead: bool, rate_rad_s: f32, vertical: bool) -> Reading {
    let mut checks = ReadingChecks::new(&Config { sample_period_us: 5_000, ..Config::default() });
    let mut last = Reading::Missing;
    for k in 0..400_u16 {
        let noise = 1e-5 * f32::from(k * 37 % 101) + 1e-5;
        let (sine, cosine) = crate::rotation::sine_and_cosine(rate_rad_s * 0.005 * f32::from(k));
        let gravity = if vertical { [noise, -noise, -9.8] } else { [9.8 * sine, 9.8 * cosine, noise] };
        let along = if dead { 0.011 } else { rate_rad_s + noise };
        let sample = Sample {
            gyro_rad_s: [noise, 0.01 - noise, along],
            accel_m_s2: gravity,
            mag_ut: [20.0 * cosine, -20.0 * sine, 40.0 + noise],
            ..Sample::default()
        };
        checks.update(&sample, 0.005);
        last = checks.rate(sample.gyro_rad_s.into(), &sample);
    }
    last
}

/// Force and field show the turn that the dead axis does not; a good gyro at rest repeats itself, too. Where the tool
/// stands upright the field alone turns, as it does by a magnet: then nothing is told.
#[test]
fn a_dead_axis_along_the_tool_is_found_while_the_string_turns() {
    assert_eq!(turned(true, 18.8, false), Reading::Unusable);
    for (dead, rate_rad_s, vertical) in
        [(false, 18.8, false), (true, 0.0, false), (true, 18.8, true), (false, 18.8, true)]
    {
        let reading = turned(dead, rate_rad_s, vertical);
        assert!(matches!(reading, Reading::Usable(_)), "{dead} {rate_rad_s} {vertical}");
    }
}

/// A gyro whose resolution is coarser than its noise repeats itself on an axis for seconds. Neither a magnet that comes
/// nor a slow turn about another axis makes it a dead one.
#[test]
fn a_coarse_gyro_is_not_dead_by_a_magnet_nor_by_a_slow_turn() {
    for (rate_rad_s, magnet_ut) in [(0.0, 30.0), (0.035, 0.0)] {
        let mut checks = ReadingChecks::new(&Config { sample_period_us: 5_000, ..Config::default() });
        for k in 0..4_000_u16 {
            let noise = 1e-5 * f32::from(k % 101 * 37 % 101) + 1e-5;
            let (sine, cosine) = crate::rotation::sine_and_cosine(rate_rad_s * 0.005 * f32::from(k));
            let sample = Sample {
                gyro_rad_s: [0.001, rate_rad_s + f32::from(k % 2) * 0.001, 0.002 + noise],
                accel_m_s2: [9.8 * sine + noise, 3.0 + noise, 9.8 * cosine],
                mag_ut: [20.0 * cosine + noise, 25.0 + if k > 1_000 { magnet_ut } else { 0.0 }, -20.0 * sine + noise],
                ..Sample::default()
            };
            assert!(!checks.update(&sample, 0.005), "{rate_rad_s} {magnet_ut}: {k}");
            assert!(matches!(checks.rate(sample.gyro_rad_s.into(), &sample), Reading::Usable(_)), "{k}");
        }
    }
}
