//! `mwd man`: manual pages of the commands.

use std::{fs, path::PathBuf};

use clap::{Args, CommandFactory};

use super::Cli;
use crate::failure::Failure;

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
    println!("written; read one by: man {}/mwd-replay.1", args.folder.display());
    Ok(())
}
