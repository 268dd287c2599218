//! The factory record: the part of a configuration file that `--config` takes.

use std::{fmt::Write, path::Path};

use meerkat_mwd::compensation::VectorModel;

use super::{Calibration, alignment::Alignment, model::NAMES, sensor::SensorCalibration, verdict::Verdict};
use crate::failure::Failure;

/// Writes the record.
///
/// # Errors
/// When there is nothing to record, or the file cannot be written.
pub fn write(calibration: &Calibration, path: &Path) -> Result<(), Failure> {
    let text = text(calibration).ok_or_else(|| {
        Failure::BadInput(format!("{}: not written, nothing could be calibrated (see above)", path.display()))
    })?;
    std::fs::write(path, text).map_err(|error| Failure::output(path, &error))
}

/// The record as TOML; `None` when no sensor has new values. A sensor that keeps old values has these again, so that the file can take the
/// place of the one before.
#[must_use]
pub fn text(calibration: &Calibration) -> Option<String> {
    let sensors = [
        ("accel", "m/s^2", calibration.accel.as_ref(), calibration.accel_model(), calibration.record.accel, None),
        (
            "mag",
            "microtesla",
            calibration.mag.as_ref(),
            calibration.mag_model(),
            calibration.record.mag,
            calibration.alignment.as_ref(),
        ),
    ];
    let is_new = |sensor: Option<&SensorCalibration>, model: VectorModel, old: VectorModel| {
        sensor.is_some_and(SensorCalibration::is_new) || model != old
    };
    if !sensors.iter().any(|(_, _, sensor, model, old, _)| is_new(*sensor, *model, *old)) {
        return None;
    }
    let mut out = String::from("# Factory record of the vector sensors: calibrated = matrix (raw - offset).\n");
    for trace in &calibration.traces {
        let _ = writeln!(out, "# from {trace}");
    }
    out.push_str("# date of the recording: not known, a trace does not hold it\n");
    for (table, unit, sensor, model, old, alignment) in sensors {
        if is_new(sensor, model, old) {
            out.push('\n');
            if let Some(sensor) = sensor {
                comment(&mut out, sensor, unit, alignment);
            }
        } else if old != VectorModel::IDENTITY {
            out.push_str("\n# as it was on record\n");
        } else {
            let _ = writeln!(out, "\n# {table}: not calibrated");
            continue;
        }
        let row = |v: [f32; 3]| format!("[{:?}, {:?}, {:?}]", v[0], v[1], v[2]);
        let [first, second, third] = model.matrix.map(row);
        let _ = writeln!(out, "[{table}]\nmatrix = [\n    {first},\n    {second},\n    {third},\n]");
        let _ = writeln!(out, "offset = {} # {unit}", row(model.offset));
    }
    Some(out)
}

fn comment(out: &mut String, sensor: &SensorCalibration, unit: &str, alignment: Option<&Alignment>) {
    let (used, all) = (sensor.observations.len() - sensor.left_out(), sensor.observations.len());
    let _ = writeln!(out, "# {used} of {all} readings, {} orientations", sensor.spread.orientations);
    let known = if sensor.norm_known { "given" } else { "fitted, the mean scale is the sensor's" };
    let _ = writeln!(out, "# norm {:.5} {unit} ({known})", sensor.norm);
    if let Some((before, after)) = sensor.before_after() {
        let _ = writeln!(out, "# error of the norm, rms: {before:.5} before, {after:.5} after");
    }
    if let Some(check) = &sensor.held_out {
        let _ = writeln!(
            out,
            "# on readings held out ({}): {:.5} before, {:.5} after",
            check.how, check.before, check.after
        );
    }
    if let Verdict::Partly(reason) = &sensor.verdict {
        let _ = writeln!(out, "# partly as it was on record: {reason}");
    }
    let _ = writeln!(out, "# 1-sigma ({:.0} degrees of freedom):", sensor.fit.freedom);
    let sigma = sensor.fit.sigma();
    for group in [0..3, 3..6, 6..9] {
        let words: Vec<String> = group.map(|k| format!("{} {:.6}", NAMES[k], sigma[k])).collect();
        let _ = writeln!(out, "#   {}", words.join(", "));
    }
    if let Some(turn) = alignment.filter(|alignment| alignment.refused.is_none()) {
        let [x, y, z] = turn.turn_rad.map(f64::to_degrees);
        let largest = turn.sigma_rad.iter().fold(0.0_f64, |a, b| a.max(*b)).to_degrees();
        let _ =
            writeln!(out, "# axes turned into the accelerometer's by [{x:.3} {y:.3} {z:.3}] deg, 1-sigma {largest:.3}");
    }
}
