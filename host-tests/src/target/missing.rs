//! A tool that is needed and missing.

/// A tool that is missing and could not be installed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\nInstall it with: {command}")]
pub struct Missing {
    /// Description of what is missing, and why it could not be installed.
    pub what: String,
    /// The command that installs it.
    pub command: String,
}

impl Missing {
    /// Error about what is missing, and how to get it.
    pub fn new(what: impl Into<String>, command: impl Into<String>) -> Self {
        Self { what: what.into(), command: command.into() }
    }
}
