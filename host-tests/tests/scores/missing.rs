use super::motions::{close, flight, from, still, swing, trace, unturned};
use nalgebra::Vector3;
use testbed::{
    flight::Flight,
    score::{self, score},
};

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
