//! Scenarios and recordings of the repository, by their names without the ending.

use std::path::{Path, PathBuf};
use testbed::{
    simulate::Scenario,
    trace::{Trace, recordings},
};

/// A real recording: fast rotation by hand, 110 s.
pub const FAST_ROTATION: &str = "broad_06_fast_rotation_110s";

/// A real recording with a magnet attached to the probe, 63 s.
pub const ATTACHED_MAGNET: &str = "broad_35_attached_magnet_63s";

pub fn scenario_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).with_extension("toml")
}

pub fn scenario(name: &str) -> Scenario {
    Scenario::read(&scenario_path(name)).unwrap()
}

pub fn recording_path(name: &str) -> PathBuf {
    recordings::folder().join(name).with_extension("csv.gz")
}

pub fn recording(name: &str) -> Trace {
    Trace::read(&recording_path(name)).unwrap()
}
