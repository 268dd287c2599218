//! Findings of a flight's diagnoses: effects by name, and the vectors' residual before and after.

mod against_reference;
mod outcome;
mod totals;
mod vector_residual;

pub use against_reference::{against_reference, has_dense_reference};
pub(crate) use against_reference::{attitudes, vectors_from};
pub use outcome::{Diagnosed, Found, HARD_IRON, aliases, diagnosed, rival_of_other_sensor, rivals, why_left_in};
pub use totals::Totals;
pub use vector_residual::{BeforeAfter, ResidualOverTime, VectorResidual, WithoutEffect};
