//! `mwd simulate`: a scenario in, a trace out.

use crate::{cli::SimulateArgs, failure::Failure};

/// Writes the trace of a scenario.
///
/// # Errors
/// Not built yet.
pub fn run(_args: &SimulateArgs) -> anyhow::Result<()> {
    Err(Failure::NotBuilt("simulate").into())
}
