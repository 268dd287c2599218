use super::motions::{bias, close, flight, from, report, swing, swing_rate, trace, turn, unturned};
use meerkat_mwd::{SampleFlags, compensation::GyroModel};
use nalgebra::Vector3;
use testbed::{
    flight::Flight,
    score::{Reference, rotation_errors, score},
    trace::Trace,
};

#[test]
fn a_constant_rate_error_turns_by_twice_itself_in_two_seconds() {
    let spin = |t: f64| turn(0.0, 0.0, 90.0 * t);
    let trace = trace(5_000, 21, spin, |_| Vector3::new(0.0, 0.0, 91.5_f64.to_radians()));
    let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap().orientation_2s_rms_deg;
    close(scores.uncompensated, 3.0, 1e-4);
    close(scores.with_effects, 3.0, 1e-4);
}

#[test]
fn an_error_about_one_axis_shows_on_that_axis_with_its_sign() {
    let wrong = Vector3::new(0.0, -1.5_f64.to_radians(), 0.0);
    let trace = trace(5_000, 21, unturned, |_| wrong);
    let errors = rotation_errors(&trace, &flight(&trace, unturned), &from(0));
    assert_eq!(errors.deg.len(), 10);
    for (axis, expected) in errors.about_axes_deg.iter().zip([0.0, -3.0, 0.0]) {
        assert_eq!(axis.len(), errors.deg.len());
        for (_, error) in axis {
            close(error.uncompensated, expected, 1e-4);
        }
    }
}

#[test]
fn a_perfect_gyro_scores_nothing_on_a_motion_about_all_axes() {
    let trace = trace(5_000, 30, swing, swing_rate);
    let scores = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
    // Error that is left: that of the trapezoid between samples 5 ms apart.
    close(scores.orientation_2s_rms_deg.uncompensated, 0.0, 2e-3);
    close(scores.time_alignment_ms, 0.0, 0.02);
}

#[test]
fn models_change_when_their_window_takes_effect_and_only_then() {
    // The gyro reads 1 deg/s too much. Bias only learns 0.5 of it; the fit learns all of it later; a window
    // without a fit and one that never took effect change nothing.
    let trace = trace(5_000, 41, unturned, |_| Vector3::new(0.0, 0.0, 1_f64.to_radians()));
    let mut flight = flight(&trace, unturned);
    flight.reports = vec![
        report(Some(10_000_000), GyroModel::IDENTITY, bias(0.5)),
        report(Some(20_000_000), bias(1.0), bias(0.5)),
        // Report of a filter that has diverged.
        report(Some(30_000_000), GyroModel { p: [[f32::NAN; 3]; 3], ..bias(7.0) }, bias(0.5)),
        report(None, bias(9.0), bias(9.0)),
    ];
    let rotation = |from_us| score(&trace, &flight, &from(from_us)).unwrap().orientation_2s_rms_deg;
    close(rotation(0).uncompensated, 2.0, 1e-5);
    // 20 windows in 41 s, of which 19 count: the five before any bias err by 2 deg; the worst one of those is
    // left out.
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
