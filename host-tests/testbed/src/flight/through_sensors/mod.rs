//! A recording played through register models of the sensors and the adapters that fly with real ones.

mod bound;
mod cost;
mod play;
mod report;

pub use bound::{Difference, QuantisationBound};
pub use cost::SamplingCost;
pub use play::{Played, WORDS, each_field_once, play, recording, truth};
pub use report::{Differences, differences, report};
