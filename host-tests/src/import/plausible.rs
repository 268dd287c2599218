//! Units, signs and axes of a trace that was not imported: what the gate of an import would refuse, told
//! where the trace is flown. Only what cannot be otherwise is an error here: a fault that comes and goes, a
//! magnet and a scale that is off are for the pipeline to bear.

use meerkat_mwd::{Config, Sample, SampleFlags, compensation::VectorModel};
use nalgebra::Vector3;

use super::{
    column_map::{ColumnMap, Part},
    gate::{Finding, Imported, Verdict, units_and_axes},
    merged::Merged,
    series::Series,
};
use testbed::{
    failure::Failure,
    score::convention_note,
    trace::{BodyFrame, Keys, Trace},
};

/// Samples that are looked at: what units and axes show in, they show in this many, and so memory is bounded.
const LOOKED_AT: usize = 1 << 16;

/// Stretches that a longer trace is looked at in, spread evenly over it.
const STRETCHES: usize = 16;

/// The samples of a trace that are looked at: all, or those of the stretches.
fn looked_at(trace: &Trace) -> Vec<Sample> {
    let (count, stretch) = (trace.len(), LOOKED_AT / STRETCHES);
    let is_in = |index: usize| count <= LOOKED_AT || index * STRETCHES % count < stretch * STRETCHES;
    trace.samples().enumerate().filter(|(index, _)| is_in(*index)).map(|(_, sample)| sample).collect()
}

/// Findings of the gate in the units, signs and axes of a trace whose readings the configuration's sensor
/// models have calibrated.
#[must_use]
pub fn units_and_axes_of(trace: &Trace, config: &Config) -> Vec<Finding> {
    by_keys(trace, config, &trace.keys)
}

/// The same by other keys than those of the trace.
fn by_keys(trace: &Trace, config: &Config, keys: &Keys) -> Vec<Finding> {
    let samples = looked_at(trace);
    // A clipped reading counts: with another unit all of them are beyond the full scale.
    let rows = |missing: SampleFlags, reading: &dyn Fn(&Sample) -> Vector3<f32>| -> Vec<[f64; 4]> {
        let row = |sample: &Sample| {
            let v = reading(sample).map(f64::from);
            if sample.flags.contains(missing) { [f64::NAN; 4] } else { [v.x, v.y, v.z, 0.0] }
        };
        samples.iter().map(row).collect()
    };
    let has_mag = samples.iter().any(|sample| !sample.flags.contains(SampleFlags::MAG_MISSING));
    let merged = Merged {
        // A trace's times fit: they are of one recording.
        t_us: samples.iter().map(|sample| i64::try_from(sample.t_us).unwrap_or(i64::MAX)).collect(),
        gyro: rows(SampleFlags::GYRO_MISSING, &|sample| config.gyro.compensate(sample.gyro_rad_s)),
        accel: rows(SampleFlags::ACCEL_MISSING, &|sample| config.accel.calibrate(sample.accel_m_s2)),
        mag: if has_mag {
            rows(SampleFlags::MAG_MISSING, &|sample| config.mag.calibrate(sample.mag_ut))
        } else {
            Vec::new()
        },
        ..Merged::default()
    };
    let part = |columns: [&str; 3], unit: &str| Part {
        columns: Some(columns.map(str::to_owned).to_vec()),
        unit: Some(unit.to_owned()),
        ..Part::default()
    };
    let map = ColumnMap {
        gyro: part(["gx", "gy", "gz"], "rad/s"),
        accel: part(["ax", "ay", "az"], "m/s^2"),
        mag: part(["mx", "my", "mz"], "uT"),
        ..ColumnMap::default()
    };
    let gyro = Series { t_us: merged.t_us.clone(), ..Series::default() };
    units_and_axes(&Imported { merged: &merged, gyro: &gyro, all: &[], parts: &[], map: &map, keys })
}

/// Refuses a trace whose units, signs or axes cannot be. Forced, it flies with what is wrong written down and without
/// effects; [`frozen_from_us`](testbed::flight::configuration::frozen_from_us) keeps a model from being learnt. What is
/// only doubtful becomes a note.
///
/// # Errors
/// Description of the units, signs or axes that cannot be, with the likely fix.
pub fn checked(trace: &mut Trace, config: &mut Config, force: bool) -> Result<(), Failure> {
    let findings = units_and_axes_of(trace, config);
    let (wrong, others): (Vec<&Finding>, Vec<&Finding>) = findings.iter().partition(|finding| finding.is_certain());
    let doubtful = others.into_iter().filter(|finding| finding.verdict != Verdict::Fine && finding.fix.is_some());
    trace.notes.extend(doubtful.map(told));
    trace.wrong = wrong.into_iter().map(told).collect();
    if trace.wrong.is_empty() {
        trace.notes.extend(convention_note(trace, &config.accel));
        return Ok(());
    }
    if !force {
        return Err(refused(trace, &trace.wrong, ", or fly it as it is by --force, with nothing identified"));
    }
    config.effects = false;
    Ok(())
}

/// Refuses a trace for a calibration whose units, signs or axes cannot be, by its readings as they are: a record that
/// was made of another unit would hide it. The dip is not asked for: the hard iron that is to be found turns the raw
/// field.
///
/// # Errors
/// Description of the units, signs or axes that cannot be, with the likely fix.
pub fn checked_raw(trace: &Trace, config: &Config) -> Result<(), Failure> {
    let raw = Config { accel: VectorModel::IDENTITY, mag: VectorModel::IDENTITY, ..*config };
    let keys = Keys { dip_deg: None, latitude_deg: None, body_frame: BodyFrame::Sensor, ..trace.keys.clone() };
    let findings = by_keys(trace, &raw, &keys);
    let wrong: Vec<String> = findings.iter().filter(|finding| finding.is_certain()).map(told).collect();
    if wrong.is_empty() { Ok(()) } else { Err(refused(trace, &wrong, "")) }
}

fn told(finding: &Finding) -> String {
    match &finding.fix {
        Some(fix) => format!("{}; likely fix: {fix}", finding.told),
        None => finding.told.clone(),
    }
}

fn refused(trace: &Trace, wrong: &[String], or: &str) -> Failure {
    Failure::BadInput(format!(
        "{}: units, signs or axes cannot be:\n  {}\nPut the fix into a file and correct the trace by \
         `import TRACE --map FILE.toml -o CORRECTED.csv.gz`{or}",
        trace.path.display(),
        wrong.join("\n  ")
    ))
}
