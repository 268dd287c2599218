//! Surveys of simulated tools with known truth.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

mod flown;
mod garbage;
mod interlock;
mod monte_carlo;
mod tool;
