//! Runs of two seconds of the sensors' register models with one fault, and what the adapters made of it.

mod attitude;
mod judgement;
pub mod kinds;
mod motion;
mod run;
mod sweep;

pub use judgement::{Judgement, Sensor, judge};
pub use kinds::{Case, Fault, Kind};
pub use motion::Motion;
pub use run::{Bus, Run, run};
pub use sweep::{Outcome, RUN_US, STRIKES_UNTIL_US, sweep};
