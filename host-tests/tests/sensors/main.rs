//! Sensors on the bus: bytes on the wires, and handling of a part that misbehaves.
#![allow(missing_docs, clippy::panic, clippy::unwrap_used)]

mod clock;
mod combiner;
mod fake_part;
mod guide;
mod mounting;
mod mounting_check;
mod pair;
mod supervision;
mod wire;
