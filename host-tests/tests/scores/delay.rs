use super::motions::{close, flight, from, swing, swing_rate, trace, unturned};
use testbed::score::{self, score};

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
    let truth = testbed::simulate::known_error::draw(5);
    testbed::simulate::known_error::apply(&mut trace, &truth);
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

/// The first sample behind a long gap is refused: it has no output, and all others keep their own sample's time.
#[test]
fn a_refused_sample_moves_no_output_to_another_samples_time() {
    let mut trace = trace(3_500, 60, swing, |t| swing_rate(t - 0.0035));
    for sample in trace.samples.iter_mut().filter(|sample| sample.t_us >= 30_000_000) {
        sample.t_us += 11_000_000;
    }
    let place = trace.samples.iter().position(|sample| sample.t_us >= 41_000_000).unwrap();
    let mut flight = flight(&trace, unturned);
    flight.outputs.remove(place);
    flight.outputs.iter_mut().for_each(|output| output.t_us = output.t_us.saturating_sub(3_500));
    flight.refused = vec![(place, trace.samples[place].t_us)];
    assert_eq!(flight.by_sample().count(), trace.samples.len());
    assert!(flight.by_sample().nth(place).unwrap().is_none());
    let scores = score(&trace, &flight, &from(3_500)).unwrap();
    close(scores.time_alignment_ms, 3.5, 0.1);
    close(scores.orientation_2s_rms_time_aligned_deg.with_effects, 0.0, 2e-3);
    close(scores.orientation_2s_rms_time_aligned_deg.bias_only, 0.0, 2e-3);
}

/// Both scores are over the windows that are there with the delay and without: here the last one, which ends with the
/// last sample and of which the reference is wrong, is there only without.
#[test]
fn a_delay_leaves_the_windows_that_are_scored() {
    let mut trace = trace(3_500, 60, swing, |t| swing_rate(t - 0.004));
    // Thirty windows of 571 steps each.
    trace.samples.truncate(30 * 571 + 1);
    trace.reference.truncate(30 * 571 + 1);
    let clean = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
    if let Some(last) = trace.reference.last_mut() {
        *last = Some([0.0, 1.0, 0.0, 0.0]);
    }
    let wrong = score(&trace, &flight(&trace, unturned), &from(0)).unwrap();
    assert!(wrong.time_alignment_ms.is_some());
    assert_eq!(wrong.orientation_2s_rms_deg, clean.orientation_2s_rms_deg);
}
