//! From windows of samples to an accepted gyro model, or a reasoned refusal.

mod acceptance;
mod contest;
mod identifier;
mod judgement;
mod least_squares;
mod observability;
mod prior;
mod report;
mod search;
mod whitening;
mod window_fit;

pub(crate) use identifier::Identifier;
pub(crate) use prior::Prior;
pub use report::{Decision, Refusal, WindowReport};
