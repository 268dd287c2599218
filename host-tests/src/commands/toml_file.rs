//! TOML files that a command line names.

use std::{fs, path::Path};

use serde::de::DeserializeOwned;

use testbed::failure::Failure;

/// Reads a file; fields that it does not name take their defaults, if they have any.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
    let text = fs::read_to_string(path).map_err(|error| Failure::unread(path, &error))?;
    toml::from_str(&text).map_err(|e| bad(e.to_string().trim_end().replace('\n', " ")))
}
