use super::ideal::{attitude, files, smooth, vector, without_sensor_errors};
use nalgebra::Vector3;
use testbed::simulate::{Hole, Rotation, Scenario, simulate};

#[test]
fn at_rest_the_readings_give_back_inclination_azimuth_and_toolface() {
    for (inclination_deg, azimuth_deg, toolface_deg) in [(45.0, 60.0, 35.0), (5.0, 300.0, 200.0), (90.0, 180.0, 90.0)] {
        let scenario = without_sensor_errors(Scenario {
            duration_s: 5.0,
            hole: Hole { inclination_deg, azimuth_deg, ..Hole::default() },
            rotation: Rotation { toolface_deg, ..Rotation::default() },
            ..Scenario::default()
        });
        let (trace, _) = simulate(&scenario, 1);
        for sample in &trace.samples {
            let (g, b) = (-vector(sample.accel_m_s2), vector(sample.mag_ut));
            assert_eq!(sample.gyro_rad_s, [0.0; 3]);
            assert!((g.norm() - 9.806_65).abs() < 1e-5);
            // The six-axis formulas of a survey.
            let inclination = g.x.hypot(g.y).atan2(g.z);
            let toolface = g.y.atan2(-g.x);
            let horizontal = g.x * g.x + g.y * g.y;
            let azimuth = ((g.x * b.y - g.y * b.x) * g.norm()).atan2(b.z * horizontal - g.z * (g.x * b.x + g.y * b.y));
            assert!((inclination.to_degrees() - inclination_deg).abs() < 1e-4);
            assert!((toolface.to_degrees().rem_euclid(360.0) - toolface_deg).abs() < 1e-3);
            assert!((azimuth.to_degrees().rem_euclid(360.0) - azimuth_deg).abs() < 1e-3);
            assert!(((g.dot(&b) / (g.norm() * b.norm())).asin().to_degrees() - 65.0).abs() < 1e-4);
        }
    }
}

#[test]
fn the_field_keeps_its_norm_and_points_where_the_attitude_says() {
    for scenario in files() {
        let (trace, _) = simulate(&without_sensor_errors(Scenario { duration_s: 60.0, ..scenario }), 2);
        let dip = 65_f64.to_radians();
        let field_ned = Vector3::new(dip.cos(), 0.0, dip.sin()) * 50.0;
        for (i, sample) in trace.samples.iter().enumerate() {
            // A mean over 10 ms at 360 deg/s: (1.8 deg)^2 / 6 of the turning part.
            assert!((vector(sample.mag_ut).norm() - 50.0).abs() < 0.01);
            assert!((attitude(&trace, i) * vector(sample.mag_ut) - field_ned).norm() < 0.1);
        }
    }
}

#[test]
fn vibration_has_no_mean_in_the_earth_and_gravity_stays() {
    for scenario in files() {
        let (trace, _) = simulate(&scenario, 5);
        let drilling = 2_000..trace.samples.len();
        let n = drilling.len() as f64;
        let mean =
            drilling.map(|i| attitude(&trace, i) * vector(trace.samples[i].accel_m_s2)).sum::<Vector3<f64>>() / n;
        assert!((mean - Vector3::new(0.0, 0.0, -9.806_65)).norm() < 0.02, "{mean}");
    }
}

#[test]
fn shocks_land_in_the_accelerometer_at_their_time() {
    let mut scenario = smooth(without_sensor_errors(Scenario { duration_s: 70.0, ..Scenario::default() }));
    let quiet = simulate(&scenario, 8).0;
    scenario.shocks.per_minute = 20.0;
    scenario.shocks.rebound_ms = 0.0;
    let (shaken, truth) = simulate(&scenario, 8);
    // 20 expected in the minute after the rest.
    assert!((truth.shocks.len() as f64 - 20.0).abs() < 4.0 * 20_f64.sqrt());
    let mut impulse = 0.0;
    for (a, b) in quiet.samples.iter().zip(&shaken.samples) {
        let difference = vector(b.accel_m_s2) - vector(a.accel_m_s2);
        impulse += difference.norm() * 0.01;
        let (from, to) = (a.t_us as f64 * 1e-6 - 0.005, a.t_us as f64 * 1e-6 + 0.005);
        let hit = truth.shocks.iter().any(|s| s.start_s < to && s.start_s + s.length_s > from);
        assert_eq!(difference.norm() > 0.0, hit, "at {from}");
    }
    let half_sine = 2.0 / std::f64::consts::PI;
    let expected: f64 = truth.shocks.iter().map(|s| Vector3::from(s.peak_m_s2).norm() * s.length_s * half_sine).sum();
    assert!((impulse / expected - 1.0).abs() < 0.01, "{impulse} {expected}");
}

#[test]
fn a_lever_arm_adds_the_centripetal_and_tangential_acceleration() {
    let steady = Rotation { stick_slip: 0.0, ..Rotation::default() };
    let mut scenario =
        smooth(without_sensor_errors(Scenario { duration_s: 30.0, rotation: steady, ..Scenario::default() }));
    let centred = simulate(&scenario, 1).0;
    scenario.effects.lever_arm_mm = [20.0, 0.0, 300.0];
    let off_centre = simulate(&scenario, 1).0;
    let added = |i: usize| vector(off_centre.samples[i].accel_m_s2) - vector(centred.samples[i].accel_m_s2);
    let speed = std::f64::consts::PI;
    // Steady: inwards, w^2 r.
    let steady = added(2_500) - Vector3::new(-speed * speed * 0.02, 0.0, 0.0);
    assert!(steady.norm() < 1e-3, "{steady}");
    // In the middle of the ramp w' = 1.5 w / ramp, and w is half of the full speed; z x (x r) = y.
    let ramp = added(1_150) - Vector3::new(-0.25 * speed * speed * 0.02, 1.5 * speed / 3.0 * 0.02, 0.0);
    assert!(ramp.norm() < 1e-3, "{ramp}");
}
