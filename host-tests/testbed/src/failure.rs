//! Why a command ends without its result.

use std::path::{Path, PathBuf};

use meerkat_mwd::config::ConfigError;

/// Every way in which a command ends without its result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A field of the configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Input or usage that no other variant names.
    #[error("{0}")]
    BadInput(String),
    /// A file that the command line or another file names cannot be read.
    #[error("{}: cannot be read: {why}", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// Reason that the system gives.
        why: String,
    },
    /// A probe's line cannot be opened, read or written.
    #[error("{place}: cannot be {what}: {why}")]
    Port {
        /// The port, file or address.
        place: String,
        /// Action that failed, such as "opened".
        what: &'static str,
        /// Reason that the system gives.
        why: String,
    },
    /// The file with a probe's key cannot be read.
    #[error("{}: the key cannot be read: {why}", path.display())]
    Key {
        /// The file.
        path: PathBuf,
        /// Reason that the system gives.
        why: String,
    },
    /// Something that is needed is not there: an answer, a reader.
    #[error("{0}")]
    Missing(String),
    /// A result file cannot be written.
    #[error("{}: cannot be written: {why}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// Reason that the system gives.
        why: String,
    },
}

/// Why a file that is to be a text is none.
pub const NOT_UTF8: &str = "it is no text in UTF-8, but binary or in another encoding";

impl Failure {
    /// The failure to read `path`.
    #[must_use]
    pub fn unread(path: &Path, error: &std::io::Error) -> Self {
        let why = match error.kind() {
            // The system's words, "stream did not contain valid UTF-8", say not what mends it.
            std::io::ErrorKind::InvalidData => NOT_UTF8.to_owned(),
            _ => error.to_string(),
        };
        Self::Unread { path: path.to_owned(), why }
    }

    /// The failure to write `path`.
    #[must_use]
    pub fn output(path: &Path, error: &std::io::Error) -> Self {
        Self::Output { path: path.to_owned(), why: error.to_string() }
    }
}
