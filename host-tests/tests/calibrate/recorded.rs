//! Two real, uncalibrated MPU-9150 (see `traces/README.md`).

use crate::rig::files::recording;

use meerkat_mwd::identification::Decision;
use mwd::calibrate::{Calibration, Verdict, calibrate, record};
use testbed::{
    flight::{
        configuration::{freeze_at_us, of_file},
        fly_frozen,
    },
    score::{self, Settings},
    trace::Trace,
};

fn calibrated(trace: &Trace, hold_out: Option<f64>) -> Calibration {
    let found = calibrate(std::slice::from_ref(trace), None, hold_out).unwrap();
    assert_eq!(found.accel.as_ref().unwrap().verdict, Verdict::Calibrated);
    found
}

#[test]
fn the_norm_at_rests_that_were_held_out_is_gravity() {
    for name in ["multipos_mpu9150_imu0", "multipos_mpu9150_imu1"] {
        let trace = recording(name);
        let check = calibrated(&trace, None).accel.unwrap().held_out.unwrap();
        assert!(check.before > 0.15 && check.after < 0.0005 * 9.80665, "{name}: {check:?}");
        let later = calibrated(&trace, Some(0.35)).later.unwrap();
        assert!(later.count >= 8 && later.after < 0.0005 * 9.80665, "{name}: {later:?}");
    }
}

#[test]
fn half_of_the_orientations_are_refused() {
    for name in ["multipos_mpu9150_imu0", "multipos_mpu9150_imu1"] {
        let found = calibrate(&[recording(name)], None, Some(0.5)).unwrap();
        let accel = found.accel.as_ref().unwrap();
        assert!(matches!(accel.verdict, Verdict::Kept(_)), "{name}: the z axis has not been down: {:?}", accel.verdict);
        assert!(record::text(&found).is_none());
    }
}

/// Gravity carried to held-out rests, degrees rms with the bias only, with what was fitted last and with what
/// flies; and whether a P was accepted.
fn carried_deg(name: &str, with_record: bool) -> ([f64; 3], bool) {
    let trace = recording(name);
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("factory.toml");
    record::write(&calibrated(&trace, Some(0.35)), &file).unwrap();
    let config = of_file(&trace, with_record.then_some(file.as_path())).unwrap();
    let flight = fly_frozen(&config, freeze_at_us(&trace, 0.35), &trace.samples).unwrap();
    let errors = score::score(&trace, &flight, &Settings::of(&trace, &config, &flight)).unwrap().rest_gravity_deg;
    let found = [errors.bias_only, errors.twelve_parameters, errors.with_effects].map(Option::unwrap);
    (found, flight.reports.iter().any(|report| report.decision == Decision::Accepted))
}

#[test]
fn gravity_carried_to_held_out_rests_is_nearer_with_the_record_and_no_p_flies_without_a_magnetometer() {
    for name in ["multipos_mpu9150_imu0", "multipos_mpu9150_imu1"] {
        let ([before, ..], _) = carried_deg(name, false);
        let ([bias_only, fitted, flown], accepted) = carried_deg(name, true);
        println!(
            "{name}: bias only {before:.2} deg before, {bias_only:.2} after, fitted {fitted:.2}, flown {flown:.2}"
        );
        assert!(bias_only < before / 2.0, "{name}: {before} deg before, {bias_only} deg after");
        // There is no magnetometer in these: rotation about gravity cannot be seen, and no P flies.
        assert!(!accepted && flown <= 1.05 * bias_only + 0.02, "{name}: {flown} deg against {bias_only}");
    }
}
