//! `mwd fleet`: the recordings of one or more batches beside each other, as a page.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use clap::Args;

use super::same_file::same_file;
use crate::{
    failure::Failure,
    fleet::{Recording, drift::probes, read},
    report::html::{fleet, write_page},
};

/// Recordings that are listed on a terminal.
const LISTED: usize = 5;

/// Options of `fleet`.
#[derive(Debug, Clone, Args)]
pub struct FleetArgs {
    /// Tables of recordings as `batch` writes them; those of their windows are read beside them
    #[arg(required = true, value_name = "RESULTS.parquet")]
    pub tables: Vec<PathBuf>,
    /// Where to write the page
    #[arg(long, value_name = "OUT.html", default_value = "mwd-fleet.html")]
    pub html: PathBuf,
}

/// Writes the page and prints the worst.
///
/// # Errors
/// A table cannot be used, or the page cannot be written.
pub fn run(args: &FleetArgs) -> anyhow::Result<()> {
    if args.tables.iter().any(|table| same_file(table, &args.html)) {
        return Err(Failure::BadInput(format!("{}: the page would overwrite a table", args.html.display())).into());
    }
    let recordings = read(&args.tables)?;
    write(&recordings, &args.tables, &args.html)?;
    let mut out = anstream::stdout().lock();
    writeln!(out, "{}", fleet::verdict(&recordings).1)?;
    for recording in recordings.iter().filter(|recording| !recording.standing.is_sound()).take(LISTED) {
        let why = recording.error.as_ref().map_or_else(String::new, |why| format!(": {why}"));
        writeln!(out, "  {} {}{why}", recording.standing.words(), recording.path)?;
    }
    let drifting = probes(&recordings);
    let moving = drifting.iter().filter(|probe| probe.moves(drifting.len()).is_some()).count();
    if !drifting.is_empty() {
        writeln!(out, "P of {moving} of {} probes with dated recordings moves by more than chance.", drifting.len())?;
    }
    writeln!(
        out,
        "Next: open {} in a browser; `cargo mwd replay RECORDING --html OUT.html` shows one of them.",
        args.html.display()
    )?;
    Ok(())
}

/// Writes the page of recordings.
///
/// # Errors
/// When it cannot be written.
pub fn write(recordings: &[Recording], tables: &[PathBuf], page: &Path) -> Result<(), Failure> {
    write_page(page, &fleet::page(recordings, tables))
}
