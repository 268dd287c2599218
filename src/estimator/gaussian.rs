//! A Gaussian of a few variables as mean and packed covariance, from which the last variable is taken out at a time.

use super::{real::Real, unrolled::add_times};

/// Elements of the lower triangle of `n` variables.
pub(super) const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Element (i, j <= i) of a packed triangle; 0 beyond it.
pub(super) fn element<T: Real>(covariance: &[T], i: usize, j: usize) -> T {
    covariance.get(triangle(i) + j).copied().unwrap_or(T::ZERO)
}

/// Makes the prior of the last variable, which is N(0, 1) inside the Gaussian, N(0, width^2), and takes the variable
/// out: what is left are the others. Returns the logarithm of the evidence of the new width over that of 1. A width
/// of 1 changes nothing.
///
/// N(0, width^2) is N(0, 1) times a reading of 0 with variance r = width^2 / (1 - width^2): one scalar Kalman update;
/// the evidence is the reading's likelihood over the one that it has before any data.
pub(super) fn narrow_last<T: Real>(mean: &mut [T], covariance: &mut [T], width: T) -> T {
    let Some((last, others)) = mean.split_last_mut() else { return T::ZERO };
    let n = others.len();
    let Some((before, rest)) = covariance.split_at_mut_checked(triangle(n)) else { return T::ZERO };
    let squared = width * width;
    if squared >= T::ONE {
        return T::ZERO;
    }
    let noise = squared / (T::ONE - squared);
    let Some((variance, row)) = rest.get(..=n).and_then(<[T]>::split_last) else { return T::ZERO };
    let innovation = *variance + noise;
    let mut lower = before;
    for (i, (other, own)) in others.iter_mut().zip(row).enumerate() {
        let gain = *own / innovation;
        *other -= gain * *last;
        let Some((elements, next)) = core::mem::take(&mut lower).split_at_mut_checked(i + 1) else { break };
        add_times(elements, -gain, row);
        lower = next;
    }
    let half = T::of(0.5);
    -half * (innovation / (T::ONE + noise)).logarithm() - half * *last * *last / innovation
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;

    #[test]
    fn a_narrower_prior_gives_the_posterior_and_the_evidence_of_a_fit_with_it() {
        // y = x + z + noise of variance 0.1, y = 1.3; x ~ N(0, 1), z ~ N(0, 1), then z ~ N(0, 0.2^2).
        let fit = |variance: f64| {
            let s = 1.0 + variance + 0.1;
            (1.3 / s, 1.0 - 1.0 / s, -0.5 * s.ln() - 0.5 * 1.3 * 1.3 / s)
        };
        let s = 2.1;
        let mut mean = [1.3 / s, 1.3 / s];
        let mut covariance = [1.0 - 1.0 / s, -1.0 / s, 1.0 - 1.0 / s];
        let evidence = narrow_last(&mut mean, &mut covariance, 0.2);
        let (expected, before) = (fit(0.04), fit(1.0));
        assert!((mean[0] - expected.0).abs() < 1e-7 && (covariance[0] - expected.1).abs() < 1e-7);
        assert!((evidence - (expected.2 - before.2)).abs() < 1e-7);
    }
}
