//! Attacks: mutated bytes for all that comes from outside, and the whole probe under seeded faults.

pub mod fuzzed;
pub mod whole_probe;
