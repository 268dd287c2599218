//! Why the program stops before it is done, and the exit status that says so.

use std::path::{Path, PathBuf};

use meerkat_mwd::config::ConfigError;

use crate::{emulate::EmulateError, simulate::ScenarioError, toolchain::Missing, trace::TraceError};

/// Every way in which a command ends without its result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The trace cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
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

    /// Exit status: 2, bad input or usage; 3, something is missing.
    #[must_use]
    pub const fn exit_status(&self) -> u8 {
        match self {
            Self::Missing(_) => Missing::EXIT_STATUS,
            Self::Trace(_) | Self::Config(_) | Self::BadInput(_) | Self::Output { .. } => 2,
        }
    }
}

/// The exit status of an error: that of the failure in its chain, else 1, a defect.
#[must_use]
pub fn exit_status(error: &anyhow::Error) -> u8 {
    error
        .chain()
        .find_map(|cause| {
            let failure = cause.downcast_ref::<Failure>().map(Failure::exit_status);
            let emulator = cause.downcast_ref::<EmulateError>().map(EmulateError::exit_status);
            let input = cause.is::<TraceError>() || cause.is::<ConfigError>() || cause.is::<ScenarioError>();
            failure.or(emulator).or(input.then_some(2))
        })
        .unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use anyhow::Context;
    use meerkat_mwd::Config;

    use super::*;

    #[test]
    fn the_status_is_found_under_added_context_and_anything_else_is_a_defect() {
        let missing = EmulateError::from(Missing { what: "no emulator".into(), command: "install it".into() });
        let wrapped = Err::<(), _>(missing).context("while emulating").map_err(|e| exit_status(&e));
        assert_eq!(wrapped, Err(3));
        let unusable = Config { sample_period_us: 0, ..Config::default() };
        assert_eq!(unusable.validate().map_err(|e| exit_status(&e.into())), Err(2));
        assert_eq!(exit_status(&anyhow::anyhow!("no variant")), 1);
    }
}
