//! A recording through the register-level models of the sensors and the adapters that fly with real ones, instead of handed over.

mod bound;
mod emulated;
mod play;
mod report;

pub use bound::{QuantisationBound, largest_difference_deg};
pub use emulated::{PlayedOnTheChip, SamplingCost, build, play_emulated};
pub use play::{Played, WARM_UP_US, WORDS, each_field_once, on_recorded_times, periods, play, truth};
pub use report::{Differences, differences, report};
