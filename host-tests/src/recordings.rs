//! Recordings of real sensors: those of this repository, and a folder of others.

use std::{
    io,
    path::{Path, PathBuf},
};

/// The environment variable that names a folder of further recordings.
pub const FOLDER: &str = "MWD_RECORDINGS";

/// The recordings of this repository, in the order of their names.
///
/// # Errors
/// Their folder cannot be read.
pub fn bundled() -> io::Result<Vec<PathBuf>> {
    within(&Path::new(env!("CARGO_MANIFEST_DIR")).join("traces"))
}

/// Those of the folder that [`FOLDER`] names, in the order of their names; none without it.
///
/// # Errors
/// The folder cannot be read.
pub fn given() -> io::Result<Vec<PathBuf>> {
    std::env::var_os(FOLDER).map_or_else(|| Ok(Vec::new()), |folder| within(Path::new(&folder)))
}

/// The file's name without what all of them end in.
#[must_use]
pub fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.trim_end_matches(ENDING).to_owned()
}

const ENDING: &str = ".csv.gz";

fn within(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(ENDING));
    paths.sort();
    Ok(paths)
}
