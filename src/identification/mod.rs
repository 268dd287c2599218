//! When what the estimator has learnt flies, and what the population search adds to it window by window.

mod flying;
mod identifier;
mod report;
mod schedule;
mod search;

pub use crate::estimator::{Refusal, WindowCost};
pub(crate) use identifier::Identifier;
pub use report::{Decision, WindowReport};
pub use search::{RADIUS, Searched};
