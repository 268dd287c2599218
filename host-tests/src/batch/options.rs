//! Options with which all recordings of a batch are flown.

use std::path::PathBuf;

use meerkat_mwd::Config;

/// Options with which all recordings of a batch are flown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Configuration over the traces' headers.
    pub config: Option<PathBuf>,
    /// Share of each trace that is held out.
    pub hold_out: Option<f64>,
    /// Seed of the searches.
    pub seed: Option<u64>,
    /// Identify the twelve parameters only.
    pub no_effects: bool,
    /// Fly recordings whose units, signs or axes cannot be.
    pub force: bool,
    /// Folder for the attitudes.
    pub attitude_dir: Option<PathBuf>,
    /// Folder for the reports.
    pub html_dir: Option<PathBuf>,
}

impl Options {
    /// All that a result depends on but the configuration's bytes.
    pub(super) fn told(&self) -> String {
        format!("{:?} {:?} {} {}", self.hold_out, self.seed, self.no_effects, self.force)
    }

    /// Sets the fields that the options name.
    pub(super) fn set(&self, config: &mut Config) {
        if let Some(seed) = self.seed {
            config.seed = seed;
        }
        if self.no_effects {
            config.effects = false;
        }
    }
}
