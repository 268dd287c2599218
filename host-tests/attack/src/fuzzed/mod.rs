//! Everything that parses what comes from outside, each with what has to hold of any bytes at all: for a
//! fuzzer, and for a test that mutates a small corpus.
//!
//! Flights, exchanges with the command gate and configurations are built from the bytes by `arbitrary`, so that a
//! mutation changes one event or one field and the rest still means something. The other targets take the bytes
//! as they are: a frame, a payload, a flash, a FIFO and a text are themselves what comes from outside.

mod command_gate;
mod configuration;
mod flat_flash;
mod line;
mod samples;
mod sensors;
mod stored_records;
mod trace;

pub use command_gate::{KEY, PROBE, command_gate};
pub use configuration::{configuration, places};
pub use line::{frame, message};
pub use samples::{flights, samples};
pub use sensors::{ism330dhcx, rm3100};
pub use stored_records::stored_records;
pub use trace::trace;

/// Function under test, which takes any bytes.
pub type Target = fn(&[u8]);

/// All, by name.
pub const TARGETS: [(&str, Target); 10] = [
    ("frame", frame),
    ("message", message),
    ("command_gate", command_gate),
    ("stored_records", stored_records),
    ("ism330dhcx", ism330dhcx),
    ("rm3100", rm3100),
    ("samples", samples),
    ("flights", flights),
    ("configuration", configuration),
    ("trace", trace),
];
