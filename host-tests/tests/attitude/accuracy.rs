//! Accuracy of the attitude filter on a known motion, and whether its sigmas are right.

use crate::simulation::{Correlated, Noise, Truth, apart, feed};
use meerkat_mwd::{
    attitude::{AttitudeFilter, AttitudeFlags},
    config::{AttitudeConfig, Earth, Motion},
};
use nalgebra::Vector3;

const DT_S: f64 = 0.005;

fn started(config: &AttitudeConfig) -> AttitudeFilter {
    let mut filter = AttitudeFilter::new();
    filter.start(config, &Earth::default(), Motion::DrillString);
    filter
}

#[test]
fn still_probe_aligns_in_every_direction() {
    for (a, i, t) in
        [(0.0, 0.0, 40.0), (30.0, 3.0, 0.0), (123.0, 45.0, 250.0), (300.0, 90.0, 10.0), (200.0, 150.0, 95.0)]
    {
        let truth = Truth::at(a, i, t);
        let mut filter = started(&AttitudeConfig::default());
        let mut last = None;
        for step in 0..400 {
            last = feed(
                &mut filter,
                DT_S,
                &Vector3::zeros(),
                Some(truth.force(&Vector3::zeros())),
                Some(truth.field(65.0, 0.0)),
            );
            assert!(last.is_some(), "aligned by the first reading, {step}");
        }
        let last = last.unwrap();
        assert!(truth.tilt_error_rad(&last) < 2e-5);
        assert!(apart(last.magnetic_toolface_rad.into(), truth.magnetic_toolface_rad()).abs() < 1e-4);
        if i > 1.0 {
            assert!(apart(last.azimuth_rad.into(), a.to_radians()).abs() < 1e-4, "{a} {i} {t} {last:?}");
            assert!(apart(last.gravity_toolface_rad.into(), t.to_radians()).abs() < 1e-4);
        }
        assert_eq!(last.flags.contains(AttitudeFlags::NEAR_VERTICAL), i < 5.0);
        assert!(
            !last.flags.intersects(AttitudeFlags::NO_HEADING | AttitudeFlags::ACCEL_UNUSED | AttitudeFlags::MAG_UNUSED)
        );
    }
}

/// Squared errors over variances after 60 s of one simulated run: inclination and azimuth.
fn normalised_errors(seed: u64) -> [f64; 2] {
    let config = AttitudeConfig { gyro_scale_sigma: 1e-4, accel_sigma_m_s2: 1e-4, ..AttitudeConfig::default() };
    let mut noise = Noise::new(seed);
    let mut truth = Truth::at(40.0, 35.0, 100.0);
    let bias = noise.vector() * 0.005;
    let mut velocity = Correlated::new(&mut noise, f64::from(config.velocity_sigma_m_s), 0.3);
    let mut heading = Correlated::new(&mut noise, f64::from(config.mag_sigma_rad) / 60.0_f64.to_radians().cos(), 3.0);
    let mut filter = started(&config);
    let white = f64::from(config.gyro_noise_rad_s_rthz) / DT_S.sqrt();
    let mut last = None;
    for step in 0..12_000 {
        let t = f64::from(step) * DT_S;
        let rate = Vector3::new(0.3 * (0.7 * t).sin(), 0.2 * (1.1 * t).cos(), 0.5 * (0.3 * t).sin());
        truth.turn(&rate, DT_S);
        let before = velocity.value;
        velocity.step(&mut noise, DT_S);
        heading.step(&mut noise, DT_S);
        let reading = rate + bias + noise.vector() * white;
        let force = truth.force(&((velocity.value - before) / DT_S));
        last = feed(&mut filter, DT_S, &reading, Some(force), Some(truth.field(60.0, heading.value.x)));
    }
    let a = last.unwrap();
    let inclination = (f64::from(a.inclination_rad) - truth.inclination_rad()) / f64::from(a.sigma_inclination_rad);
    let azimuth = apart(a.azimuth_rad.into(), truth.azimuth_rad()) / f64::from(a.sigma_azimuth_rad);
    [inclination * inclination, azimuth * azimuth]
}

#[test]
fn errors_are_as_large_as_the_sigmas_say() {
    let runs = 40;
    let mut sums = [0.0; 2];
    for seed in 0..runs {
        let e = normalised_errors(seed);
        sums = [sums[0] + e[0], sums[1] + e[1]];
    }
    // Chi-square with 40 degrees of freedom, 99 %: 20.7 to 66.8.
    assert!((20.7..66.8).contains(&sums[0]), "inclination {sums:?}");
    // The azimuth's sigma has a part that does not average out, so it is only bounded from above.
    assert!((4.0..66.8).contains(&sums[1]), "azimuth {sums:?}");
}

/// Root mean square errors, degrees: tilt, magnetic toolface, over the last two thirds of a simulated minute
/// of drilling at 100 Hz with stick-slip, lateral vibration and shocks.
fn drilling(inclination_deg: f64, gyro_error: f64, seed: u64) -> [f64; 2] {
    let dt_s = 0.01;
    let mut noise = Noise::new(seed);
    let mut truth = Truth::at(60.0, inclination_deg, 0.0);
    let mut filter = started(&AttitudeConfig::default());
    let mut sums = [0.0; 2];
    let (mut before, mut blow_before) = (Vector3::zeros(), Vector3::zeros());
    for step in 0..6_000 {
        let t = f64::from(step) * dt_s;
        // The string sticks and slips; a reading is the mean over its interval.
        let mut mean = Vector3::zeros();
        for part in 0..10 {
            let tau = t + f64::from(part) * dt_s / 10.0;
            let axial = if t < 10.0 { 0.0 } else { 8.0 * (1.0 - (1.5 * tau).cos()) };
            let rate = Vector3::new(0.05 * (9.0 * tau).sin(), 0.05 * (11.0 * tau).cos(), axial);
            truth.turn(&rate, dt_s / 10.0);
            mean += rate / 10.0;
        }
        let velocity = Vector3::new((220.0 * t).sin(), (190.0 * t).cos(), 0.3 * (301.0 * t).sin()) * 0.05;
        // a blow and its rebound
        let blow = match step % 317 {
            0 => noise.vector() * 40.0,
            1 => -blow_before,
            _ => Vector3::zeros(),
        };
        blow_before = blow;
        let force = truth.force(&((velocity - before) / dt_s + blow)) + noise.vector() * 0.05;
        before = velocity;
        let field = truth.field(70.0, 0.0) + noise.vector() * 0.3;
        let reading = mean * (1.0 + gyro_error) + noise.vector() * 0.002;
        let a = feed(&mut filter, dt_s, &reading, Some(force), Some(field)).unwrap();
        if t > 20.0 {
            sums[0] += truth.tilt_error_rad(&a).powi(2);
            sums[1] += apart(a.magnetic_toolface_rad.into(), truth.magnetic_toolface_rad()).powi(2);
        }
    }
    sums.map(|s| (s / 4_000.0).sqrt().to_degrees())
}

#[test]
fn drilling_with_stick_slip_vibration_and_shocks() {
    for (inclination_deg, gyro_error, tilt_deg, toolface_deg) in
        [(0.0, 0.0, 0.5, 1.5), (45.0, 0.0, 0.5, 1.5), (0.0, 0.002, 0.5, 3.0), (45.0, 0.002, 0.7, 3.0)]
    {
        for seed in 0..3 {
            let [tilt, toolface] = drilling(inclination_deg, gyro_error, seed);
            assert!(tilt < tilt_deg && toolface < toolface_deg, "{inclination_deg} {gyro_error} {tilt} {toolface}");
        }
    }
}
