//! Foreign recordings to traces: files to tables, tables to sensors by a map, sensors on one clock, and a
//! gate that refuses what cannot be.

mod account;
mod clock_time;
mod column_map;
mod delimited;
mod gate;
mod matlab;
mod mcap;
mod median;
mod merged;
mod names;
mod one_clock;
mod own_columns;
mod parquet_file;
pub mod plausible;
mod resolve;
mod ros_message;
mod rotation_fit;
mod series;
mod source;
mod table;
mod text;
mod time_stamps;
mod ulog;
mod unused_columns;
mod units;

use std::{
    io::{self, Write},
    path::PathBuf,
};

pub use column_map::{ColumnMap, Part};
pub use gate::{Finding, Verdict};
pub use source::{STDIN, files};

use merged::{Merged, merged};
use own_columns::OwnColumns;
use resolve::{Resolved, guesses, resolve};
use rotation_fit::fit;
use series::{Series, series};
use table::{Contents, Table};
use units::Quantity;
use unused_columns::{each_once, unused_columns};

use testbed::{
    failure::Failure,
    trace::{Keys, Trace},
};

/// A recording as it was understood.
#[derive(Clone, Debug)]
pub struct Import {
    /// The trace.
    pub trace: Trace,
    /// The whole map.
    pub map: ColumnMap,
    /// Findings of the gate.
    pub findings: Vec<Finding>,
    /// Reasons for which a part of a file is not read: it is cut off or damaged.
    pub lost: Vec<String>,
    parts: Vec<Resolved>,
    all: Vec<Series>,
    merged: Merged,
}

/// Imports files, folders or the standard input ([`STDIN`]); what `map` leaves open is guessed, and `keys`
/// are those of the header that the command line sets.
///
/// # Errors
/// Description of what cannot be read or understood, with its file and place.
pub fn import(sources: &[PathBuf], map: &ColumnMap, keys: &[(String, String)]) -> Result<Import, Failure> {
    let Contents { tables, lost, notes } = source::contents(sources, map.dialect)?;
    let (mut header, left_out) = header(sources, &tables, map, keys)?;
    let mut parts = resolve(&tables, map)?;
    let mut all = parts.iter().map(|part| series(&tables, part)).collect::<Result<Vec<_>, _>>()?;
    let own = OwnColumns::of(&tables, &parts, &all);
    each_once(&tables, &parts, &own)?;
    let unused = unused_columns(&tables, &parts, &own);
    let mut merged = merged(&parts, all.clone(), own)?;
    merged.notes.extend(lost.iter().cloned().chain(notes).chain(left_out).chain(unused));
    if map.gyro.unit.is_none() {
        by_the_vectors(&mut parts, &mut all, &mut merged);
    }
    merged.notes.extend(guesses(&parts));
    header.date = header.date.or_else(|| day_of(merged.start_s));
    let mut whole = ColumnMap { dialect: map.dialect, keys: map.keys.clone(), ..ColumnMap::default() };
    for part in &parts {
        *whole.part_mut(part.quantity) = part.part.clone();
    }
    let gyro = all.first().cloned().unwrap_or_default();
    let findings = gate::findings(&gate::Imported {
        merged: &merged,
        gyro: &gyro,
        all: &all,
        parts: &parts,
        map: &whole,
        keys: &header,
    });
    let trace = merged.trace(header);
    Ok(Import { trace, map: whole, findings, lost, parts, all, merged })
}

impl Import {
    /// Returns true if the gate found something that cannot be.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        self.findings.iter().any(|finding| finding.verdict == Verdict::Wrong)
    }

    /// Rows that were dropped for their time.
    #[must_use]
    pub fn dropped(&self) -> usize {
        // Sensors of one clock share their rows.
        let clocks: std::collections::BTreeMap<_, _> =
            self.all.iter().map(|series| (&series.clock, series.dropped())).collect();
        clocks.values().sum()
    }

    /// Writes the map and the findings.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn describe(&self, out: &mut impl Write) -> io::Result<()> {
        account::write(out, &self.parts, &self.all, &self.merged, &self.findings)
    }
}

/// Keys of the trace: those above the source's header row, over them the map's, over them the command line's; and a
/// note on each line of a trace's own header that is left out.
fn header(
    sources: &[PathBuf],
    tables: &[Table],
    map: &ColumnMap,
    given: &[(String, String)],
) -> Result<(Keys, Vec<String>), Failure> {
    let names: Vec<String> =
        sources.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
    let mut keys = Keys { source: Some(names.join(" ")), ..Keys::default() };
    let mut left_out = Vec::new();
    for table in tables {
        // A logger's own comments may look like keys; those of a trace are.
        let is_trace = ["t_s", "gx", "ax"].iter().all(|name| table.column(name).is_some());
        for (key, value) in &table.keys {
            let why = match keys.assign(key, value) {
                Ok(true) => continue,
                Ok(false) => format!("{key} = {value}: no key of a trace's header"),
                Err(fault) => fault.to_string(),
            };
            left_out.extend(is_trace.then(|| format!("left out of the header of {}: {why}", table.name)));
        }
    }
    let of_map = map.keys.iter().map(|(key, value)| {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        (key.clone(), text)
    });
    for (key, value) in of_map.chain(given.iter().cloned()) {
        let known =
            keys.assign(&key, &value).map_err(|fault| Failure::BadInput(format!("key of the header: {fault}")))?;
        if !known {
            return Err(Failure::BadInput(format!("{key} is no key of a trace's header; docs/commands.md lists them")));
        }
    }
    Ok((keys, left_out))
}

/// Day of a clock that counts seconds since 1970; none of one that counts from elsewhere.
fn day_of(start_s: i64) -> Option<chrono::NaiveDate> {
    let day = chrono::DateTime::from_timestamp(start_s, 0)?.date_naive();
    (2000..2100).contains(&chrono::Datelike::year(&day)).then_some(day)
}

/// A gyro whose unit only its size told gets the one that makes the vectors turn as they do.
fn by_the_vectors(parts: &mut [Resolved], all: &mut [Series], merged: &mut Merged) {
    let (Some(part), Some(series)) = (parts.first_mut(), all.first_mut()) else { return };
    if !part.unit_why.starts_with("by its size") {
        return;
    }
    let vectors = [&merged.mag, &merged.accel];
    let Some(fit) =
        vectors.into_iter().filter(|rows| !rows.is_empty()).find_map(|rows| fit(&merged.t_us, &merged.gyro, rows))
    else {
        return;
    };
    let now = part.part.unit.as_deref().and_then(|unit| Quantity::Gyro.unit(unit)).map_or(1.0, |unit| unit.factor);
    let fits = |unit: &&units::Unit| (0.7..1.4).contains(&(fit.scale * now / unit.factor));
    let Some(unit) = Quantity::Gyro.units().iter().find(fits) else { return };
    part.part.unit = Some(unit.name.to_owned());
    part.unit_why = "by the rate at which the vectors turn".into();
    for row in series.rows.iter_mut().chain(&mut merged.gyro) {
        row.iter_mut().for_each(|x| *x *= unit.factor / now);
    }
}
