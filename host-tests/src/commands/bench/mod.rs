//! `mwd bench`: every measurement of `docs/measurements`, from seeds, as tables on the terminal, as JSON and as
//! Markdown.

mod page;
mod sections;

use std::{
    io::{self, IsTerminal, Write},
    path::{Path, PathBuf},
};

use clap::Args;
use serde_json::json;

use crate::bench::does_not_hold::DoesNotHold;
use sections::{Place, SECTIONS, Section};
use testbed::study::Effort;
use testbed::{
    console::{save, told},
    failure::Failure,
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
    /// Begin with this seed: `--seeds 1 --first-seed 4611` flies one run of whole_probe again
    #[arg(long, value_name = "SEED", requires = "seeds")]
    pub first_seed: Option<u64>,
    /// Run the sections for the emulated chip instead of those for this machine
    #[arg(long)]
    pub target: bool,
    /// Run only this section; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write the tables as JSON
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write each section's tables as a page NAME.md into this folder
    #[arg(long, value_name = "DIR")]
    pub markdown: Option<PathBuf>,
}

/// Runs the sections asked for, prints each one's tables when they are done, and writes them as JSON and as pages.
///
/// # Errors
/// There is no such section, one cannot be run, a result cannot be written, or something that has to hold does not:
/// then all is printed and written, and every section was run.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    let effort = match args.seeds {
        Some(seeds) => args.first_seed.map_or(Effort::Seeds(seeds), |first| Effort::These { first, seeds }),
        None if args.quick => Effort::Quick,
        None => Effort::Full,
    };
    let sections = asked_for(args)?;
    if let (Some(_), Some(other)) = (args.first_seed, sections.iter().find(|section| !section.tells_seeds)) {
        return Err(Failure::BadInput(format!(
            "--first-seed: {} has seeds of its own; use --only whole_probe or --only sweep",
            other.name
        ))
        .into());
    }
    measure(&sections, effort, args)
}

fn measure(sections: &[&Section], effort: Effort, args: &BenchArgs) -> anyhow::Result<()> {
    let mut out = told();
    let (mut all, mut do_not_hold) = (Vec::new(), Vec::new());
    for section in sections {
        if io::stderr().is_terminal() {
            eprintln!("{}", section.name);
        }
        let tables = match (section.run)(effort) {
            Ok(tables) => tables,
            Err(error) => {
                let DoesNotHold { tables, words } = error.downcast()?;
                do_not_hold.push(format!("{}: {words}", section.name));
                tables
            }
        };
        for table in &tables {
            writeln!(out, "{table}")?;
            out.flush()?;
            all.push(json!({ "section": section.name, "table": table }));
        }
        if let Some(folder) = &args.markdown {
            page::write(folder, section, effort, &tables)?;
        }
    }
    if let Some(path) = &args.json {
        write_json(path, &all)?;
    }
    anyhow::ensure!(do_not_hold.is_empty(), "{}", do_not_hold.join("\n"));
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
    Ok(save(path, &text).map_err(|error| Failure::output(path, &error))?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use testbed::study::Table;

    fn lossy(_: Effort) -> anyhow::Result<Vec<Table>> {
        Err(DoesNotHold { tables: vec![Table::new("What was lost", &["a"])], words: "one is lost".to_owned() }.into())
    }

    fn broken(_: Effort) -> anyhow::Result<Vec<Table>> {
        anyhow::bail!("it cannot be run")
    }

    #[test]
    fn a_section_in_which_something_does_not_hold_has_its_page_and_ends_with_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let [json, markdown] = ["all.json", "pages"].map(|name| Some(folder.path().join(name)));
        let args =
            BenchArgs { quick: false, seeds: None, first_seed: None, target: false, only: vec![], json, markdown };
        let section = |name, run| Section {
            name,
            about: "Losses",
            place: Place::Host,
            takes_recordings: false,
            tells_seeds: false,
            run,
        };
        let [one, other] = [section("one", lossy), section("other", |_| Ok(vec![Table::new("Sound", &["b"])]))];
        let told = measure(&[&one, &other], Effort::Full, &args).unwrap_err().to_string();
        assert_eq!(told, "one: one is lost");
        let page = |name: &str| std::fs::read_to_string(folder.path().join("pages").join(name)).unwrap();
        assert!(page("one.md").contains("What was lost") && page("other.md").contains("Sound"));
        assert!(std::fs::read_to_string(folder.path().join("all.json")).unwrap().contains("What was lost"));
        // A section that cannot be run at all ends the bench.
        let told = measure(&[&section("none", broken), &other], Effort::Full, &args).unwrap_err().to_string();
        assert_eq!(told, "it cannot be run");
    }
}
