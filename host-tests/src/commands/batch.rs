//! `mwd batch`: flies many recordings at once and writes three tables.

use std::{
    io::Write,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;

use super::{
    fleet,
    hold_out::hold_out,
    same_file::{lies_in, none_overwritten},
};
use crate::{
    batch::{Options, inputs::Inputs, run as fly_all, tables},
    fleet::read,
};
use testbed::{
    console::told,
    failure::Failure,
    flight::configuration::{frozen_from_us, of_file},
    progress_bar::progress_bar,
    trace::Trace,
};

/// Options of `batch`.
#[derive(Debug, Clone, Args)]
pub struct BatchArgs {
    /// Traces, folders of traces, patterns in quotes, and @FILE for a list, one a line (@- reads the standard input)
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<String>,
    /// The table of recordings; those of windows and of stations are written beside it
    #[arg(short, value_name = "RESULTS.parquet")]
    pub output: PathBuf,
    /// Write the recordings as a page, the worst first, as `fleet` does
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Recordings flown at once; all processors without it
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Write the attitude of every sample of each recording into this folder
    #[arg(long, value_name = "DIR")]
    pub attitude_dir: Option<PathBuf>,
    /// Write the report of each recording into this folder, as `replay --html` does
    #[arg(long, value_name = "DIR")]
    pub html_dir: Option<PathBuf>,
    /// Configuration that overrides the traces' headers
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Hold out the last fraction F of each trace: freeze the parameters before it and score only there
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
    /// Seed of the searches
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Identify the 12 parameters only and look for no further effect
    #[arg(long)]
    pub no_effects: bool,
    /// Fly recordings whose units, signs or axes cannot be; nothing is identified from them
    #[arg(long)]
    pub force: bool,
}

/// Flies all recordings, writes the tables and prints what was done.
///
/// # Errors
/// An input names nothing, the configuration cannot be used, or an output cannot be written or would overwrite an input
/// or another one.
pub fn run(args: &BatchArgs) -> anyhow::Result<()> {
    let inputs = Inputs::of(&args.inputs)?;
    check_outputs(args, &inputs)?;
    let paths = inputs.recordings;
    if let Some(config) = args.config.as_deref() {
        // Settings that are wrong without a trace are wrong with every one.
        let trace = Trace::default();
        of_file(&trace, Some(config))?;
        frozen_from_us(&trace, args.hold_out, Some(config))?;
    }
    for folder in [&args.attitude_dir, &args.html_dir].into_iter().flatten() {
        std::fs::create_dir_all(folder).map_err(|error| Failure::output(folder, &error))?;
    }
    let options = Options {
        config: args.config.clone(),
        hold_out: args.hold_out,
        seed: args.seed,
        no_effects: args.no_effects,
        force: args.force,
        attitude_dir: args.attitude_dir.clone(),
        html_dir: args.html_dir.clone(),
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let (bar, began) = (progress_bar(paths.len()), Instant::now());
    let tally = fly_all(&paths, &args.output, &options, args.jobs.unwrap_or(processors).max(1), |_| bar.inc(1))?;
    bar.finish_and_clear();
    let seconds = began.elapsed().as_secs_f64();
    let mut out = told();
    writeln!(
        out,
        "{} recordings: {} flown now, {} from before; {} bad, each with its reason in the table",
        tally.recordings,
        tally.flown,
        tally.recordings - tally.flown,
        tally.bad
    )?;
    if tally.flown_s > 0.0 {
        writeln!(
            out,
            "{:.0} s of recordings in {seconds:.1} s, {:.0} times real time",
            tally.flown_s,
            tally.flown_s / seconds
        )?;
    }
    let tables = std::slice::from_ref(&args.output);
    if tally.bad > 0 || args.force {
        fleet::list(&mut out, read(tables)?.iter().filter(|recording| recording.error.is_some()))?;
    }
    writeln!(out, "{}, and beside it .windows.parquet and .stations.parquet", args.output.display())?;
    match &args.html {
        Some(page) => {
            let mut recordings = read(tables)?;
            if let Some(folder) = &args.html_dir {
                fleet::link(&mut recordings, folder, page);
            }
            fleet::write(&recordings, tables, page)?;
            writeln!(out, "Next: open {} in a browser.", page.display())?;
        }
        None => {
            writeln!(out, "Next: `cargo mwd fleet {}` shows them as a page, the worst first.", args.output.display())?;
        }
    }
    Ok(())
}

/// Refuses to overwrite an input, to write two results to one file, and to write attitudes, whose files end as those of
/// traces, where a later run would take them for recordings.
fn check_outputs(args: &BatchArgs, inputs: &Inputs) -> Result<(), Failure> {
    if let Some(folder) = &args.attitude_dir
        && let Some(read) = inputs.folders.iter().find(|read| lies_in(folder, read))
    {
        return Err(Failure::BadInput(format!(
            "{}: lies in a folder that is read, {}: its attitudes would be taken for recordings",
            folder.display(),
            read.display()
        )));
    }
    let tables = tables(&args.output);
    let outputs: Vec<&Path> = tables.iter().chain(&args.html).map(AsRef::as_ref).collect();
    let lists = args.inputs.iter().filter_map(|input| input.strip_prefix('@')).map(Path::new);
    let inputs: Vec<&Path> = inputs.recordings.iter().chain(&args.config).map(AsRef::as_ref).chain(lists).collect();
    none_overwritten(&outputs, &inputs)
}
