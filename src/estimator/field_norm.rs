//! The mean norm of the field, as the present calibration makes it of all that was read: a node that differs from it is disturbed.
//!
//! The paper's eq 8 refuses what errs by more than half; here what the norm errs by widens the field's noise.

use super::{
    parameters::Parameters,
    preintegration::Preintegration,
    real::{M3, Real, V3, square, zero3, zero33},
};

/// Nodes over which it is averaged: five minutes.
const NODES: u16 = 600;

/// Means of the readings and of their products, with which the norm can be had for any magnetometer matrix and hard iron. A mean of norms
/// would be one of the calibrations of the past.
#[derive(Clone, Copy)]
pub(super) struct FieldNorm<T> {
    mean: V3<T>,
    product: M3<T>,
    /// Mean of the norms as they were calibrated at their time.
    pub of_their_time: T,
    count: u16,
}

impl<T: Real> FieldNorm<T> {
    pub const fn zero() -> Self {
        Self { mean: zero3(), product: zero33(), of_their_time: T::ZERO, count: 0 }
    }

    /// Adds a node; `share`: one over its increments with a field.
    pub fn add(&mut self, pre: &Preintegration<T>, share: T) {
        self.count = if self.count < NODES { self.count + 1 } else { NODES };
        let weight = T::ONE / T::of(f32::from(self.count));
        self.of_their_time += (pre.field_norms * share - self.of_their_time) * weight;
        self.mean += (pre.fields_read * share - self.mean) * weight;
        self.product += (pre.field_squares_read * share - self.product) * weight;
    }

    /// Root mean square of |M h + i| over all readings h.
    pub fn at(&self, with: &Parameters<T>) -> T {
        let turned = with.mag_matrix * self.product * with.mag_matrix.transpose();
        let mean = with.mag_matrix * self.mean;
        let both = turned.trace() + (mean.dot(&with.hard_iron)) * T::of(2.0) + square(&with.hard_iron);
        both.root()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{
        columns::{GLOBALS, HARD_IRON, MAG_MATRIX},
        real::identity,
    };

    #[test]
    fn the_norm_is_that_of_the_readings_calibrated_now() {
        let mut norms = FieldNorm::<f64>::zero();
        let fields = [V3::new(0.9, 0.1, -0.3), V3::new(-0.2, 0.8, 0.5), V3::new(0.1, -0.7, 0.7)];
        for field in &fields {
            let mut pre = Preintegration::zero();
            pre.fields_read = field * 4.0;
            pre.field_squares_read = field * field.transpose() * 4.0;
            norms.add(&pre, 0.25);
        }
        let mut x = [0.0; GLOBALS];
        (x[HARD_IRON.from + 1], x[MAG_MATRIX.from], x[MAG_MATRIX.from + 4]) = (0.3, 0.1, -0.05);
        let with = Parameters::new(&x, &zero3(), &identity());
        let calibrated = fields.map(|field| square(&(with.mag_matrix * field + with.hard_iron)));
        assert!((norms.at(&with) - (calibrated.iter().sum::<f64>() / 3.0).sqrt()).abs() < 1e-12);
    }
}
