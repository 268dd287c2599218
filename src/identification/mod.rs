//! Identification: instants at which the estimator's results fly (`schedule`), the decision whether they do
//! (`flying`), and the population search of each window (`search`). The learning itself is in
//! [`estimator`](crate::estimator).

mod flying;
mod identifier;
mod report;
mod schedule;
mod search;

pub use crate::estimator::{Refusal, WindowCost};
pub(crate) use identifier::Identifier;
pub use report::{Decision, WindowReport};
pub use search::{RADIUS, Searched};
