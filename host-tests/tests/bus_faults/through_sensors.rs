//! The same recording through the register models and directly.

use crate::rig::files::{ATTACHED_MAGNET, FAST_ROTATION, recording};
use meerkat_mwd::SampleFlags;
use testbed::{
    flight::{
        configuration,
        through_sensors::{Difference, QuantisationBound, differences, each_field_once, play},
    },
    simulate::simulate,
    study::one_window,
    trace::Trace,
};

/// Motion by hand, with a magnetometer whose readings come with every sample.
#[test]
fn a_recording_through_the_models_has_the_same_attitude_within_the_quantisation_bound() {
    let trace = recording(FAST_ROTATION);
    within_the_bound(&trace, 200);
}

#[test]
fn so_has_simulated_drilling() {
    let mut scenario = one_window::scenario("drilling_45deg").unwrap();
    scenario.duration_s = 60.0;
    within_the_bound(&simulate(&scenario, 5).0, 200);
}

/// If an uncalibrated gyro's bias is at the limit of rest, rounding decides whether one flight sees rest
/// earlier; from then on they know different things, and the attitudes differ by as much as the sigmas said.
#[test]
fn and_so_has_a_vertical_hole_while_both_decide_the_same() {
    let mut scenario = one_window::scenario("drilling_vertical").unwrap();
    scenario.duration_s = 60.0;
    let undecided = [1, 31, 34].map(|seed| {
        let difference = within_the_bound(&simulate(&scenario, seed).0, 50);
        assert!(difference.undecided_deviations < 3.0, "{difference:?}");
        difference.undecided
    });
    assert!(
        undecided.iter().any(|samples| *samples > 0) && undecided.iter().all(|samples| *samples < 2_000),
        "{undecided:?}"
    );
}

/// A recorder that notes its accelerometer with every sixth sample, as no part with a FIFO does: the model
/// converts values between.
#[test]
fn a_recording_that_lacks_readings_loses_none_of_the_others() {
    let trace = recording(ATTACHED_MAGNET);
    let lacking = trace.samples.iter().filter(|sample| sample.flags.contains(SampleFlags::ACCEL_MISSING)).count();
    assert!(lacking * 2 > trace.samples.len());
    within_the_bound(&trace, 200);
}

/// One in this many readings may be refused: near zero an axis reads what a dead one does.
fn within_the_bound(trace: &Trace, of_readings: usize) -> Difference {
    let config = configuration::of_trace(trace);
    let recorded = each_field_once(&trace.samples);
    let played = play(&recorded, config.sample_period_us);
    let differences = differences(&config, &recorded, &played.samples).unwrap();
    let Difference { largest_deg, .. } = differences.quantisation;
    let bound = QuantisationBound::new(&config, recorded.len());
    println!("{differences:?}; {bound:?}; flagged {:?} {:?}", played.flagged, played.counters);
    assert!(largest_deg < bound.total_deg(), "{largest_deg} deg, bound {}", bound.total_deg());
    assert_eq!(played.counts.lost, 0);
    assert!(played.counts.stamp_error_us <= 1_000, "{:?}", played.counts);
    // The recorder's magnetometer repeats and interpolates, which a part's does not.
    let [gyro, accel, mag] = played.flagged;
    assert!(gyro.max(accel) * of_readings < recorded.len() && mag * 5 < recorded.len(), "{:?}", played.flagged);
    // Codes, not the recording: half a code of each range, on every sample.
    let half_codes = [0.0351_f32.to_radians(), 0.000_245 * 9.81, 0.055];
    for (through, recorded) in played.samples.iter().zip(&recorded) {
        assert_eq!(through.t_us, recorded.t_us);
        let sensors = [
            (through.gyro_rad_s, recorded.gyro_rad_s, SampleFlags::GYRO_MISSING),
            (through.accel_m_s2, recorded.accel_m_s2, SampleFlags::ACCEL_MISSING),
            (through.mag_ut, recorded.mag_ut, SampleFlags::MAG_MISSING),
        ];
        for ((a, b, missing), half) in sensors.into_iter().zip(half_codes) {
            let believed = !through.flags.contains(missing);
            assert!(
                !believed || (0..3).all(|axis| (a[axis] - b[axis]).abs() <= half + 0.002 * b[axis].abs()),
                "{a:?} {b:?}"
            );
        }
    }
    differences.quantisation
}
