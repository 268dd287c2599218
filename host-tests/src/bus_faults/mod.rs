//! Two seconds of the sensors' register-level models with one fault, and what the adapters made of it.

mod judgement;
pub mod kinds;
mod motion;
mod run;

pub use judgement::{Judgement, Sensor, judge};
pub use kinds::{Case, Fault, Kind};
pub use motion::Motion;
pub use run::{Run, run};
