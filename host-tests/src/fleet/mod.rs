//! Recordings of many probes beside each other: what a batch wrote, the worst first, and how P moves over months.

pub mod drift;
mod tables;

use std::{collections::BTreeMap, path::Path};

use chrono::NaiveDate;
use serde_json::Value;

use testbed::failure::Failure;

/// A row of a table, by the names of its columns; what is null is not there.
type Row = BTreeMap<String, Value>;

/// Standing of a recording, in order from the worst to the best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Standing {
    /// It could not be flown.
    NotFlown,
    /// It was flown although its units, signs or axes cannot be: nothing is identified from it.
    Wrong,
    /// More is left than noise accounts for.
    Unexplained,
    /// An error was found that is not taken out.
    LeftIn,
    /// The probe moved too little for any verdict.
    TooLittleMotion,
    /// Effects were not looked for.
    NotLookedFor,
    /// Effects were found and taken out, and what is left is small.
    EffectsFound,
    /// P and b explain all.
    Sound,
}

impl Standing {
    /// All, the worst first.
    pub const ALL: [Self; 8] = [
        Self::NotFlown,
        Self::Wrong,
        Self::Unexplained,
        Self::LeftIn,
        Self::TooLittleMotion,
        Self::NotLookedFor,
        Self::EffectsFound,
        Self::Sound,
    ];

    fn of(row: &Row) -> Self {
        if row.get("ok") != Some(&Value::Bool(true)) {
            return Self::NotFlown;
        }
        if wrong(row).is_some() {
            return Self::Wrong;
        }
        match row.get("diagnosis_verdict").and_then(Value::as_str) {
            Some("model_sufficient") => Self::Sound,
            Some("effects_found") if text(row, "effects_left").is_some_and(|left| !left.is_empty()) => Self::LeftIn,
            Some("effects_found") => Self::EffectsFound,
            Some("not_enough_excitation") => Self::TooLittleMotion,
            Some(_) => Self::Unexplained,
            None => Self::NotLookedFor,
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::NotFlown => "not flown",
            Self::Wrong => "units, signs or axes wrong",
            Self::Unexplained => "more left than noise",
            Self::LeftIn => "an error was found and is left in",
            Self::TooLittleMotion => "moved too little",
            Self::NotLookedFor => "effects not looked for",
            Self::EffectsFound => "effects taken out",
            Self::Sound => "sound",
        }
    }

    /// Returns true if somebody should look at the recording.
    #[must_use]
    pub fn is_sound(self) -> bool {
        self >= Self::NotLookedFor
    }
}

/// P and b with their deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// P, row by row.
    pub p: [f64; 9],
    /// Bias, rad/s.
    pub b_rad_s: [f64; 3],
    /// Deviations of the nine and the three.
    pub sigma: [f64; 12],
}

impl Parameters {
    /// Parameters in the columns that begin with `before`; `None` unless all are there.
    fn of(row: &Row, before: &str) -> Option<Self> {
        let mut read = Self::default();
        for (name, values) in [("P", &mut read.p[..]), ("b_rad_s", &mut read.b_rad_s), ("sigma", &mut read.sigma)] {
            for (index, value) in values.iter_mut().enumerate() {
                *value = number(row, &format!("{before}{name}_{index}"))?;
            }
        }
        Some(read)
    }

    /// P less the identity, in percent: element and deviation.
    #[must_use]
    pub fn percent(&self, element: usize) -> [f64; 2] {
        let of_unity = if element.is_multiple_of(4) { 1.0 } else { 0.0 };
        [100.0 * (self.p[element] - of_unity), 100.0 * self.sigma[element]]
    }

    /// Distance of P from the identity: root of the mean square of its elements, percent.
    #[must_use]
    pub fn off_percent(&self) -> f64 {
        ((0..9).map(|element| self.percent(element)[0].powi(2)).sum::<f64>() / 9.0).sqrt()
    }

    /// Size of the bias, degrees per second.
    #[must_use]
    pub fn bias_deg_s(&self) -> f64 {
        self.b_rad_s.iter().map(|b| b * b).sum::<f64>().sqrt().to_degrees()
    }
}

/// A window of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// True if its result flew.
    pub accepted: bool,
    /// Its fit, where it has one.
    pub fit: Option<Parameters>,
    /// Squared innovations over expected.
    pub nis: Option<f64>,
}

/// A recording of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Path, as the batch had it.
    pub path: String,
    /// Hash of the recording and of all else that its result depends on.
    pub hash: String,
    /// Its own report, as a link from the fleet's page.
    pub report: Option<String>,
    /// Serial number of the probe.
    pub serial: Option<String>,
    /// Day of the recording.
    pub date: Option<NaiveDate>,
    /// Standing of the recording.
    pub standing: Standing,
    /// Why it could not be flown, or should not have been.
    pub error: Option<String>,
    /// Names of the effects that were found, each once.
    pub effects: Vec<String>,
    /// Those of them that are not taken out.
    pub left: Vec<String>,
    /// True if something is to be said of the trace.
    pub has_notes: bool,
    /// Length, seconds.
    pub duration_s: Option<f64>,
    /// P and b at the end; only where a window was accepted.
    pub last: Option<Parameters>,
    /// Field as the gyro predicts it over a second, against the measured one: before and after, degrees.
    pub field_deg: [Option<f64>; 2],
    /// Two seconds of rotation against the reference, with the bias alone taken out and as flown, degrees; with one
    /// delay taken out where there is one.
    pub rotation_deg: [Option<f64>; 2],
    /// Its windows, in their order.
    pub windows: Vec<Window>,
}

impl Recording {
    fn of(row: &Row) -> Self {
        let names = |column: &str| {
            let names = text(row, column).unwrap_or_default();
            let mut names: Vec<String> = names.split(',').filter(|name| !name.is_empty()).map(str::to_owned).collect();
            names.sort();
            names.dedup();
            names
        };
        let accepted = number(row, "windows_accepted").unwrap_or(0.0);
        let both = |first: &str, second: &str| [first, second].map(|name| number(row, name));
        let rotation = |kind: &str| {
            let rotation = format!("reference_orientation_2s_rms_{kind}deg_");
            both(&format!("{rotation}bias_only"), &format!("{rotation}with_effects"))
        };
        let aligned = rotation("time_aligned_");
        Self {
            path: text(row, "path").unwrap_or_default(),
            hash: text(row, "hash").unwrap_or_default(),
            report: None,
            serial: text(row, "trace_serial"),
            date: text(row, "trace_date").and_then(|date| date.parse().ok()),
            standing: Standing::of(row),
            error: text(row, "error").or_else(|| wrong(row).map(|wrong| wrong.replace('\n', "; "))),
            effects: names("effects"),
            left: names("effects_left"),
            has_notes: text(row, "notes").is_some_and(|notes| !notes.is_empty()),
            duration_s: number(row, "trace_duration_s"),
            last: Parameters::of(row, "identification_final_").filter(|_| accepted > 0.0),
            field_deg: both("diagnosis_residual_magnetic_deg_before", "diagnosis_residual_magnetic_deg_after"),
            rotation_deg: if aligned.iter().any(Option::is_some) { aligned } else { rotation("") },
            windows: Vec::new(),
        }
    }

    /// Name of the file, without its ending.
    #[must_use]
    pub fn name(&self) -> &str {
        let name = self.path.rsplit(['/', '\\']).next().unwrap_or_default();
        let name = name.strip_suffix(".gz").unwrap_or(name);
        name.strip_suffix(".csv").unwrap_or(name)
    }

    /// Windows whose result flew.
    #[must_use]
    pub fn accepted(&self) -> usize {
        self.windows.iter().filter(|window| window.accepted).count()
    }
}

/// Reads the tables of one or more batches. The worst recording comes first: by its standing, then by what is left of
/// the field.
///
/// # Errors
/// A table is missing, is no Parquet file, or is not a batch's.
pub fn read(tables: &[impl AsRef<Path>]) -> Result<Vec<Recording>, Failure> {
    read_and_replaced(tables).map(|(recordings, _)| recordings)
}

/// Reads tables as [`read`] does. A recording that two tables have is that of the later one: the lines tell of which
/// table how many were replaced. Recordings are one if their bytes and the names of their files are the same, wherever
/// the files are.
///
/// # Errors
/// As of [`read`].
pub fn read_and_replaced(tables: &[impl AsRef<Path>]) -> Result<(Vec<Recording>, Vec<String>), Failure> {
    let mut all: BTreeMap<[String; 2], Vec<(usize, Recording)>> = BTreeMap::new();
    let mut replaced = vec![0; tables.len()];
    for (place, path) in tables.iter().map(AsRef::as_ref).enumerate() {
        let rows = tables::rows(path)?;
        if rows.iter().any(|row| !row.contains_key("ok") || !row.contains_key("path")) {
            let why = "is no table of recordings; `cargo mwd batch` writes one";
            return Err(Failure::BadInput(format!("{}: {why}", path.display())));
        }
        let mut windows: BTreeMap<String, Vec<Window>> = BTreeMap::new();
        for row in tables::rows(&path.with_extension("windows.parquet"))? {
            let of = windows.entry(text(&row, "path").unwrap_or_default()).or_default();
            of.push(Window {
                accepted: row.get("accepted") == Some(&Value::Bool(true)),
                fit: Parameters::of(&row, ""),
                nis: number(&row, "innovation_nis"),
            });
        }
        for row in &rows {
            let mut recording = Recording::of(row);
            recording.windows = windows.remove(&recording.path).unwrap_or_default();
            let content = text(row, "recording").unwrap_or_else(|| recording.path.clone());
            let same = all.entry([content, recording.name().to_owned()]).or_default();
            // Copies in two folders of one batch are two recordings.
            for (earlier, _) in same.extract_if(.., |(earlier, _)| *earlier < place) {
                replaced[earlier] += 1;
            }
            same.push((place, recording));
        }
    }
    let mut all: Vec<Recording> = all.into_values().flatten().map(|(_, recording)| recording).collect();
    let left = |recording: &Recording| recording.field_deg[1].unwrap_or(0.0);
    all.sort_by(|a, b| a.standing.cmp(&b.standing).then(left(b).total_cmp(&left(a))).then(a.path.cmp(&b.path)));
    let told = tables.iter().zip(replaced).filter(|(_, count)| *count > 0);
    let told = told.map(|(path, count)| {
        format!("{count} recordings of {} are replaced by those of a later table", path.as_ref().display())
    });
    Ok((all, told.collect()))
}

/// Units, signs and axes that cannot be, a line each; `None` for a sound recording.
fn wrong(row: &Row) -> Option<String> {
    text(row, "wrong").filter(|wrong| !wrong.is_empty())
}

fn text(row: &Row, name: &str) -> Option<String> {
    row.get(name)?.as_str().map(str::to_owned)
}

fn number(row: &Row, name: &str) -> Option<f64> {
    row.get(name)?.as_f64()
}
