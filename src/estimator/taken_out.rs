//! Readings' share of the effects that are taken out.

use super::real::{Real, V3, zero3};

/// Additions of the effects that are taken out to the readings of an increment: rate (rad/s), specific force (m/s^2),
/// field.
#[derive(Clone, Copy)]
pub struct TakenOut<T> {
    pub rate: V3<T>,
    pub force: V3<T>,
    pub field: V3<T>,
}

impl<T: Real> TakenOut<T> {
    /// No additions.
    pub fn nothing() -> Self {
        Self { rate: zero3(), force: zero3(), field: zero3() }
    }
}
