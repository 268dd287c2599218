//! Measurements of what flies: each section of `mwd bench` is one module; the others are shared.

pub mod attitude;
pub(crate) mod attitude_cost;
pub(crate) mod benefit;
pub(crate) mod bus;
pub(crate) mod bus_faults;
pub(crate) mod closed_loop;
pub(crate) mod cost;
pub(crate) mod coverage;
pub mod cramer_rao;
pub(crate) mod drilling;
pub(crate) mod effects;
mod effort;
mod error_multiplied_in;
pub mod faults;
pub(crate) mod gyro_grade;
pub mod honesty;
pub(crate) mod hour;
mod kept;
pub mod mud_pulse;
pub mod multi_station;
pub mod one_window;
pub(crate) mod rate_error;
pub(crate) mod recordings;
pub mod rotation_error;
pub(crate) mod second_simulator;
pub mod seeds;
pub(crate) mod sensors;
pub mod size;
pub(crate) mod swaps;
mod table;
pub(crate) mod turntable;
pub(crate) mod whole_probe;

pub use effort::Effort;
pub use table::{Cell, Table, median, median_and_lowest, median_and_worst, rms};
