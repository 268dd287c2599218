//! Normalised estimation error squared (NEES) of P: tells whether its stated covariance is right (Bar-Shalom,
//! Li, Kirubarajan 2001, Estimation with Applications to Tracking and Navigation, section 5.4).

use meerkat_mwd::{compensation::GyroModel, estimator::Posterior, identification::WindowReport};
use nalgebra::{SMatrix, SVector};

/// Number of P's elements.
const ELEMENTS: usize = 9;

/// A covariance of P's elements, row by row.
pub type Covariance = SMatrix<f64, ELEMENTS, ELEMENTS>;

/// Covariance of P that a window reports.
#[must_use]
pub fn covariance(report: &WindowReport) -> Covariance {
    Covariance::from_fn(|row, column| f64::from(report.covariance_of_p(row, column)))
}

/// Covariance of a posterior's P.
#[must_use]
pub fn covariance_of(posterior: &Posterior) -> Covariance {
    Covariance::from_fn(|row, column| {
        let (long, short) = (row.max(column), row.min(column));
        posterior.p_covariance.get(long * (long + 1) / 2 + short).copied().map_or(f64::NAN, f64::from)
    })
}

/// P of a model, row-major.
#[must_use]
pub fn p_of(model: &GyroModel) -> [f64; ELEMENTS] {
    let mut elements = model.p.as_flattened().iter();
    std::array::from_fn(|_| elements.next().copied().map_or(f64::NAN, f64::from))
}

/// Squared error of P in units of its covariance, divided by the number of elements: 1 on average if the
/// covariance is right. `None` if the covariance is not positive definite.
#[must_use]
pub fn normalised(fitted: &[f32], covariance: &Covariance, truth: &[f64; ELEMENTS]) -> Option<f64> {
    let error = fitted.iter().zip(truth).map(|(x, truth)| f64::from(*x) - truth);
    let error = SVector::<f64, ELEMENTS>::from_iterator(error.chain(std::iter::repeat(f64::NAN)));
    let squared = error.dot(&covariance.cholesky()?.solve(&error));
    squared.is_finite().then_some(squared / ELEMENTS as f64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

    #[test]
    fn independent_elements_give_the_mean_square_of_errors_in_sigmas() {
        let (mut fitted, mut covariance) = (IDENTITY.map(|x| x as f32), Covariance::zeros());
        for (element, fitted) in fitted.iter_mut().enumerate() {
            let sigma = 0.001 * (element + 1) as f32;
            covariance[(element, element)] = f64::from(sigma * sigma);
            // Three sigmas of the third element, two of all others.
            *fitted += if element == 2 { 3.0 } else { -2.0 } * sigma;
        }
        let found = normalised(&fitted, &covariance, &IDENTITY).unwrap();
        assert!((found - (8.0 * 4.0 + 9.0) / 9.0).abs() < 1e-3, "{found}");
        assert_eq!(normalised(&fitted, &covariance, &fitted.map(f64::from)), Some(0.0));
    }

    /// Unit variances, correlation r: unit errors count 2 / (1 + r) together, 2 / (1 - r) against each other.
    #[test]
    fn a_correlation_counts_between_the_two_elements_that_it_names() {
        let mut covariance = Covariance::identity();
        // Correlation of two elements on the middle column of P.
        (covariance[(7, 4)], covariance[(4, 7)]) = (0.5, 0.5);
        let with = |first: f32, second: f32| {
            let fitted = [0.0, 0.0, 0.0, 0.0, first, 0.0, 0.0, second, 0.0];
            9.0 * normalised(&fitted, &covariance, &[0.0; 9]).unwrap()
        };
        assert!((with(1.0, 1.0) - 4.0 / 3.0).abs() < 1e-12);
        assert!((with(1.0, -1.0) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_covariance_that_is_none_and_a_matrix_that_is_none_have_no_nees() {
        let with = |variance: f64| {
            let mut covariance = Covariance::identity();
            covariance[(2, 2)] = variance;
            normalised(&[0.0; 9], &covariance, &[0.0; 9])
        };
        assert_eq!(with(1.0), Some(0.0));
        assert_eq!([0.0, -1.0, f64::NAN].map(with), [None; 3]);
        assert_eq!(normalised(&[0.0; 8], &Covariance::identity(), &[0.0; 9]), None);
    }
}
