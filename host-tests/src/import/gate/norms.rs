//! Sizes of the readings: gravity at rest, the field, dead axes.

use meerkat_mwd::config::AttitudeConfig;

use super::{
    super::{
        median::median,
        resolve::{in_words, name},
        units::{Quantity, STANDARD_GRAVITY},
    },
    Finding, Imported, saturation,
    sizes::{FIELD, GRAVITY},
};

/// Norm in motion: vibration adds to gravity.
const IN_MOTION: std::ops::RangeInclusive<f64> = 4.0..=40.0;
/// Deviation of the specific force's norm and of a rate over a second of rest.
const REST: (f64, f64) = (0.15, 0.05);
/// Factor between two units from which no scale, magnet or vibration is the cause.
const OTHER_UNIT: (f64, f64) = (5.0, 50.0);
/// Seconds of rest that tell of gravity for certain.
const RESTED: usize = 3;
/// Share of the readings at either end of their order that the spread of the field leaves out: noise, and a magnet that
/// passes.
const LEFT_OUT: f64 = 0.05;

pub(super) fn check(imported: &Imported) -> Vec<Finding> {
    let merged = imported.merged;
    let mut findings = Vec::new();
    for (quantity, rows) in
        [(Quantity::Gyro, &merged.gyro), (Quantity::Accel, &merged.accel), (Quantity::Mag, &merged.mag)]
    {
        let there: Vec<[f64; 3]> =
            rows.iter().map(|row| [row[0], row[1], row[2]]).filter(|row| row.iter().all(|x| x.is_finite())).collect();
        if rows.is_empty() || there.is_empty() {
            if quantity == Quantity::Mag {
                findings.push(Finding::note("no magnetometer: no P flies, and there is no azimuth".into()));
            } else {
                let fix = format!("name other columns in [{}]", name(quantity));
                findings.push(Finding::wrong(format!("the {} has no reading", in_words(quantity)), fix));
            }
            continue;
        }
        findings.extend(dead_axes(imported, quantity, &there));
        findings.extend(saturation::check(imported, quantity, &there));
        match quantity {
            Quantity::Accel => findings.push(gravity(imported)),
            Quantity::Mag => findings.push(field(imported, &there)),
            _ => {}
        }
    }
    findings
}

/// Gravity and field alone.
pub(super) fn units(imported: &Imported) -> Vec<Finding> {
    let has_accel = imported.merged.accel.iter().any(|row| norm(row) > 0.0);
    let field_of: Vec<[f64; 3]> =
        imported.merged.mag.iter().map(|row| [row[0], row[1], row[2]]).filter(|row| norm(row) > 0.0).collect();
    let accel = has_accel.then(|| gravity(imported));
    accel.into_iter().chain((!field_of.is_empty()).then(|| field(imported, &field_of))).collect()
}

fn norm(row: &[f64]) -> f64 {
    row[..3].iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Mean norms of the specific force in the seconds of rest.
fn at_rest(imported: &Imported) -> Vec<f64> {
    let merged = imported.merged;
    let per_second = (imported.gyro.rate_hz().round() as usize).max(2);
    let deviation = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        ((values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / values.len() as f64).sqrt(), mean)
    };
    let seconds = merged.gyro.chunks_exact(per_second).zip(merged.accel.chunks_exact(per_second));
    let rest = seconds.filter_map(|(gyro, accel)| {
        let norms: Vec<f64> = accel.iter().map(|row| norm(row)).filter(|x| x.is_finite()).collect();
        let rates: Vec<f64> = gyro.iter().map(|row| norm(row)).filter(|x| x.is_finite()).collect();
        if 2 * norms.len() < per_second || 2 * rates.len() < per_second {
            return None;
        }
        // In units of gravity, so that a wrong unit does not hide a rest.
        let (spread, mean) = deviation(&norms);
        let (turning, _) = deviation(&rates);
        (spread < REST.0 * mean / STANDARD_GRAVITY && turning < REST.1).then_some(mean)
    });
    rest.collect()
}

fn gravity(imported: &Imported) -> Finding {
    let rest = at_rest(imported);
    let rested = rest.len();
    let (value, allowed, told) = if rest.is_empty() {
        let all = imported.merged.accel.iter().map(|row| norm(row)).filter(|x| x.is_finite());
        let value = median(all).unwrap_or(f64::NAN);
        (value, IN_MOTION, format!("|a| {value:.3} m/s^2 on the median; there is no second of rest"))
    } else {
        let count = rest.len();
        let value = median(rest).unwrap_or(f64::NAN);
        (value, GRAVITY, format!("|a| at rest {value:.3} m/s^2, over {count} s"))
    };
    if allowed.contains(&value) {
        return Finding::fine(told);
    }
    let other = other_unit(imported, Quantity::Accel, value, &allowed);
    let is_far = other.is_some_and(|(_, factor)| factor > OTHER_UNIT.0);
    let without_gravity = rested >= RESTED && value > 0.0 && value < 1.0;
    let fix = match other {
        Some((unit, _)) => format!("unit = {unit:?} in [accel]"),
        None if value < 1.0 => {
            "gravity was taken out of these columns: name those of the whole acceleration in [accel]".into()
        }
        None => "columns or unit in [accel]; calibrate the accelerometer if its scale is really so far off".into(),
    };
    Finding::wrong(told, fix).unless(is_far || without_gravity)
}

fn field(imported: &Imported, there: &[[f64; 3]]) -> Finding {
    let mut norms: Vec<f64> = there.iter().map(|row| norm(row)).collect();
    norms.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| norms.get((share * norms.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    let [least, value, most] = [LEFT_OUT, 0.5, 1.0 - LEFT_OUT].map(at);
    let told = format!("|B| {value:.2} uT on the median, nine readings of ten from {least:.2} to {most:.2} uT");
    if FIELD.contains(&value) {
        return usable(told, least, most);
    }
    let other = other_unit(imported, Quantity::Mag, value, &FIELD);
    let is_far = other.is_some_and(|(_, factor)| factor > OTHER_UNIT.1);
    let fix = other.map_or_else(
        || "the earth's field is 20 to 70 uT: a magnet on the probe, a magnetometer without its calibration (--force imports it), or counts, whose size `scale = ...` in [mag] states".into(),
        |(unit, _)| {
            let or_a_magnet = if is_far { "" } else { ", or a magnet is near" };
            format!("unit = {unit:?} in [mag]{or_a_magnet}")
        },
    );
    Finding::wrong(told, fix).unless(is_far)
}

/// The finding on a field of a size that can be. The attitude takes a field within a tolerance of one reference, so
/// that no reference suits readings that spread over more than twice that: those of a magnetometer whose offset is over
/// a tenth of the field, or whose scales differ by a fifth.
fn usable(told: String, least: f64, most: f64) -> Finding {
    let tolerance = f64::from(AttitudeConfig::default().mag_norm_tolerance);
    if most - least <= tolerance * (most + least) {
        return Finding::fine(told);
    }
    let told = format!(
        "{told}: the attitude uses a field that stays within {:.0} % of its mean, so that much of this one goes unused",
        100.0 * tolerance
    );
    let fix =
        "calibrate the magnetometer by `mwd calibrate`, from turns in all directions; or a magnet was near".into();
    Finding { fix: Some(fix), ..Finding::note(told) }
}

/// The unit in which this size would be right, and how many times larger or smaller it is than the given one.
fn other_unit(
    imported: &Imported,
    quantity: Quantity,
    value: f64,
    allowed: &std::ops::RangeInclusive<f64>,
) -> Option<(&'static str, f64)> {
    let factor = quantity.unit(imported.map.part(quantity).unit.as_deref()?)?.factor;
    quantity
        .units()
        .iter()
        .map(|unit| (unit.name, unit.factor / factor))
        .find(|(_, ratio)| allowed.contains(&(value * ratio)))
        .map(|(name, ratio)| (name, ratio.max(1.0 / ratio)))
}

fn dead_axes(imported: &Imported, quantity: Quantity, there: &[[f64; 3]]) -> Vec<Finding> {
    let columns = imported.map.part(quantity).columns.as_deref().unwrap_or_default();
    let dead = (0..3).filter(|&axis| there.len() > 10 && there.iter().all(|row| row[axis] == there[0][axis]));
    let finding = |axis: usize| {
        let column = columns.get(axis).map_or("", String::as_str);
        let told = format!("{} {}, column {column:?}, never changes", in_words(quantity), ["x", "y", "z"][axis]);
        Finding::wrong(told, format!("name the right column in [{}], or the sensor is dead", name(quantity)))
    };
    dead.map(finding).collect()
}
