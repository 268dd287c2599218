//! The `--json` file, schema `meerkat-mwd/calibration/1`. A number that does not exist is `null`.

use std::path::Path;

use meerkat_mwd::compensation::VectorModel;
use serde_json::{Value, json};

use super::{
    Calibration,
    held_out::{HeldOut, norm_error},
    model::NAMES,
    rests::Rest,
    sensor::SensorCalibration,
    verdict::{Verdict, undetermined_of},
};
use testbed::failure::Failure;

/// Writes the result.
///
/// # Errors
/// When the file cannot be written.
pub fn write(calibration: &Calibration, path: &Path) -> Result<(), Failure> {
    let text = format!("{:#}\n", value(calibration));
    testbed::console::save(path, &text).map_err(|error| Failure::output(path, &error))
}

/// The result of a calibration as JSON.
#[must_use]
pub fn value(calibration: &Calibration) -> Value {
    let accel = calibration.accel.as_ref().map(|accel| sensor(accel, calibration.accel_model(), "m_s2"));
    let mag = calibration.mag.as_ref().map(|mag| sensor(mag, calibration.mag_model(), "ut"));
    let kept = |reason: String| json!({ "verdict": "kept", "reason": reason });
    let alignment = calibration.alignment.as_ref().map(|alignment| {
        json!({
            "rests": alignment.rests,
            "turn_deg": alignment.turn_rad.map(f64::to_degrees),
            "sigma_deg": alignment.sigma_rad.map(f64::to_degrees),
            "dip_deg": alignment.dip_rad.to_degrees(),
            "dip_scatter_deg": { "before": alignment.scatter_rad.0.to_degrees(), "after": alignment.scatter_rad.1.to_degrees() },
            "applied": alignment.refused.is_none(),
            "reason": alignment.refused,
        })
    });
    json!({
        "schema": "meerkat-mwd/calibration/1",
        "traces": calibration.traces,
        "rests": rests(calibration),
        "accel": accel.unwrap_or_else(|| kept(calibration.no_accel())),
        "accel_later_rests_m_s2": calibration.later.as_ref().map(check),
        "mag_later_turns_ut": calibration.mag_later.as_ref().map(check),
        "mag": mag.unwrap_or_else(|| kept(calibration.no_mag())),
        "alignment": alignment,
    })
}

/// The rests, with the accelerometer's norm there by the old and the new values.
fn rests(calibration: &Calibration) -> Vec<Value> {
    let mut place = 0;
    let rest = |rest: &Rest| {
        let told = calibration.accel.as_ref().filter(|_| rest.accel.is_some()).map(|accel| {
            let at = place;
            place += 1;
            let observation = &accel.observations[at];
            json!({
                "sigma": observation.sigma, "used": accel.fit.used[at],
                "before": norm_error(&accel.record, observation), "after": accel.fit.residuals[at],
            })
        });
        json!({ "from_s": rest.from_us as f64 * 1e-6, "to_s": rest.to_us as f64 * 1e-6, "norm_error_m_s2": told })
    };
    calibration.rests.iter().map(rest).collect()
}

fn sensor(sensor: &SensorCalibration, model: VectorModel, unit: &str) -> Value {
    let (verdict, reason) = match &sensor.verdict {
        Verdict::Calibrated => ("calibrated", None),
        Verdict::Partly(reason) => ("partly", Some(reason)),
        Verdict::Kept(reason) => ("kept", Some(reason)),
    };
    let fit = &sensor.fit;
    let named = |values: &super::model::Parameters| -> serde_json::Map<String, Value> {
        let name = |k: usize| if k < 6 { NAMES[k].to_owned() } else { format!("{}_{unit}", NAMES[k]) };
        (0..NAMES.len()).map(|k| (name(k), json!(values[k]))).collect()
    };
    json!({
        "verdict": verdict,
        "reason": reason,
        "readings": sensor.observations.len(),
        "contradicted": sensor.left_out(),
        "orientations": sensor.spread.orientations,
        "least_spread": sensor.spread.smallest,
        "rank": fit.rank,
        "not_determined": undetermined_of(&sensor.prior, fit),
        "degrees_of_freedom": fit.freedom,
        "parameters": named(&fit.x),
        "sigma": named(&fit.sigma()),
        "quantile_95": fit.quantile(),
        "direction_95_deg": sensor.bounds.direction_rad.to_degrees(),
        "norm_95": sensor.bounds.norm,
        "change_deg": sensor.bounds.change_rad.to_degrees(),
        "change_sigma_deg": sensor.bounds.sigma_rad.to_degrees(),
        "norm": sensor.norm,
        "norm_known": sensor.norm_known,
        "norm_error_rms": sensor.before_after().map(|(before, after)| json!({ "before": before, "after": after })),
        "held_out": sensor.held_out.as_ref().map(check),
        "matrix": model.matrix,
        "offset": model.offset,
    })
}

fn check(check: &HeldOut) -> Value {
    json!({
        "how": check.how, "count": check.count, "before": check.before, "after": check.after, "noise": check.noise,
        "largest": check.largest,
    })
}
