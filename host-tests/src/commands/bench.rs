//! `mwd bench`: every figure that the README shows, from seeds, as tables on the terminal and as JSON.

use std::{
    io::{self, IsTerminal, Write},
    path::{Path, PathBuf},
};

use clap::Args;
use serde_json::json;

use crate::{
    bench::{
        Effort, Table, attitude, attitude_cost, benefit, bus, bus_faults, coverage, drilling, effects, hour,
        rate_error, recordings, sensors, swaps, target, turntable, whole_probe,
    },
    failure::Failure,
    research::{contaminated, evaluations, inclination, paper},
};

/// Options of `bench`.
#[derive(Debug, Clone, Args)]
pub struct BenchArgs {
    /// Take a tenth of the repetitions, at least three
    #[arg(long)]
    pub quick: bool,
    /// Take this many repetitions of each measurement
    #[arg(long, value_name = "N", conflicts_with = "quick", value_parser = clap::value_parser!(u64).range(1..))]
    pub seeds: Option<u64>,
    /// Run the sections for the emulated chip instead of those for this machine
    #[arg(long)]
    pub target: bool,
    /// Run only this section; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write the tables as JSON
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
}

/// One section of the bench: a name, and what prints its tables.
struct Section {
    /// Its name on the command line.
    name: &'static str,
    place: Place,
    run: fn(Effort) -> anyhow::Result<Vec<Table>>,
}

/// Where a section runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// On this machine.
    Host,
    /// On the emulated chip: with `--target`, which runs nothing else.
    Target,
}

impl Section {
    const fn on_host(name: &'static str, run: fn(Effort) -> anyhow::Result<Vec<Table>>) -> Self {
        Self { name, place: Place::Host, run }
    }
}

/// All sections, in the order in which they are printed.
const SECTIONS: &[Section] = &[
    Section::on_host("rate_error", rate_error::run),
    Section::on_host("inclination", inclination::run),
    Section::on_host("evaluations", evaluations::run),
    Section::on_host("paper", paper::run),
    Section::on_host("coverage", coverage::run),
    Section::on_host("contaminated", contaminated::run),
    Section::on_host("turntable", turntable::run),
    Section::on_host("hour", hour::run),
    Section::on_host("swaps", swaps::run),
    Section::on_host("effects", effects::run),
    Section::on_host("recordings", recordings::run),
    Section::on_host("benefit", benefit::run),
    Section::on_host("attitude", attitude::run),
    Section::on_host("bus_faults", bus_faults::run),
    Section::on_host("sensors", sensors::run),
    Section::on_host("whole_probe", whole_probe::run),
    Section { name: "target", place: Place::Target, run: target::run },
    Section { name: "bus", place: Place::Target, run: bus::run },
    Section::on_host("drilling", drilling::run),
    Section { name: "attitude_cost", place: Place::Target, run: attitude_cost::run },
];

/// Runs the sections asked for, prints each table when it is done and writes them all as JSON.
///
/// # Errors
/// There is no such section, one cannot be run, or the result cannot be written.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    let effort = match args.seeds {
        Some(seeds) => Effort::Seeds(seeds),
        None if args.quick => Effort::Quick,
        None => Effort::Full,
    };
    let sections = asked_for(args)?;
    let mut out = io::stdout().lock();
    let mut all = Vec::new();
    for section in sections {
        if io::stderr().is_terminal() {
            eprintln!("{}", section.name);
        }
        for table in (section.run)(effort)? {
            writeln!(out, "{table}")?;
            out.flush()?;
            all.push(json!({ "section": section.name, "table": table }));
        }
    }
    if let Some(path) = &args.json {
        write_json(path, &all)?;
    }
    Ok(())
}

/// Sections that run at the place asked for: all of them, or those named by `--only`.
fn asked_for(args: &BenchArgs) -> Result<Vec<&'static Section>, Failure> {
    let place = if args.target { Place::Target } else { Place::Host };
    let there: Vec<&Section> = SECTIONS.iter().filter(|section| section.place == place).collect();
    let elsewhere = |name: &&String| SECTIONS.iter().any(|section| section.name == **name && section.place != place);
    if let Some(name) = args.only.iter().find(elsewhere) {
        let how = if args.target { "runs without --target" } else { "needs --target" };
        return Err(Failure::BadInput(format!("--only {name}: {how}")));
    }
    if let Some(unknown) = args.only.iter().find(|name| there.iter().all(|section| section.name != *name)) {
        let names: Vec<&str> = there.iter().map(|section| section.name).collect();
        let target = if args.target { " with --target" } else { "" };
        let names = names.join(", ");
        return Err(Failure::BadInput(format!("--only {unknown}: no such section{target}; there are {names}")));
    }
    Ok(there
        .into_iter()
        .filter(|section| args.only.is_empty() || args.only.iter().any(|name| name == section.name))
        .collect())
}

fn write_json(path: &Path, tables: &[serde_json::Value]) -> anyhow::Result<()> {
    let document = json!({ "schema": "meerkat-mwd-bench/1", "tables": tables });
    let text = serde_json::to_string_pretty(&document)? + "\n";
    Ok(std::fs::write(path, text).map_err(|error| Failure::output(path, &error))?)
}
