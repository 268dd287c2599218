//! Scores against closed forms: motions whose error is known by construction.
#![allow(clippy::unwrap_used)]

use meerkat_mwd::{
    Sample, SampleFlags,
    attitude::{Attitude, AttitudeFlags},
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, Refusal, WindowReport},
    probe::Output,
};
use mwd::{
    flight::Flight,
    score::{self, Reference, Settings, score},
    trace::{EarthFrame, Trace},
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

type Q = UnitQuaternion<f64>;

/// Only samples from `from_us` on, nothing calibrated, no declination.
fn from(from_us: u64) -> Settings {
    Settings { from_us, ..Settings::default() }
}

fn turn(x_deg: f64, y_deg: f64, z_deg: f64) -> Q {
    UnitQuaternion::from_scaled_axis(Vector3::new(x_deg, y_deg, z_deg).map(f64::to_radians))
}

fn cells(q: &Q) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// A trace at `period_us` with the given attitude (body to NED) and gyro reading (rad/s), both functions of seconds.
fn trace(period_us: u64, seconds: u64, attitude: impl Fn(f64) -> Q, gyro: impl Fn(f64) -> Vector3<f64>) -> Trace {
    let mut trace = Trace::default();
    for i in 0..=seconds * 1_000_000 / period_us {
        let t_us = i * period_us;
        let t_s = t_us as f64 * 1e-6;
        let up = attitude(t_s).inverse() * Vector3::new(0.0, 0.0, -9.806_65);
        trace.samples.push(Sample {
            t_us,
            gyro_rad_s: gyro(t_s).map(|x| x as f32).into(),
            accel_m_s2: up.map(|x| x as f32).into(),
            ..Sample::default()
        });
        trace.reference.push(Some(cells(&attitude(t_s))));
    }
    trace
}

/// A flight of the raw gyro whose attitude is `error` (in the NED frame) times the reference's.
fn flight(trace: &Trace, error: impl Fn(f64) -> Q) -> Flight {
    let outputs = trace.samples.iter().zip(&trace.reference).map(|(sample, reference)| {
        let [w, x, y, z] = reference.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let q = error(sample.t_us as f64 * 1e-6) * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let attitude = Attitude {
            q: cells(&q).map(|x| x as f32),
            inclination_rad: 0.0,
            azimuth_rad: 0.0,
            gravity_toolface_rad: 0.0,
            magnetic_toolface_rad: 0.0,
            sigma_inclination_rad: 0.0,
            sigma_azimuth_rad: 0.0,
            sigma_toolface_rad: 0.0,
            flags: AttitudeFlags::default(),
        };
        Output { t_us: sample.t_us, rate_rad_s: sample.gyro_rad_s, attitude: Some(attitude) }
    });
    Flight { outputs: outputs.collect(), ..Flight::default() }
}

fn unturned(_: f64) -> Q {
    Q::identity()
}

fn still(_: f64) -> Vector3<f64> {
    Vector3::zeros()
}

fn report(t_effect_us: Option<u64>, fitted: GyroModel, bias_only: GyroModel, cost_after: Option<f32>) -> WindowReport {
    WindowReport {
        t_start_us: 0,
        t_end_us: 0,
        t_effect_us,
        decision: Decision::Refused(Refusal::Degenerate),
        optimizer: OptimizerKind::Imoa,
        evaluations: 0,
        cost_before: cost_after,
        cost_after,
        fitted,
        bias_only,
        flown: GyroModel::IDENTITY,
        sigma: [0.0; 12],
        observable: [false; 12],
        rank: 0,
        rest_s: 0.0,
        explained: None,
        p_value: None,
    }
}

fn bias(z_deg_s: f64) -> GyroModel {
    GyroModel { b_rad_s: [0.0, 0.0, z_deg_s.to_radians() as f32], ..GyroModel::IDENTITY }
}

/// A motion about all axes at up to 200 deg/s.
fn swing(t: f64) -> Q {
    turn(60.0 * (1.9 * t).sin(), 0.0, 0.0)
        * turn(0.0, 40.0 * (1.3 * t).sin(), 0.0)
        * turn(0.0, 0.0, 90.0 * (0.7 * t).sin())
}

/// Its body rate, by a central difference of the attitude.
fn swing_rate(t: f64) -> Vector3<f64> {
    let half = 1e-4;
    (swing(t - half).inverse() * swing(t + half)).scaled_axis() / (2.0 * half)
}

fn close(value: Option<f64>, expected: f64, tolerance: f64) {
    let value = value.unwrap();
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

#[test]
fn a_constant_rate_error_turns_by_twice_itself_in_two_seconds() {
    let spin = |t: f64| turn(0.0, 0.0, 90.0 * t);
    let trace = trace(5_000, 21, spin, |_| Vector3::new(0.0, 0.0, 91.5_f64.to_radians()));
    let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap().orientation_2s_rms_deg;
    close(scores.uncompensated, 3.0, 1e-4);
    close(scores.with_effects, 3.0, 1e-4);
}

#[test]
fn a_perfect_gyro_scores_nothing_on_a_motion_about_all_axes() {
    let trace = trace(5_000, 30, swing, swing_rate);
    let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
    // What is left is the trapezoid between samples 5 ms apart.
    close(scores.orientation_2s_rms_deg.uncompensated, 0.0, 2e-3);
    close(scores.time_alignment_ms, 0.0, 0.02);
}

#[test]
fn a_pure_delay_is_found_to_a_tenth_of_a_millisecond_and_taken_out() {
    for delay_s in [0.004, -0.0073, 0.015] {
        let trace = trace(3_500, 60, swing, |t| swing_rate(t - delay_s));
        let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
        close(scores.time_alignment_ms, delay_s * 1e3, 0.1);
        assert!(scores.orientation_2s_rms_deg.bias_only.unwrap() > 0.2);
        close(scores.orientation_2s_rms_time_aligned_deg.bias_only, 0.0, 2e-3);
    }
}

#[test]
fn the_delay_is_found_on_a_good_reading_where_the_raw_gyro_is_off_by_percents() {
    let mut trace = trace(3_500, 60, swing, |t| swing_rate(t - 0.004));
    let truth = mwd::known_error::draw(5);
    mwd::known_error::apply(&mut trace, &truth);
    let mut flight = flight(&trace, unturned);
    for output in &mut flight.outputs {
        output.rate_rad_s = truth.compensate(output.rate_rad_s).into();
    }
    let scores = score(&trace, &flight, &from(0)).unwrap();
    close(scores.time_alignment_ms, 4.0, 0.1);
    close(scores.orientation_2s_rms_time_aligned_deg.with_effects, 0.0, 2e-3);
    assert!(scores.orientation_2s_rms_time_aligned_deg.bias_only.unwrap() > 2.0);
}

#[test]
fn a_delay_beyond_the_range_is_no_delay() {
    let trace = trace(3_500, 60, swing, |t| swing_rate(t - 0.03));
    let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
    assert_eq!(scores.time_alignment_ms, None);
    assert_eq!(scores.orientation_2s_rms_time_aligned_deg, score::PerModel::default());
    assert!(scores.orientation_2s_rms_deg.bias_only.unwrap() > 1.0);
}

#[test]
fn a_lag_that_the_flight_took_out_counts_in_the_raw_score_and_is_not_taken_out_twice() {
    let trace = trace(3_500, 60, swing, |t| swing_rate(t - 0.0035));
    let mut flight = flight(&trace, unturned);
    for output in &mut flight.outputs {
        output.t_us = output.t_us.wrapping_sub(3_500);
    }
    // The first reading's validity would lie before the trace began.
    if let Some(first) = flight.outputs.first_mut() {
        first.t_us = 0;
    }
    let scores = score(&trace, &flight, &from(3_500)).unwrap();
    close(scores.orientation_2s_rms_deg.with_effects, 0.0, 2e-3);
    assert!(scores.orientation_2s_rms_deg.bias_only.unwrap() > 0.2);
    close(scores.orientation_2s_rms_time_aligned_deg.with_effects, 0.0, 2e-3);
    close(scores.orientation_2s_rms_time_aligned_deg.bias_only, 0.0, 2e-3);
}

#[test]
fn models_change_when_their_window_takes_effect_and_only_then() {
    // The gyro reads 1 deg/s too much. Bias only learns 0.5 of it; the fit learns all of it later; a window without a fit and one
    // that never took effect change nothing.
    let trace = trace(5_000, 41, unturned, |_| Vector3::new(0.0, 0.0, 1_f64.to_radians()));
    let mut flight = flight(&trace, unturned);
    flight.reports = vec![
        report(Some(10_000_000), GyroModel::IDENTITY, bias(0.5), None),
        report(Some(20_000_000), bias(1.0), bias(0.5), Some(1.0)),
        report(Some(30_000_000), bias(7.0), bias(0.5), None),
        report(None, bias(9.0), bias(9.0), Some(1.0)),
    ];
    let rotation = |from_us| score(&trace, &flight, &from(from_us)).unwrap().orientation_2s_rms_deg;
    close(rotation(0).uncompensated, 2.0, 1e-5);
    // 20 windows in 41 s, of which 19 count: the five before any bias err by 2 deg; the worst one of those is left out.
    close(rotation(0).bias_only, ((4.0 * 4.0 + 15.0) / 19.0_f64).sqrt(), 2e-3);
    close(rotation(10_000_000).bias_only, 1.0, 1e-5);
    close(rotation(10_000_000).twelve_parameters, ((4.0 * 4.0) / 14.0_f64).sqrt(), 2e-3);
    close(rotation(20_000_000).twelve_parameters, 0.0, 1e-4);
    close(rotation(20_000_000).with_effects, 2.0, 1e-5);
}

#[test]
fn windows_outside_the_movement_without_a_reference_or_across_a_gap_do_not_count() {
    // The gyro is wrong from 10 s on.
    let wrong = |t: f64| Vector3::new(0.0, 0.0, if t < 10.0 { 0.0 } else { 1_f64.to_radians() });
    let whole = trace(5_000, 21, unturned, wrong);
    let flown = flight(&whole, unturned);
    let uncompensated =
        |trace: &Trace, flight: &Flight| score(trace, flight, &from(0)).unwrap().orientation_2s_rms_deg.uncompensated;
    assert!(uncompensated(&whole, &flown).unwrap() > 1.0);

    let early: Vec<bool> = whole.samples.iter().map(|s| s.t_us < 10_000_000).collect();
    let masked = Trace { movement: Some(early.clone()), ..whole.clone() };
    close(uncompensated(&masked, &flown), 0.0, 1e-9);

    // One missing cell a second from 10 s on leaves no complete window there.
    let mut holes = whole.clone();
    for (sample, cell) in holes.samples.iter().zip(&mut holes.reference) {
        if sample.t_us >= 10_000_000 && sample.t_us % 1_000_000 == 0 {
            *cell = None;
        }
    }
    close(uncompensated(&holes, &flown), 0.0, 1e-9);

    // A gyro that is gone for 20 ms a second is a gap; for one sample it is not.
    let mut dropouts = whole.clone();
    for sample in &mut dropouts.samples {
        if sample.t_us >= 10_000_000 && sample.t_us % 1_000_000 < 20_000 {
            sample.flags |= SampleFlags::GYRO_MISSING;
        }
    }
    close(uncompensated(&dropouts, &flown), 0.0, 1e-9);
    let mut one = whole.clone();
    for sample in &mut one.samples {
        if sample.t_us % 1_000_000 == 0 {
            sample.flags |= SampleFlags::GYRO_MISSING;
        }
    }
    assert!(uncompensated(&one, &flown).unwrap() > 1.0);

    let nothing = Trace { movement: Some(vec![false; whole.samples.len()]), ..whole };
    assert_eq!(score(&nothing, &flown, &from(0)), Some(Reference::default()));
}

#[test]
fn a_heading_offset_is_all_heading_and_a_tilt_is_all_inclination() {
    let trace = trace(10_000, 10, swing, swing_rate);
    let heading = score(&trace, &flight(&trace, |_| turn(0.0, 0.0, -12.0)), &from(0)).unwrap().attitude_rms_deg;
    close(heading.total, 12.0, 1e-4);
    close(heading.heading, 12.0, 1e-4);
    close(heading.inclination, 0.0, 1e-4);
    let tilt = score(&trace, &flight(&trace, |_| turn(3.0, 4.0, 0.0)), &from(0)).unwrap().attitude_rms_deg;
    close(tilt.total, 5.0, 1e-4);
    close(tilt.heading, 0.0, 1e-4);
    close(tilt.inclination, 5.0, 1e-4);
    // Half of the samples 10 deg off: root mean square, not mean.
    let half = |t: f64| turn(0.0, 0.0, if t < 5.0 { 10.0 } else { 0.0 });
    close(score(&trace, &flight(&trace, half), &from(0)).unwrap().attitude_rms_deg.heading, 50_f64.sqrt(), 1e-2);
    close(score(&trace, &flight(&trace, half), &from(5_000_000)).unwrap().attitude_rms_deg.heading, 0.0, 1e-4);
}

#[test]
fn a_reference_in_east_north_up_scores_as_one_in_north_east_down() {
    let ned = trace(10_000, 10, swing, |t| swing_rate(t) * 1.01);
    let flown = flight(&ned, |t| turn(2.0, 1.0, 5.0 * t));
    // v_enu = (v_ned.y, v_ned.x, -v_ned.z), written as a matrix and turned into a quaternion apart from the scorer's own.
    let swap = nalgebra::Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    let ned_to_enu = UnitQuaternion::from_matrix(&swap);
    let mut enu = ned.clone();
    enu.keys.earth_frame = EarthFrame::Enu;
    for cell in enu.reference.iter_mut().flatten() {
        let [w, x, y, z] = *cell;
        *cell = cells(&(ned_to_enu * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))));
    }
    let (a, b) = (score(&ned, &flown, &from(0)).unwrap(), score(&enu, &flown, &from(0)).unwrap());
    close(a.attitude_rms_deg.total, b.attitude_rms_deg.total.unwrap(), 1e-6);
    close(a.attitude_rms_deg.heading, b.attitude_rms_deg.heading.unwrap(), 1e-6);
    close(a.attitude_rms_deg.inclination, b.attitude_rms_deg.inclination.unwrap(), 1e-6);
    close(a.orientation_2s_rms_deg.with_effects, b.orientation_2s_rms_deg.with_effects.unwrap(), 1e-6);
    // Taken for NED, the same columns are more than a right angle off.
    enu.keys.earth_frame = EarthFrame::Ned;
    assert!(score(&enu, &flown, &from(0)).unwrap().attitude_rms_deg.total.unwrap() > 90.0);
}

#[test]
fn true_and_magnetic_north_differ_by_the_declination() {
    let mut trace = trace(10_000, 4, swing, swing_rate);
    let heading = |trace: &Trace, flight: &Flight, settings: &Settings| {
        score(trace, flight, settings).unwrap().attitude_rms_deg.heading
    };
    // The flight counts from true north: 7 deg more azimuth than the magnetic reference.
    let true_north = flight(&trace, |_| turn(0.0, 0.0, 7.0));
    let configured = Settings { declination_deg: Some(7.0), ..Settings::default() };
    close(heading(&trace, &true_north, &configured), 0.0, 1e-4);
    close(heading(&trace, &true_north, &Settings::default()), 7.0, 1e-4);
    trace.keys.magnetic_declination_deg = Some(7.0);
    // A reference that counts from true north itself.
    trace.keys.reference_north = true;
    let same = flight(&trace, unturned);
    close(heading(&trace, &same, &configured), 0.0, 1e-4);
    // A magnetic flight against it, with the declination known and unknown.
    let magnetic = flight(&trace, |_| turn(0.0, 0.0, -7.0));
    close(heading(&trace, &magnetic, &Settings::default()), 0.0, 1e-4);
    trace.keys.magnetic_declination_deg = None;
    assert_eq!(heading(&trace, &magnetic, &Settings::default()), None);
    close(score(&trace, &magnetic, &from(0)).unwrap().attitude_rms_deg.inclination, 0.0, 1e-4);
}

/// Rest, a turn about one body axis from 2 to 4 s by 80 deg, rest, and from 6 to 8 s back.
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
    let accel =
        meerkat_mwd::compensation::VectorModel { offset: [0.7; 3], ..meerkat_mwd::compensation::VectorModel::IDENTITY };
    let calibrated = score(&trace, &flown, &Settings { accel, ..Settings::default() }).unwrap();
    close(calibrated.rest_gravity_deg.uncompensated, 0.0, 0.01);
    assert!(score(&trace, &flown, &from(0)).unwrap().rest_gravity_deg.uncompensated.unwrap() > 2.0);
}

#[test]
fn without_reference_and_rests_there_is_no_score() {
    let mut trace = trace(10_000, 5, swing, still);
    let flown = flight(&trace, unturned);
    trace.reference.iter_mut().for_each(|cell| *cell = None);
    assert_eq!(score(&trace, &flown, &from(0)), None);
    trace.reference.clear();
    trace.rest = Some(vec![false; trace.samples.len()]);
    assert_eq!(score(&trace, &flown, &from(0)), None);
}

#[test]
fn what_the_flight_did_not_give_is_null_and_the_rest_is_scored() {
    let trace = trace(5_000, 11, unturned, |_| Vector3::new(0.0, 0.0, 1_f64.to_radians()));
    let scores = score(&trace, &Flight::default(), &from(0)).unwrap();
    assert_eq!(scores.orientation_2s_rms_deg.with_effects, None);
    close(scores.orientation_2s_rms_deg.uncompensated, 2.0, 1e-5);
    assert_eq!(scores.attitude_rms_deg, score::AttitudeRms::default());
    let json = serde_json::to_value(scores).unwrap();
    assert!(json["orientation_2s_rms_deg"]["with_effects"].is_null());
    assert!(json["time_alignment_ms"].is_null());
}

#[test]
fn systematic_rate_error_is_the_algebra_of_the_two_models() {
    let rates = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -2.0]];
    let error =
        |truth: &GyroModel, estimate: &GyroModel| score::systematic_rate_error_rad_s(truth, estimate, &rates).unwrap();
    let truth = mwd::known_error::draw(1);
    assert!(error(&truth, &truth) < 1e-7);
    // A bias on one axis of three.
    assert!((error(&bias(3.0), &GyroModel::IDENTITY) - 3_f64.to_radians() / 3_f64.sqrt()).abs() < 1e-7);
    // Half of every rate is read: P = 2 I. Rms of the rates over 9 values is 1.
    let half = GyroModel { p: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], b_rad_s: [0.0; 3] };
    assert!((error(&half, &GyroModel::IDENTITY) - 0.5).abs() < 1e-12);
    assert_eq!(score::systematic_rate_error_rad_s(&truth, &truth, &[]), None);
    close(score::rate_error_rad_s(&[[1.0, 0.0, 0.0]], &[[0.0, 0.0, 0.0]]), 1.0 / 3_f64.sqrt(), 1e-12);
}
