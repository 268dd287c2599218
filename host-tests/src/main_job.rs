//! `mwd` alone: the main job, end to end on the bundled recording.

use crate::failure::Failure;

/// Plays the bundled recording and prints what came of it.
///
/// # Errors
/// Not built yet.
pub fn run() -> anyhow::Result<()> {
    Err(Failure::NotBuilt("the main job (mwd without a subcommand)").into())
}
