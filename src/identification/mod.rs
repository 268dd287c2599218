//! From windows of samples to an accepted gyro model, or a reasoned refusal.

mod acceptance;
mod carried;
mod contest;
mod diagnosis_schedule;
mod drift;
mod graduation;
mod identifier;
mod innovation_fit;
mod job;
mod judgement;
mod least_squares;
mod motion;
mod observability;
mod prior;
mod refinement;
mod report;
mod rest_evidence;
mod robust_weights;
mod search;
mod weak_fit;
mod window_cost;
mod window_fit;
mod work;

pub(crate) use acceptance::LEAST_EXPLAINED;
pub(crate) use carried::{Carried, Forgetting};
pub(crate) use identifier::Identifier;
pub(crate) use prior::Prior;
pub use report::{Decision, Refusal, WindowReport};
pub use window_cost::{WhitenedCost, WindowCost};

/// Not inlined: a conversion to 64 bits is a loop's worth of code.
#[inline(never)]
fn micros(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}
