//! Desk side of `meerkat-mwd`: commands, traces, simulation, scores, reports, the emulated chip.

pub mod batch;
pub mod bench;
pub mod bus_faults;
pub mod calibrate;
pub mod commands;
pub mod console;
pub mod diagnosis;
pub mod earth;
pub mod failure;
pub mod fleet;
pub mod flight;
pub mod fuzzed;
pub mod import;
pub mod layout;
pub mod number;
pub mod port;
pub mod report;
pub mod research;
pub mod score;
pub mod second_simulator;
pub mod simulate;
pub mod surveys;
pub mod target;
pub mod trace;
pub mod whole_probe;
