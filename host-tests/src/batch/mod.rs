//! Many recordings at once: each flown on its own, its result kept under a hash of all that it depends on,
//! so that a run goes on where it stopped; three tables of all of them at the end.

mod alone;
mod flown;
pub mod inputs;
mod key;
mod options;
mod parquet_file;
mod parts;
mod schema;

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
};

use rayon::prelude::*;

pub use alone::alone;
pub use flown::{Result, result};
pub use key::{Key, program};
pub use options::Options;

use flown::Beside;
use parquet_file::Tables;
pub use parquet_file::tables;
use parts::{Part, Parts};
use testbed::{
    failure::Failure,
    trace::{Fault, TraceError},
};

/// Results that are read together for the tables: their JSON is ten times as large in memory as in its file.
const AT_ONCE: usize = 32;

/// Counts of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Recordings in the tables.
    pub recordings: usize,
    /// Number of these that were flown in this run.
    pub flown: usize,
    /// Number of these that were refused; their rows say why.
    pub bad: usize,
    /// Seconds of recordings that were flown in this run.
    pub flown_s: f64,
}

/// Flies all recordings and writes the tables.
///
/// `progress` is called after each recording with the seconds that it holds; `threads` is how many fly at
/// once.
///
/// # Errors
/// Something cannot be written. What is wrong with a recording is in its row.
pub fn run(
    paths: &[PathBuf],
    results: &Path,
    options: &Options,
    threads: usize,
    progress: impl Fn(f64) + Sync,
) -> std::result::Result<Tally, Failure> {
    let parts = Parts::beside(results)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::BadInput(format!("{threads} threads cannot be had: {error}")))?;
    let keyed: Vec<std::result::Result<(Key, f64), Failure>> = pool.install(|| {
        let one = |path: &PathBuf| {
            let outcome = one(path, &parts, options);
            progress(outcome.as_ref().map_or(0.0, |(_, seconds)| *seconds));
            outcome
        };
        // One at a time: recordings differ in length.
        paths.par_iter().with_max_len(1).map(one).collect()
    });
    let mut tally = Tally { recordings: paths.len(), ..Tally::default() };
    let mut tables = Tables::create(results)?;
    let keyed = keyed.into_iter().collect::<std::result::Result<Vec<_>, _>>()?;
    // A share at a time, so that the rows of all need not be in memory.
    for (paths, keyed) in paths.chunks(AT_ONCE).zip(keyed.chunks(AT_ONCE)) {
        let read = |(path, (key, _)): (&PathBuf, &(Key, f64))| {
            let part = parts.read(key)?;
            Ok((part.error.is_some(), schema::rows(path, key, &part)))
        };
        let read: Vec<std::result::Result<_, Failure>> =
            pool.install(|| paths.par_iter().zip(keyed).map(read).collect());
        for (read, (_, seconds)) in read.into_iter().zip(keyed) {
            let (is_bad, rows) = read?;
            tally.bad += usize::from(is_bad);
            tally.flown += usize::from(*seconds >= 0.0);
            tally.flown_s += seconds.max(0.0);
            tables.push(&rows)?;
        }
    }
    tables.finish()?;
    Ok(tally)
}

/// The message of an error without the file's name: a copy of the file has the same result.
fn without_path(message: &str, path: &Path) -> String {
    message.replace(&path.display().to_string(), "").trim_start_matches([',', ':', ' ']).to_owned()
}

/// Flies one recording unless its result is there; its key, and the seconds that were flown, less than zero
/// if none were.
fn one(path: &Path, parts: &Parts, options: &Options) -> std::result::Result<(Key, f64), Failure> {
    let key = match Key::of(path, options) {
        Ok(key) => key,
        Err(error) => {
            // A file that cannot be read has no content to be known by.
            let key = Key::of_path(path);
            parts.write(&key, &Part::refused(format!("cannot be read: {error}")))?;
            return Ok((key, 0.0));
        }
    };
    let beside = Beside::of(path, &key, options);
    if parts.has(&key) && beside.is_there() {
        return Ok((key, -1.0));
    }
    let (part, is_of_the_input) = flown_or_refused(path, options, &beside);
    // A full disk says nothing of the recording: the next run tries again.
    let key = if is_of_the_input { key } else { Key::of_path(path) };
    parts.write(&key, &part)?;
    Ok((key, part.duration_s()))
}

/// Flies one recording: its part, and whether the same recording with the same options gives that again.
fn flown_or_refused(path: &Path, options: &Options, beside: &Beside) -> (Part, bool) {
    let (part, is_of_the_input) = match catch_unwind(AssertUnwindSafe(|| flown::fly(path, options, beside))) {
        Ok(Ok(part)) => (part, true),
        Ok(Err(error)) => {
            (Part::refused(without_path(&error.to_string(), path)).of_probe(path), is_of_the_input(&error))
        }
        Err(_) => (Part::refused("a defect of this program: it panicked".into()).of_probe(path), true),
    };
    (Part { recording: Key::of_bytes(path).map(|hash| hash.text().to_owned()), ..part }, is_of_the_input)
}

/// Returns true if the same recording with the same options fails so again.
fn is_of_the_input(error: &anyhow::Error) -> bool {
    let of_trace = error.downcast_ref().map(|error: &TraceError| {
        !matches!(error.fault, Fault::NotOpened(_) | Fault::NotRead(_) | Fault::NotWritten(_))
    });
    let of_failure =
        error.downcast_ref().map(|failure: &Failure| matches!(failure, Failure::Config(_) | Failure::BadInput(_)));
    of_trace.or(of_failure).unwrap_or(false)
}
