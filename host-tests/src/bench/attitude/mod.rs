//! Attitude on recordings with a reference, beside VQF's on the same samples.
//!
//! Recordings come from the folder named by `MWD_RECORDINGS`, else from the repository. Every estimate is
//! online: each attitude uses what was known when its sample came, from the recording's first sample on.

mod coverage;
mod from_cold;
mod oracles;

use std::{env, path::Path};

use anyhow::Context;
use meerkat_mwd::{Config, Sample, SampleFlags, config::Latency};
use vqf_rs::VQF;

use coverage::Coverage;
use testbed::study::{Cell, Effort, Table, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::{AttitudeRms, Settings, TimedAttitude, attitude_rms_deg, attitudes_of},
    trace::{
        Trace,
        recordings::{FOLDER, folder, listed},
    },
};

/// An estimate of a trace's attitudes.
type Estimator = fn(&Trace) -> anyhow::Result<Vec<TimedAttitude>>;

/// Delays of the sensor used for the BROAD recordings, measured against their optical reference (`mwd
/// diagnose --against-reference`); a data sheet would state them.
pub const AKTOS_T: Latency = Latency { gyro_s: Some(0.004), accel_s: Some(0.002_5), mag_s: Some(0.015) };

/// The estimators compared, in the order of the rows. The perfect ones show what a delay that nobody declared costs,
/// and what a field that points elsewhere does.
pub const ESTIMATORS: [(&str, Estimator); 6] = [
    ("perfect, told as late as the gyro is", |trace| Ok(oracles::late(trace))),
    ("perfect, to the north of the mean field", |trace| Ok(oracles::to_the_fields_north(trace))),
    ("VQF (vqf-rs 0.3)", |trace| Ok(vqf(trace))),
    ("ours, no effects", |trace| ours(trace, &Config { effects: false, ..of_trace(trace) })),
    ("ours", |trace| ours(trace, &of_trace(trace))),
    ("ours, delays declared", |trace| ours(trace, &Config { latency: AKTOS_T, ..of_trace(trace) })),
];

/// The recordings as they are are played once, whatever the effort.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let recordings = recordings()?;
    let names: Vec<String> = recordings.iter().map(|(name, _)| name.clone()).collect();
    let scores = each_seed(0..recordings.len() as u64, |index| score(&recordings[index as usize].1))?;
    let mut tables = Vec::new();
    for (index, title) in ["as it is", "without one constant heading offset for each recording"].iter().enumerate() {
        for (part, of) in PARTS {
            let mut table = by_recording(format!("Attitude error {title}, {part}, deg rms"), &names);
            for (row, (name, _)) in ESTIMATORS.iter().enumerate() {
                row_of_means(&mut table, name, scores.iter().map(|s| of(&s[row][index])));
            }
            tables.push(table);
        }
    }
    let flown = from_cold::flown(&recordings, effort)?;
    tables.push(from_cold::table(&names, &flown));
    tables.push(Coverage::table(&flown));
    Ok(tables)
}

/// A table with a column for each recording, and their mean.
fn by_recording(title: String, names: &[String]) -> Table {
    let columns: Vec<&str> = [""].into_iter().chain(names.iter().map(String::as_str)).chain(["mean"]).collect();
    Table::new(title, &columns)
}

/// Adds a row of figures, one a recording, with their mean.
fn row_of_means(table: &mut Table, name: &str, values: impl Iterator<Item = Option<f64>>) {
    let values: Vec<f64> = values.map(|value| value.unwrap_or(f64::NAN)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let cells = values.iter().chain([&mean]).map(|x| Cell::number(*x, 2));
    table.row([Cell::from(name)].into_iter().chain(cells));
}

/// Picks one figure of a score.
type Part = fn(&AttitudeRms) -> Option<f64>;

/// A score's parts and their names.
const PARTS: [(&str, Part); 3] =
    [("total", |s| s.total), ("heading", |s| s.heading), ("inclination", |s| s.inclination)];

/// Scores each estimator, as it is and without one constant heading offset.
///
/// # Errors
/// The trace has no configuration that can be flown.
pub fn score(trace: &Trace) -> anyhow::Result<[[AttitudeRms; 2]; ESTIMATORS.len()]> {
    let mut scores = [[AttitudeRms::default(); 2]; ESTIMATORS.len()];
    for (score, (_, estimate)) in scores.iter_mut().zip(ESTIMATORS) {
        *score = attitude_rms_deg(trace, &estimate(trace)?, &Settings::default());
    }
    Ok(scores)
}

/// Name and trace of each recording with a reference attitude.
fn recordings() -> anyhow::Result<Vec<(String, Trace)>> {
    let mut paths = match env::var_os(FOLDER) {
        Some(folder) => listed(Path::new(&folder)).context(FOLDER)?,
        None => listed(&folder())?,
    };
    paths.retain(|path| path.to_string_lossy().trim_end_matches(".gz").ends_with(".csv"));
    let mut all = Vec::new();
    for path in paths {
        let trace = Trace::read(&path)?;
        if trace.reference.iter().any(Option::is_some) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            all.push((name.trim_start_matches("broad_").chars().take(2).collect(), trace));
        }
    }
    Ok(all)
}

/// Attitudes of this project's probe.
///
/// # Errors
/// The configuration cannot be flown.
pub fn ours(trace: &Trace, config: &Config) -> anyhow::Result<Vec<TimedAttitude>> {
    Ok(attitudes_of(&fly(config, &trace.samples, |_| {})?).collect())
}

/// Attitudes of VQF with its defaults, each sensor at its own mean rate.
#[must_use]
pub fn vqf(trace: &Trace) -> Vec<TimedAttitude> {
    let period_s = f64::from(trace.nominal_period_us()) * 1e-6;
    let with = |missing: SampleFlags| {
        let count = trace.samples.iter().filter(|s| !s.flags.contains(missing)).count();
        period_s * (trace.samples.len() as f64 / count.max(1) as f64).round()
    };
    let (accel_s, mag_s) = (with(SampleFlags::ACCEL_MISSING), with(SampleFlags::MAG_MISSING));
    let mut vqf = VQF::new(period_s, Some(accel_s), Some(mag_s), None);
    let attitudes = trace.samples.iter().map(|sample| {
        let Sample { flags, gyro_rad_s, accel_m_s2, mag_ut, .. } = sample;
        vqf.update_gyr(gyro_rad_s.map(f64::from));
        if !flags.contains(SampleFlags::ACCEL_MISSING) {
            vqf.update_acc(accel_m_s2.map(f64::from));
        }
        if !flags.contains(SampleFlags::MAG_MISSING) {
            vqf.update_mag(mag_ut.map(f64::from));
        }
        let q = vqf.quat_9d();
        // VQF's earth frame is east, north, up: half a turn about the bisector of north and east from NED.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let (w, x, y, z) = (q.0, q.1, q.2, q.3);
        (sample.t_us, [-half * (x + y), half * (w + z), half * (w - z), half * (y - x)])
    });
    attitudes.collect()
}
