//! Which physical effects the model lacks, said from the estimator's evidence: what was found, since when it is taken out, what it may be instead,
//! and what is left that nothing explains.

mod report;
mod findings;

pub use crate::estimator::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub(crate) use findings::Findings;
pub use report::{DiagnosisReport, EffectReport, Verdict};
