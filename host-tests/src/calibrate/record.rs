//! The factory record as a file for `--config`.

use std::{fmt::Write, path::Path};

use meerkat_mwd::{compensation::VectorModel, config::VectorErrors};

use super::{Calibration, alignment::Alignment, model::NAMES, sensor::SensorCalibration, verdict::Verdict};
use testbed::failure::Failure;

/// Writes the record.
///
/// # Errors
/// When there is nothing to record, or the file cannot be written.
pub fn write(calibration: &Calibration, path: &Path) -> Result<(), Failure> {
    let text = text(calibration).ok_or_else(|| {
        Failure::BadInput(format!("{}: not written, nothing could be calibrated (see above)", path.display()))
    })?;
    testbed::console::save(path, &text).map_err(|error| Failure::output(path, &error))
}

/// The record as TOML; `None` if no sensor has new values. A sensor that keeps its old values is written with
/// these, so that the file can replace the old one.
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
    for (trace, date) in calibration.traces.iter().zip(&calibration.dates) {
        let date = date.map_or_else(|| "a day that its header does not state".to_owned(), |date| date.to_string());
        let _ = writeln!(out, "# from {trace}, recorded on {date}");
    }
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
    left(&mut out, calibration);
    Some(out)
}

/// Temperature change between calibration and use, kelvin: a data sheet's drift over it remains of a
/// calibrated error.
const WARMING_K: f64 = 20.0;
/// Drift of the accelerometer per kelvin: sensitivity 0.01 %, zero-g level 0.1 mg (LSM6DSO).
const ACCEL_A_KELVIN: [f64; 2] = [1e-4, 0.1e-3 * 9.806_65];
/// Drift of the magnetometer per kelvin: sensitivity 0.03 %, offset 0.03 uT (IIS2MDC).
const MAG_A_KELVIN: [f64; 2] = [3e-4, 0.03];

/// Writes the errors that the calibrations leave; those on record where there is no new calibration.
fn left(out: &mut String, calibration: &Calibration) {
    let of = |sensor: &SensorCalibration, a_kelvin: [f64; 2]| {
        let sigma = sensor.fit.sigma();
        let rms = |from: usize, count: usize, a_kelvin: f64| {
            let mean_square = sigma.rows(from, count).norm_squared() / count as f64;
            (mean_square + (WARMING_K * a_kelvin) * (WARMING_K * a_kelvin)).sqrt()
        };
        [rms(0, 6, a_kelvin[0]), rms(6, 3, a_kelvin[1])]
    };
    let mut errors = calibration.record.left;
    if let Some(accel) = calibration.accel.as_ref().filter(|sensor| sensor.is_new()) {
        let [matrix, bias_m_s2] = of(accel, ACCEL_A_KELVIN);
        (errors.accel_matrix, errors.accel_bias_m_s2) = (matrix as f32, bias_m_s2 as f32);
    }
    if let Some(mag) = calibration.mag.as_ref().filter(|sensor| sensor.is_new()) {
        let [matrix, offset_ut] = of(mag, MAG_A_KELVIN);
        // No norm shows a rotation of the axes: without an alignment that error stays as it was.
        if let Some(alignment) = calibration.alignment.as_ref().filter(|alignment| alignment.refused.is_none()) {
            let turn = alignment.sigma_rad.iter().map(|sigma| sigma * sigma).sum::<f64>() / 3.0;
            errors.mag_matrix = (matrix * matrix + turn).sqrt() as f32;
        }
        errors.hard_iron = (offset_ut / mag.norm) as f32;
    }
    let VectorErrors { mag_matrix, hard_iron, mag_lag_s, accel_matrix, accel_bias_m_s2, accel_lag_s } = errors;
    out.push_str("\n# What the calibrations leave, 1-sigma, with the drift of data sheets over 20 K.\n");
    let _ = writeln!(out, "[identification.vector_errors]\nmag_matrix = {mag_matrix:?}\nhard_iron = {hard_iron:?}");
    let _ = writeln!(out, "mag_lag_s = {mag_lag_s:?}\naccel_matrix = {accel_matrix:?}");
    let _ = writeln!(out, "accel_bias_m_s2 = {accel_bias_m_s2:?}\naccel_lag_s = {accel_lag_s:?}");
}

fn comment(out: &mut String, sensor: &SensorCalibration, unit: &str, alignment: Option<&Alignment>) {
    let (used, all) = (sensor.observations.len() - sensor.left_out(), sensor.observations.len());
    let _ = writeln!(out, "# {used} of {all} readings, {} orientations", sensor.spread.orientations);
    let [least, most] = sensor.norms();
    let known = match sensor.norm_known {
        true if least < most => "given, a mean: each place has its own",
        true => "given",
        false => "fitted, the mean scale is the sensor's",
    };
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
