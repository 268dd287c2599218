//! Which physical effect the model lacks: candidates are tried on the residual of a window, by a weak form of the vectors' kinematics,
//! and those that show beyond chance are taken out of the readings from then on.
//!
//! A window's increments are walked through several times. Each pass sums the normal equations of the gyro's 12 parameters and of all
//! candidates at once, and the candidates' scores group by group at the solution so far; a candidate's significance is that of a
//! sign-flip score test (Hemerik, Goeman and Finos, Journal of the Royal Statistical Society B 82 (2020) 841), which holds whatever
//! the noise of a group is.
//!
//! A magnet that comes and goes is watched for apart, at every fifth of a second.

mod bias_step;
mod passes;
mod history;
mod magnet;
mod normal;
mod remainder;
mod report;
mod schedule;
mod sign_flip;
mod stream;
mod turned_axes;
mod walk;
mod weak_columns;
mod whitening;

pub(crate) use magnet::{FieldUse, HardIronWatch};
pub use magnet::{HardIronCounts, HardIronInterval};
pub use remainder::{Correlate, GoesWith, MOST_NAMED, Memory, RemainderReport};
pub use report::{BiasStepReport, DiagnosisReport, EffectReport, Tried, Verdict};
pub(crate) use schedule::{Change, DiagnosisSchedule};

use history::History;
use passes::{Diagnosis, DiagnosisJob, Subject};
use turned_axes::candidates;
