//! The firmware's own program on a board of this machine: single troubles, each at its worst. All of them at once, by
//! chance: `tests/whole_probe.rs`.
#![allow(clippy::unwrap_used)]

mod desk_board;
mod magnet;
#[path = "../../src/power_cuts/drawn.rs"]
#[allow(dead_code)]
mod models;
mod overload;
mod owner;
mod requests;
mod self_test;
mod start;
mod stm32f405_flash;
mod time_stamps;
