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
