//! Why a run ended early.

use core::fmt;
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

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::TraceMissing => "trace.bin cannot be opened",
            Self::TraceUnreadable => "trace.bin cannot be read",
            Self::TraceMalformed => "trace.bin does not hold a configuration and whole samples",
            Self::Config(error) => return error.fmt(f),
            Self::FlightNotWritten => "flight.bin cannot be written",
            Self::RecordTooLarge => "a record is larger than the output buffer",
            Self::InstructionCounter => {
                "the instruction counter does not count evenly; is the emulator run with -icount?"
            }
            Self::StackOverflow => "the stack has run into the static data",
        };
        f.write_str(text)
    }
}
