//! The attitude filter through its public interface, against a known motion.
#![allow(missing_docs, clippy::unwrap_used)]

mod accuracy;
mod faults;
mod simulation;
