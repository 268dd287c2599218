//! Chi-square quantiles with three degrees of freedom, if no other number is named: how improbable a vector is under
//! its covariance.

/// Exceeded once in a million.
pub(crate) const IN_A_MILLION: f32 = 30.66;
/// Exceeded once in a thousand.
pub(crate) const IN_A_THOUSAND: f32 = 16.27;
/// Exceeded once in a hundred; three times in a row about once in a million.
pub(crate) const IN_A_HUNDRED: f32 = 11.34;
/// Exceeded once in twenty.
pub(crate) const IN_TWENTY: f32 = 7.815;
/// With two degrees of freedom exceeded once in a thousand.
pub(crate) const OF_TWO_IN_A_THOUSAND: f32 = 13.82;

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability beyond x: erfc(sqrt(x / 2)) + sqrt(2 x / pi) exp(-x / 2).
    fn tail(x: f32) -> f64 {
        let x = f64::from(x);
        libm::erfc(libm::sqrt(x / 2.0)) + libm::sqrt(2.0 * x / core::f64::consts::PI) * libm::exp(-x / 2.0)
    }

    #[test]
    fn quantiles_are_those_of_the_closed_form() {
        for (quantile, once_in) in [(IN_A_MILLION, 1e6), (IN_A_THOUSAND, 1e3), (IN_A_HUNDRED, 1e2), (IN_TWENTY, 20.0)] {
            assert!((tail(quantile) * once_in - 1.0).abs() < 0.01, "{quantile}: {}", tail(quantile));
        }
        assert!((libm::expf(-0.5 * OF_TWO_IN_A_THOUSAND) * 1e3 - 1.0).abs() < 0.01);
    }
}
