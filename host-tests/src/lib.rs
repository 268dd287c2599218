//! The `mwd` program: its commands, reports and benches, imports, surveys, the line of a probe, and the emulated chip.

pub mod batch;
pub mod bench;
pub mod bus_faults;
pub mod calibrate;
pub mod commands;
pub mod diagnosis;
pub mod earth;
pub mod fleet;
pub mod import;
pub mod layout;
pub mod number;
pub mod port;
pub mod power_cuts;
pub mod report;
pub mod second_simulator;
pub mod surveys;
pub mod target;
