//! `mwd emulate`: the flight by the firmware on the emulated Cortex-M4F.

use crate::{cli::ReplayArgs, failure::Failure};

/// Flies the trace on the emulated chip and delivers what `replay` delivers.
///
/// # Errors
/// Not built yet.
pub fn run(_args: &ReplayArgs) -> anyhow::Result<()> {
    Err(Failure::NotBuilt("emulate").into())
}
