use super::motions::{close, flight, from, trace, turn, unturned};
use meerkat_mwd::compensation::VectorModel;
use nalgebra::Vector3;
use testbed::{
    score::{self, Settings, score},
    trace::Trace,
};

/// Rest, a turn about one body axis by 80 deg from 2 to 4 s, rest, and back from 6 to 8 s.
fn rests(axis: Vector3<f64>, scale: f64) -> Trace {
    let rate = move |t: f64| {
        let deg_s = if (2.0..4.0).contains(&t) {
            40.0
        } else if (6.0..8.0).contains(&t) {
            -40.0
        } else {
            0.0
        };
        axis * f64::to_radians(deg_s)
    };
    let angle = move |t: f64| 40.0 * (t.clamp(2.0, 4.0) - 2.0) - 40.0 * (t.clamp(6.0, 8.0) - 6.0);
    let attitude = move |t: f64| {
        let angle = axis * angle(t);
        turn(angle.x, angle.y, angle.z)
    };
    let mut trace = trace(10_000, 10, attitude, move |t| rate(t) * scale);
    trace.rest = Some(trace.samples.iter().map(|s| rate(s.t_us as f64 * 1e-6).norm() == 0.0).collect());
    trace.reference.clear();
    trace
}

#[test]
fn gravity_from_rest_to_rest_sees_a_scale_error_about_a_horizontal_axis_and_none_about_the_vertical() {
    let horizontal = rests(Vector3::x(), 1.05);
    let scores = score(&horizontal, &flight(&horizontal, unturned), &from(0)).unwrap();
    close(scores.rest_gravity_deg.uncompensated, 4.0, 0.02);
    assert_eq!(scores.orientation_2s_rms_deg, score::PerModel::default());
    assert_eq!(scores.attitude_rms_deg, score::AttitudeRms::default());
    let vertical = rests(Vector3::z(), 1.05);
    close(score(&vertical, &flight(&vertical, unturned), &from(0)).unwrap().rest_gravity_deg.uncompensated, 0.0, 1e-3);
    // A rest of 0.4 s is no rest: one leg remains from 5 s on, and none from 5.7 s on.
    close(
        score(&horizontal, &flight(&horizontal, unturned), &from(5_000_000)).unwrap().rest_gravity_deg.bias_only,
        4.0,
        0.03,
    );
    let short = score(&horizontal, &flight(&horizontal, unturned), &from(5_600_000)).unwrap();
    assert_eq!(short.rest_gravity_deg, score::PerModel::default());
}

#[test]
fn an_accelerometer_calibration_is_used_at_rests() {
    let mut trace = rests(Vector3::x(), 1.0);
    for sample in &mut trace.samples {
        sample.accel_m_s2 = sample.accel_m_s2.map(|x| x + 0.7);
    }
    let flown = flight(&trace, unturned);
    let accel = VectorModel { offset: [0.7; 3], ..VectorModel::IDENTITY };
    let calibrated = score(&trace, &flown, &Settings { accel, ..Settings::default() }).unwrap();
    close(calibrated.rest_gravity_deg.uncompensated, 0.0, 0.01);
    assert!(score(&trace, &flown, &from(0)).unwrap().rest_gravity_deg.uncompensated.unwrap() > 2.0);
}
