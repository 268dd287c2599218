//! Measurements of what flies: each section of `mwd bench` is one module; the others are shared.

pub mod attitude;
pub(crate) mod attitude_cost;
pub(crate) mod benefit;
pub(crate) mod bus;
pub(crate) mod bus_faults;
pub(crate) mod closed_loop;
pub(crate) mod cost;
pub(crate) mod coverage;
pub(crate) mod drilling;
pub(crate) mod effects;
mod error_multiplied_in;
pub mod faults;
pub mod honesty;
pub(crate) mod hour;
mod kept;
pub mod mud_pulse;
pub mod multi_station;
pub(crate) mod rate_error;
pub(crate) mod recordings;
pub(crate) mod replay;
pub mod rotation_error;
pub(crate) mod second_simulator;
pub(crate) mod sensors;
pub mod size;
pub(crate) mod swaps;
pub(crate) mod turntable;
pub(crate) mod whole_probe;
