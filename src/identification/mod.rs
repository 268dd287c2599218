//! From windows of samples to an accepted gyro model, or a reasoned refusal.

mod report;

pub use report::{Decision, Refusal, WindowReport};
