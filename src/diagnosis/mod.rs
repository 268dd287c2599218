//! Account of the physical effects that the model lacks, from the estimator's evidence: effects found, the instant
//! since when each is taken out, rivals that the data cannot tell from it, and the remainder that nothing explains.
//! `findings` keeps this account from update to update; `report` is the part that a user gets.

mod report;
mod findings;

pub use crate::estimator::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub(crate) use findings::Findings;
#[cfg(feature = "storage")]
pub(crate) use findings::as_estimated;
pub use report::{DiagnosisReport, EffectReport, Verdict};
