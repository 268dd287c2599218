//! Why a scenario cannot be simulated.

use std::path::PathBuf;

/// An error in a scenario or its file.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file is not TOML, or holds a field that no scenario has.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: Box<toml::de::Error>,
    },
    /// A value cannot be used.
    #[error("scenario: {field} must be {must_be}")]
    Field {
        /// The field, with its table.
        field: &'static str,
        /// The values that it may have.
        must_be: &'static str,
    },
}
