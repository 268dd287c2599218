//! Records that the emulated board writes through semihosting: one [`Record`] after another, self-delimiting in
//! postcard's encoding.

use crate::{
    diagnosis::DiagnosisReport,
    identification::WindowReport,
    magnet::HardIronInterval,
    probe::{Counters, Output},
};
use serde::{Deserialize, Serialize};

/// Record of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "nothing here can be boxed, and a record lives only until it is encoded")]
#[non_exhaustive]
pub enum Record {
    /// Output of one sample.
    Output(Output),
    /// Result of one window, right after the output of the sample at which it was reported.
    Window {
        /// The report.
        report: WindowReport,
        /// Instructions spent in `Probe::poll` since the previous report, or since the start.
        poll_instructions: u64,
    },
    /// Findings of one diagnosis, right after the output of the sample at which they took effect.
    Diagnosis(DiagnosisReport),
    /// Magnet that came while the probe ran; written at the end of the run.
    HardIron(HardIronInterval),
    /// End of the trace; the last record.
    End(Summary),
}

/// Cost and counters of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Summary {
    /// The pipeline's own counters.
    pub counters: Counters,
    /// `Probe::push`, once a sample.
    pub push: Cost,
    /// `Probe::poll`, once a sample.
    pub poll: Cost,
    /// Instruction counter against its clock: timer ticks in 1,000 instructions.
    pub ticks_per_1000_instructions: u32,
    /// Most stack in use at any time, bytes, with the interrupt's frame.
    pub stack_used_bytes: u32,
    /// Size of the stack, from the end of the static data to the top of RAM, bytes.
    pub stack_size_bytes: u32,
}

/// Instructions executed in one function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Cost {
    /// Calls.
    pub calls: u64,
    /// Instructions in all calls.
    pub instructions: u64,
    /// Instructions in the most expensive call.
    pub instructions_max: u64,
}

impl Cost {
    /// Mean of instructions per call, rounded down; 0 when there was no call.
    #[must_use]
    pub const fn instructions_mean(&self) -> u64 {
        match self.instructions.checked_div(self.calls) {
            Some(mean) => mean,
            None => 0,
        }
    }
}
