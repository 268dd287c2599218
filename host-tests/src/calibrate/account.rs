//! The account of a calibration, as text.

use std::io::{self, Write};

use super::{
    Calibration,
    alignment::Alignment,
    held_out::HeldOut,
    model::{NAMES, PARAMETERS},
    sensor::SensorCalibration,
    verdict::{APART_DEG, TOO_FEW_TURNS, Verdict, is_beyond_figures, undetermined_of},
};
use crate::{layout::Layout, number::fixed};

/// Units of a sensor and of its error, which is stated as a share of the norm times a factor.
struct Unit {
    of_sensor: &'static str,
    of_error: &'static str,
    /// One of the sensor's unit in the unit of the error.
    factor: f64,
    /// True if the noise of each reading was measured.
    noise_known: bool,
}

/// Prints the account.
///
/// # Errors
/// When it cannot be written.
pub fn print_account(out: &mut impl Write, layout: Layout, calibration: &Calibration) -> io::Result<()> {
    for trace in &calibration.traces {
        writeln!(out, "{trace}")?;
    }
    for note in &calibration.notes {
        writeln!(out, "note: {note}")?;
    }
    writeln!(out, "\nACCELEROMETER, from {} rests", calibration.rests.len())?;
    match &calibration.accel {
        Some(accel) => {
            let unit = Unit { of_sensor: "m/s^2", of_error: "g", factor: 1.0 / accel.norm, noise_known: true };
            print_sensor(out, layout, accel, &unit, "rests")?;
            if let Some(check) = calibration.later.as_ref().filter(|_| !is_beyond(accel)) {
                print_check(out, check, "rests of the part held out", &unit)?;
            }
        }
        None => writeln!(out, "  old values stay: {}", calibration.no_accel())?,
    }
    writeln!(out, "\nMAGNETOMETER, from turns")?;
    match &calibration.mag {
        Some(mag) => {
            let unit = Unit { of_sensor: "uT", of_error: "uT", factor: 1.0, noise_known: false };
            print_sensor(out, layout, mag, &unit, "readings")?;
            if let Some(check) = calibration.mag_later.as_ref().filter(|_| !is_beyond(mag)) {
                print_check(out, check, "readings of the part held out", &unit)?;
            }
            let how = if mag.norm_known { "given" } else { "fitted: the mean scale stays" };
            match mag.norms() {
                _ if is_beyond(mag) => {}
                [least, most] if least < most => {
                    writeln!(out, "  fields {least:.2} to {most:.2} uT, {how}: each trace has that of its place")?;
                }
                _ => writeln!(out, "  field {:.2} uT, {how}", mag.norm)?,
            }
        }
        None => writeln!(out, "  old values stay: {}", calibration.no_mag())?,
    }
    if let Some(alignment) = &calibration.alignment {
        print_alignment(out, alignment)?;
    }
    Ok(())
}

/// Returns true if all that can be told of a sensor is why its old values stay.
fn is_beyond(sensor: &SensorCalibration) -> bool {
    matches!(&sensor.verdict, Verdict::Kept(reason) if is_beyond_figures(&sensor.fit) || reason == TOO_FEW_TURNS)
}

fn print_sensor(
    out: &mut impl Write,
    layout: Layout,
    sensor: &SensorCalibration,
    unit: &Unit,
    of: &str,
) -> io::Result<()> {
    let (spread, fit) = (&sensor.spread, &sensor.fit);
    if let (true, Verdict::Kept(reason)) = (is_beyond(sensor), &sensor.verdict) {
        writeln!(out, "  {} {of}", sensor.observations.len())?;
        return writeln!(out, "  verdict: old values stay: {reason}");
    }
    let used = sensor.observations.len() - sensor.left_out();
    writeln!(
        out,
        "  {used} {of} used, {} contradicted by the others; {} orientations over {APART_DEG:.0} deg apart, least spread {:.3} (all around 0.333)",
        sensor.left_out(),
        spread.orientations,
        spread.smallest,
    )?;
    let told = |x: f64| format!("{:.5} {}", x * unit.factor, unit.of_error);
    if let Some((before, after)) = sensor.before_after() {
        writeln!(out, "  error of the norm, rms: {} before, {} after", told(before), told(after))?;
    }
    match &sensor.held_out {
        Some(check) => print_check(out, check, &format!("{of} held out ({})", check.how), unit)?,
        None => writeln!(out, "  too few to hold any out")?,
    }
    let (sigma, open) = (fit.sigma(), undetermined_of(&sensor.prior, fit));
    if layout == Layout::Table {
        writeln!(out, "  {:<9} {:>11} {:>11} {:>11}  ", "", "value", "1-sigma", "+- 95 %")?;
    }
    for k in 0..PARAMETERS {
        let (in_unit, name) = if k < 6 { (100.0, "%") } else { (1.0, unit.of_sensor) };
        let remark = if open.contains(&NAMES[k]) { "  not determined" } else { "" };
        let bound = fit.quantile() * sigma[k];
        let [value, sigma, bound] = [fit.x[k], sigma[k], bound].map(|x| x * in_unit);
        match layout {
            Layout::Table => {
                writeln!(out, "  {:<9} {value:>11.4} {sigma:>11.4} {bound:>11.4} {name}{remark}", NAMES[k])?;
            }
            Layout::Lines => {
                let value = fixed(value, 4);
                writeln!(out, "  {}: {value} +- {bound:.4} {name} (95 %), 1-sigma {sigma:.4}{remark}", NAMES[k])?;
            }
        }
    }
    if fit.rank == PARAMETERS {
        let (norm, direction) = (100.0 * sensor.bounds.norm, sensor.bounds.direction_rad.to_degrees());
        writeln!(out, "  a calibrated vector is right (95 %) to {norm:.3} % in norm, {direction:.3} deg in direction")?;
        let (change, sigma) = (sensor.bounds.change_rad.to_degrees(), sensor.bounds.sigma_rad.to_degrees());
        writeln!(out, "  directions change by {change:.3} deg rms, 1-sigma {sigma:.3}")?;
    }
    match &sensor.verdict {
        Verdict::Calibrated => writeln!(out, "  verdict: calibrated"),
        Verdict::Partly(reason) => writeln!(out, "  verdict: new where determined, else as on record: {reason}"),
        Verdict::Kept(reason) => writeln!(out, "  verdict: old values stay: {reason}"),
    }
}

fn print_check(out: &mut impl Write, check: &HeldOut, of: &str, unit: &Unit) -> io::Result<()> {
    let told = |x: f64| format!("{:.5} {}", x * unit.factor, unit.of_error);
    let noise = if unit.noise_known {
        format!(", {} of them the readings' own noise", told(check.noise))
    } else {
        String::new()
    };
    let (before, after, largest) = (told(check.before), told(check.after), told(check.largest));
    writeln!(out, "  on {} {of}: {before} before, {after} after{noise}, largest {largest}", check.count)
}

fn print_alignment(out: &mut impl Write, alignment: &Alignment) -> io::Result<()> {
    writeln!(out, "\nMAGNETOMETER'S AXES against the accelerometer's, from {} rests", alignment.rests)?;
    let [x, y, z] = alignment.turn_rad.map(f64::to_degrees);
    let [sx, sy, sz] = alignment.sigma_rad.map(f64::to_degrees);
    writeln!(out, "  turned by [{x:.3} {y:.3} {z:.3}] deg, 1-sigma [{sx:.3} {sy:.3} {sz:.3}]")?;
    let (before, after) = alignment.scatter_rad;
    writeln!(
        out,
        "  dip {:.2} deg, from rest to rest {:.3} deg before, {:.3} after",
        alignment.dip_rad.to_degrees(),
        before.to_degrees(),
        after.to_degrees()
    )?;
    match &alignment.refused {
        None => writeln!(out, "  verdict: turned"),
        Some(reason) => writeln!(out, "  verdict: not turned: {reason}"),
    }
}
