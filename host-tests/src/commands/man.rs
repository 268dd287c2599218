//! `mwd man`: manual pages of the commands.

use std::{fs, io::Write, path::PathBuf};

use clap::{Args, CommandFactory};

use super::Cli;
use testbed::{console, failure::Failure};

/// Options of `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// Folder for the pages; it is made if it is not there
    pub folder: PathBuf,
}

/// Writes a page for each command.
///
/// # Errors
/// When a file cannot be written.
pub fn run(args: &ManArgs) -> anyhow::Result<()> {
    let failed = |error: &std::io::Error| Failure::output(&args.folder, error);
    fs::create_dir_all(&args.folder).map_err(|error| failed(&error))?;
    clap_mangen::generate_to(Cli::command(), &args.folder).map_err(|error| failed(&error))?;
    for entry in fs::read_dir(&args.folder).map_err(|error| failed(&error))? {
        let path = entry.map_err(|error| failed(&error))?.path();
        if path.extension().is_some_and(|extension| extension == "1") {
            let page = fs::read_to_string(&path).map_err(|error| failed(&error))?;
            fs::write(&path, with_examples(&page)).map_err(|error| failed(&error))?;
        }
    }
    writeln!(console::told(), "written; read one by: man {}/mwd-replay.1", args.folder.display())?;
    Ok(())
}

/// A page whose examples have a section of their own, in which each is one line, as it is typed.
fn with_examples(page: &str) -> String {
    let Some((before, rest)) = page.split_once(".SH EXTRA\nExamples:\n") else { return page.to_owned() };
    let (examples, after) = rest.split_once("\n.SH ").unwrap_or((rest.trim_end(), ""));
    let after = if after.is_empty() { String::new() } else { format!(".SH {after}") };
    format!("{before}.SH EXAMPLES\n.nf\n{examples}\n.fi\n{after}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_has_its_examples_one_a_line() {
        let folder = tempfile::TempDir::new().unwrap_or_else(|error| panic!("{error}"));
        let folder = folder.path().join("new");
        assert!(run(&ManArgs { folder: folder.clone() }).is_ok());
        for command in Cli::command().get_subcommands() {
            let path = folder.join(format!("mwd-{}.1", command.get_name()));
            let page = fs::read_to_string(&path).unwrap_or_default();
            assert!(page.contains(".SH EXAMPLES\n.nf\n  cargo mwd ") && page.ends_with("\n.fi\n"), "{page}");
        }
        let all = fs::read_to_string(folder.join("mwd.1")).unwrap_or_default();
        assert!(all.contains("\\-\\-help\n.fi\n.SH VERSION\n"), "{all}");
    }
}
