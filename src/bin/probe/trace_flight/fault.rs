//! Why a run ended early.

use crate::console::{Word::Text, complain};
use meerkat_mwd::config::ConfigError;

/// Why a run ended early; its text goes to the emulator's standard error and the exit status is 1.
pub enum Fault {
    TraceMissing,
    TraceUnreadable,
    TraceMalformed,
    Config(ConfigError),
    FlightNotWritten,
    RecordTooLarge,
    InstructionCounter,
    StackOverflow,
}

impl Fault {
    pub fn complain(&self) {
        let text = match self {
            Self::TraceMissing => "trace.bin cannot be opened",
            Self::TraceUnreadable => "trace.bin cannot be read",
            Self::TraceMalformed => "trace.bin does not hold a configuration and whole samples",
            Self::Config(ConfigError { field, must_be, .. }) => {
                return complain(&[Text("configuration: "), Text(field), Text(" must be "), Text(must_be)]);
            }
            Self::FlightNotWritten => "flight.bin cannot be written",
            Self::RecordTooLarge => "a record is larger than the output buffer",
            Self::InstructionCounter => {
                "the instruction counter does not count evenly; is the emulator run with -icount?"
            }
            Self::StackOverflow => "the stack has run into the static data",
        };
        complain(&[Text(text)]);
    }
}
