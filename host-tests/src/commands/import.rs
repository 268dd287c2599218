//! `mwd import`: foreign recordings to a trace.

use std::{
    ffi::OsString,
    io::Write,
    path::{Path, PathBuf},
};

use clap::Args;

use super::same_file::same_file;
use crate::import::{ColumnMap, files, import};
use testbed::{
    console::{is_stdio, told},
    failure::Failure,
};

/// Options of `import`.
#[derive(Debug, Clone, Args)]
pub struct ImportArgs {
    /// Files or folders of one recording; - reads the standard input
    #[arg(required = true, value_name = "SOURCE")]
    pub sources: Vec<PathBuf>,
    /// Where to write the trace, .csv or .csv.gz, or - for the standard output; the map goes beside a file. Without it
    /// the source is only looked at
    #[arg(short, value_name = "TRACE.csv.gz")]
    pub output: Option<PathBuf>,
    /// Columns, units and clocks that win over the guess
    #[arg(long, value_name = "MAP.toml")]
    pub map: Option<PathBuf>,
    /// Key of the trace's header, such as body_frame=tool; any number of times
    #[arg(long = "key", value_name = "KEY=VALUE", value_parser = key)]
    pub keys: Vec<(String, String)>,
    /// Write the trace although the gate found it wrong
    #[arg(long)]
    pub force: bool,
    /// Refuse a source that is cut off or damaged instead of reading the rest, and one with repeated, late or missing
    /// times instead of dropping these rows
    #[arg(long)]
    pub strict: bool,
}

fn key(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("must be KEY=VALUE")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Reads a source, prints what was understood and found, and writes the trace with its map.
///
/// # Errors
/// The source cannot be read or understood, or the gate found it wrong.
pub fn run(args: &ImportArgs) -> anyhow::Result<()> {
    // Nothing stands beside the standard output.
    let map_file = args.output.as_deref().filter(|output| !is_stdio(output)).map(beside);
    let read: Vec<Vec<PathBuf>> = args.sources.iter().map(|source| files(source)).collect::<Result<_, _>>()?;
    for output in [&args.output, &map_file].into_iter().flatten() {
        if read.iter().flatten().chain(&args.map).any(|read| same_file(output, read)) {
            return Err(Failure::BadInput(format!(
                "{}: the trace would overwrite what it is made of",
                output.display()
            ))
            .into());
        }
    }
    let map = args.map.as_deref().map_or_else(|| Ok(ColumnMap::default()), ColumnMap::read)?;
    let imported = import(&args.sources, &map, &args.keys)?;
    let mut out = told();
    imported.describe(&mut out)?;
    let refuse = |why: String| Err(Failure::BadInput(why).into());
    if args.strict && !imported.lost.is_empty() {
        return refuse(format!("{}; --strict forbids that", imported.lost.join("; ")));
    }
    if args.strict && imported.dropped() > 0 {
        return refuse(format!(
            "{} rows have a repeated, late or missing time, and --strict forbids to drop them",
            imported.dropped()
        ));
    }
    if imported.is_wrong() && !args.force {
        return refuse("no trace is written: the lines marked WRONG cannot be. Put the fix into a file for --map, or insist by --force".into());
    }
    let Some(path) = &args.output else {
        writeln!(out, "nothing is written without -o; this is the map:\n\n{}", imported.map.to_toml())?;
        return Ok(());
    };
    imported.trace.write(path)?;
    if let Some(map_file) = &map_file {
        std::fs::write(map_file, imported.map.to_toml()).map_err(|error| Failure::output(map_file, &error))?;
    }
    let (samples, seconds) = (imported.trace.samples.len(), imported.trace.duration_s());
    let beside = map_file.map_or_else(String::new, |map_file| format!("; map in {}", map_file.display()));
    writeln!(out, "{}: {samples} samples, {seconds:.3} s{beside}", path.display())?;
    writeln!(out, "Next: `cargo mwd replay {} --html report.html` flies it.", path.display())?;
    Ok(())
}

/// The map's file beside a trace.
fn beside(trace: &Path) -> PathBuf {
    let mut name = OsString::from(trace.file_name().unwrap_or_default());
    name.push(".map.toml");
    trace.with_file_name(name)
}
