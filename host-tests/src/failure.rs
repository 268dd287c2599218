//! Why a command ends without its result.

use std::path::{Path, PathBuf};

use meerkat_mwd::config::ConfigError;

/// Every way in which a command ends without its result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// A field of the configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Input or usage that no other variant names.
    #[error("{0}")]
    BadInput(String),
    /// Something that is needed is not there: a port, a key, an answer.
    #[error("{0}")]
    Missing(String),
    /// A result file cannot be written.
    #[error("{}: cannot be written: {why}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// What the system says.
        why: String,
    },
}

impl Failure {
    /// The failure to write `path`.
    #[must_use]
    pub fn output(path: &Path, error: &std::io::Error) -> Self {
        Self::Output { path: path.to_owned(), why: error.to_string() }
    }
}
