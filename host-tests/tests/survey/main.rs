//! Surveys of simulated tools with known truth.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

mod garbage;
mod monte_carlo;
mod tool;
