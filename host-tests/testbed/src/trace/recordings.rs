//! Recordings of real sensors: those of this repository, and a folder of others.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// The environment variable that names a folder of further recordings.
pub const FOLDER: &str = "MWD_RECORDINGS";

/// The recordings of this repository, in the order of their names.
///
/// # Errors
/// Their folder cannot be read.
pub fn bundled() -> Result<Vec<PathBuf>, Failure> {
    within(&folder())
}

/// The folder of the recordings of this repository.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("traces")
}

/// Recordings of the folder that [`FOLDER`] names, in the order of their names; none if it is not set.
///
/// # Errors
/// The folder cannot be read.
pub fn given() -> Result<Vec<PathBuf>, Failure> {
    std::env::var_os(FOLDER).map_or_else(|| Ok(Vec::new()), |folder| within(Path::new(&folder)))
}

/// Name of a recording: the file's name without its ending.
#[must_use]
pub fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.trim_end_matches(ENDING).to_owned()
}

const ENDING: &str = ".csv.gz";

fn within(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut paths = listed(folder)?;
    paths.retain(|path| path.to_string_lossy().ends_with(ENDING));
    Ok(paths)
}

/// Paths in a folder, in the order of their names.
///
/// # Errors
/// The folder cannot be read.
pub fn listed(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = || std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>();
    let mut paths = entries().map_err(|error| Failure::unread(folder, &error))?;
    paths.sort();
    Ok(paths)
}
