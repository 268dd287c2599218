//! The files that others read.

pub mod csv;
pub mod las;
pub mod wits0;
mod witsml;
pub mod witsml1;
pub mod witsml2;

use std::{fmt::Write as _, path::Path};

use super::run::SurveyedRun;
use testbed::failure::Failure;

/// Writes a text to a file.
///
/// # Errors
/// The file cannot be written.
pub fn save(path: &Path, text: &str) -> Result<(), Failure> {
    testbed::console::save(path, text).map_err(|error| Failure::output(path, &error))
}

/// The run as JSON, schema `meerkat-mwd-survey/1`.
///
/// # Errors
/// Never for a run of finite numbers.
pub fn json(run: &SurveyedRun) -> anyhow::Result<String> {
    let mut document = serde_json::to_value(run)?;
    if let Some(object) = document.as_object_mut() {
        object.insert("schema".to_owned(), "meerkat-mwd-survey/1".into());
    }
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}

/// Appends formatted text. Writing to a string does not fail.
fn push(text: &mut String, line: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(line);
}
