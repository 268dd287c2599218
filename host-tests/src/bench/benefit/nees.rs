//! Normalised estimation error squared (NEES) of P: whether its stated covariance holds (Bar-Shalom, Li,
//! Kirubarajan 2001, Estimation with Applications to Tracking and Navigation, section 5.4).

use meerkat_mwd::compensation::GyroModel;
use nalgebra::{SMatrix, SVector};

use crate::flight::Flight;

/// Elements of P.
const ELEMENTS: usize = 9;

/// A covariance of P: its lower triangle, row by row, over P's elements, themselves row by row.
type Packed = [f32; ELEMENTS * (ELEMENTS + 1) / 2];

/// NEES / 9 of the last window that has a result; 1 on the mean where the covariance is right. `truth` is the error
/// multiplied in: the recording's own P is taken as the identity, so its error counts as one of the estimate.
pub(super) fn nees(flight: &Flight, truth: &GyroModel) -> Option<f64> {
    let fitted = flight.reports.iter().rev().find(|report| report.t_effect_us.is_some())?;
    let mut covariance = [0.0; ELEMENTS * (ELEMENTS + 1) / 2];
    covariance.iter_mut().zip(fitted.p_covariance.as_flattened()).for_each(|(to, from)| *to = *from);
    normalised(&fitted.fitted.p, &covariance, &truth.p)
}

/// Squared error of P in units of its covariance, over the number of elements; `None` where the covariance is not
/// positive definite.
fn normalised(fitted: &[[f32; 3]; 3], covariance: &Packed, truth: &[[f32; 3]; 3]) -> Option<f64> {
    let error = fitted.iter().flatten().zip(truth.iter().flatten()).map(|(x, t)| f64::from(*x) - f64::from(*t));
    let error = SVector::<f64, ELEMENTS>::from_iterator(error);
    let covariance = SMatrix::<f64, ELEMENTS, ELEMENTS>::from_fn(|row, column| {
        let (long, short) = (row.max(column), row.min(column));
        covariance.get(long * (long + 1) / 2 + short).copied().map_or(f64::NAN, f64::from)
    });
    let squared = error.dot(&covariance.cholesky()?.solve(&error));
    squared.is_finite().then_some(squared / ELEMENTS as f64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Position of a variance in the packed triangle.
    fn diagonal(element: usize) -> usize {
        element * (element + 3) / 2
    }

    fn unit() -> Packed {
        let mut packed = [0.0; 45];
        (0..9).for_each(|element| packed[diagonal(element)] = 1.0);
        packed
    }

    #[test]
    fn independent_elements_give_the_mean_square_of_errors_in_sigmas() {
        let (mut fitted, mut covariance) = (GyroModel::IDENTITY.p, [0.0; 45]);
        for element in 0..9 {
            let sigma = 0.001 * (element + 1) as f32;
            covariance[diagonal(element)] = sigma * sigma;
            // Three sigmas of the third element, two of all others.
            fitted[element / 3][element % 3] += if element == 2 { 3.0 } else { -2.0 } * sigma;
        }
        let found = normalised(&fitted, &covariance, &GyroModel::IDENTITY.p).unwrap();
        assert!((found - (8.0 * 4.0 + 9.0) / 9.0).abs() < 1e-3, "{found}");
        assert_eq!(normalised(&fitted, &covariance, &fitted), Some(0.0));
    }

    /// Unit variances, correlation r: unit errors count 2 / (1 + r) together, 2 / (1 - r) against each other.
    #[test]
    fn a_correlation_counts_between_the_two_elements_that_it_names() {
        let mut covariance = unit();
        // Of the elements 4 and 7: both on the middle column of P.
        covariance[7 * 8 / 2 + 4] = 0.5;
        let with = |first: f32, second: f32| {
            let mut fitted = [[0.0; 3]; 3];
            (fitted[1][1], fitted[2][1]) = (first, second);
            9.0 * normalised(&fitted, &covariance, &[[0.0; 3]; 3]).unwrap()
        };
        assert!((with(1.0, 1.0) - 4.0 / 3.0).abs() < 1e-12);
        assert!((with(1.0, -1.0) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_covariance_that_is_none_has_no_nees() {
        let p = GyroModel::IDENTITY.p;
        let with = |variance: f32| {
            let mut covariance = unit();
            covariance[diagonal(3)] = variance;
            normalised(&p, &covariance, &p)
        };
        assert_eq!(with(1.0), Some(0.0));
        assert_eq!([0.0, -1.0, f32::NAN].map(with), [None; 3]);
    }
}
