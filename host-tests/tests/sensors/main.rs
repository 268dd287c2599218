//! Sensors on the bus: what goes over the wires, and what becomes of a part that misbehaves.
#![allow(missing_docs, clippy::panic, clippy::unwrap_used)]

mod clock;
mod combiner;
mod fake_part;
mod guide;
mod mounting;
mod supervision;
mod wire;
