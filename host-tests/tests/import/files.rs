//! One flight in the dialects, units and axes of others.

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use meerkat_mwd::{Sample, SampleFlags};
use mwd::import::{ColumnMap, Import, import};
use tempfile::TempDir;
use testbed::{
    flight::{Flight, configuration::of_trace, fly},
    trace::Trace,
};

use crate::rig::files::{FAST_ROTATION, recording};

/// Forty seconds of a real recording, of which ten are at rest.
pub fn original() -> &'static Trace {
    static ORIGINAL: OnceLock<Trace> = OnceLock::new();
    ORIGINAL.get_or_init(|| {
        let mut trace = recording(FAST_ROTATION);
        let from = trace.first_us();
        trace.samples.retain(|sample| sample.t_us < from + 40_000_000);
        trace.reference.clear();
        trace.movement = None;
        trace
    })
}

pub fn flight(trace: &Trace) -> Flight {
    fly(&of_trace(trace), &trace.samples, |_| {}).unwrap()
}

pub fn written(folder: &TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path
}

pub fn imported(paths: &[PathBuf]) -> Import {
    import(paths, &ColumnMap::default(), &[]).unwrap()
}

pub fn with_map(path: &Path, map: &str) -> Import {
    import(&[path.to_owned()], &toml::from_str(map).unwrap(), &[]).unwrap()
}

/// Every attitude of the original's flight within a hundredth of a degree.
pub fn flies_as_the_original(imported: &Import) {
    assert!(!imported.is_wrong(), "{:#?}", imported.findings);
    flies_within(&imported.trace, 0.01);
}

pub fn flies_within(trace: &Trace, limit_deg: f64) {
    static FLOWN: OnceLock<Flight> = OnceLock::new();
    flies_as(trace, FLOWN.get_or_init(|| flight(original())), limit_deg);
}

/// Every attitude of the trace's flight within so many degrees of another's.
pub fn flies_as(trace: &Trace, expected: &Flight, limit_deg: f64) {
    let found = flight(trace);
    assert_eq!(found.outputs.len(), expected.outputs.len());
    let mut worst = 0.0_f64;
    for (a, b) in found.outputs.iter().zip(&expected.outputs) {
        assert_eq!(a.t_us, b.t_us);
        let (Some(a), Some(b)) = (a.attitude, b.attitude) else { continue };
        let apart = |sign: f64| {
            let square = |(a, b): (&f32, f32)| (f64::from(*a) - sign * f64::from(b)).powi(2);
            a.q.iter().zip(b.q).map(square).sum::<f64>().sqrt()
        };
        worst = worst.max(4.0 * (apart(1.0).min(apart(-1.0)) / 2.0).asin().to_degrees());
    }
    assert!(worst <= limit_deg, "{worst} deg");
}

/// A column of the text: its name, and its value in a sample.
pub type Written<'a> = (&'a str, &'a dyn Fn(&Sample) -> Option<f64>);

/// Rows of `samples` with these columns.
pub fn rows(samples: &[Sample], columns: &[Written], separator: char, decimal: char) -> String {
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(&separator.to_string());
    for sample in samples {
        text.push('\n');
        for (index, (_, value)) in columns.iter().enumerate() {
            if index > 0 {
                text.push(separator);
            }
            if let Some(value) = value(sample) {
                let mut cell = String::new();
                write!(cell, "{value:.9}").unwrap();
                text.push_str(&cell.replace('.', &decimal.to_string()));
            }
        }
    }
    text + "\n"
}

pub fn gyro(sample: &Sample, axis: usize) -> Option<f64> {
    Some(f64::from(sample.gyro_rad_s[axis]))
}

pub fn accel(sample: &Sample, axis: usize) -> Option<f64> {
    Some(f64::from(sample.accel_m_s2[axis]))
}

pub fn mag(sample: &Sample, axis: usize) -> Option<f64> {
    (!sample.flags.contains(SampleFlags::MAG_MISSING)).then(|| f64::from(sample.mag_ut[axis]))
}

/// All columns in SI units with a change of the axes of each sensor.
pub fn si(change: [fn([f64; 3]) -> [f64; 3]; 3]) -> String {
    let three = |of: fn(&Sample, usize) -> Option<f64>, change: fn([f64; 3]) -> [f64; 3], axis: usize| {
        move |sample: &Sample| {
            let row = [of(sample, 0)?, of(sample, 1)?, of(sample, 2)?];
            Some(change(row)[axis])
        }
    };
    let [g, a, m] = change;
    let columns = [(gyro as fn(&Sample, usize) -> Option<f64>, g), (accel, a), (mag, m)];
    let functions: Vec<_> =
        columns.into_iter().flat_map(|(of, change)| (0..3).map(move |axis| three(of, change, axis))).collect();
    let time = |sample: &Sample| Some(sample.t_us as f64 * 1e-6);
    let names = ["gx", "gy", "gz", "ax", "ay", "az", "mx", "my", "mz"];
    let mut written: Vec<Written> = vec![("t_s", &time)];
    written.extend(names.into_iter().zip(&functions).map(|(name, function)| (name, function as &dyn Fn(&Sample) -> _)));
    rows(&original().samples, &written, ',', '.')
}

/// Loss in the only file is told as a note of the trace.
pub fn is_told_as_lost(told: &Import, what: &str) {
    let [lost] = &told.lost[..] else { panic!("{:?}", told.lost) };
    assert!(lost.contains(what) && told.trace.notes.contains(lost), "{lost}: {:?}", told.trace.notes);
}
