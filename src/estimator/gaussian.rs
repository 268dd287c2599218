//! Gaussian of a few variables as mean and packed covariance, of which the last variables can be marginalised.

use super::{
    real::Real,
    unrolled::{add_times, add_two_times},
};

/// Elements of the lower triangle of `n` variables.
pub(super) const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Element (i, j <= i) of a packed triangle; 0 beyond it.
pub(super) fn element<T: Real>(covariance: &[T], i: usize, j: usize) -> T {
    covariance.get(triangle(i) + j).copied().unwrap_or(T::ZERO)
}

/// Replaces the prior of the last variable, which is N(0, 1) inside the Gaussian, by N(0, width^2), and marginalises
/// the variable: the others are left. Returns the logarithm of the evidence of the new width over that of 1. A width of
/// 1 changes nothing.
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

/// Marginalises the last variable and then the one before it, with their widths in that order, as [`narrow_last`] does:
/// in one pass over the covariance of the others. Returns both log evidences.
pub(super) fn narrow_two<T: Real>(mean: &mut [T], covariance: &mut [T], widths: [T; 2]) -> [T; 2] {
    let both = widths.map(|width| width * width);
    let [m @ .., of_second, of_first] = mean else { return [T::ZERO; 2] };
    let n = m.len();
    if both.iter().any(|squared| *squared >= T::ONE) {
        let first = narrow_last(mean, covariance, widths[0]);
        let (Some(mean), Some(rest)) = (mean.get_mut(..=n), covariance.get_mut(..triangle(n + 1))) else {
            return [first, T::ZERO];
        };
        return [first, narrow_last(mean, rest, widths[1])];
    }
    let noises = both.map(|squared| squared / (T::ONE - squared));
    let Some((before, rest)) = covariance.split_at_mut_checked(triangle(n)) else { return [T::ZERO; 2] };
    let Some((second, rest)) = rest.split_at_mut_checked(n + 1) else { return [T::ZERO; 2] };
    let Some(([first @ .., cross], variance)) = rest.get(..n + 2).and_then(<[T]>::split_last).map(|(v, r)| (r, v))
    else {
        return [T::ZERO; 2];
    };
    let innovation = *variance + noises[0];
    let gain = *cross / innovation;
    *of_second -= gain * *of_first;
    let [own @ .., left] = second else { return [T::ZERO; 2] };
    add_times(own, -gain, first);
    *left += -gain * *cross;
    let after = *left + noises[1];
    let own = &*own;
    let mut lower = before;
    for (i, ((other, a), b)) in m.iter_mut().zip(first).zip(own).enumerate() {
        let gains = [*a / innovation, *b / after];
        *other = *other - gains[0] * *of_first - gains[1] * *of_second;
        let Some((elements, next)) = core::mem::take(&mut lower).split_at_mut_checked(i + 1) else { break };
        add_two_times(elements, gains.map(|gain| -gain), [first, own]);
        lower = next;
    }
    let half = T::of(0.5);
    let evidence = |innovation: T, noise: T, mean: T| {
        -half * (innovation / (T::ONE + noise)).logarithm() - half * mean * mean / innovation
    };
    [evidence(innovation, noises[0], *of_first), evidence(after, noises[1], *of_second)]
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

    #[test]
    fn two_at_once_are_one_after_the_other_to_the_bit() {
        use rand_core::{Rng, SeedableRng};
        let mut generator = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(7);
        let mut uniform = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
        for n in 2..12_usize {
            for widths in [[0.3, 0.3], [1.0, 0.1], [0.2, 1.0]] {
                let mut mean = [0.0_f32; 12];
                let mut covariance = [0.0_f32; triangle(12)];
                mean.iter_mut().for_each(|x| *x = uniform());
                for i in 0..n {
                    for j in 0..=i {
                        covariance[triangle(i) + j] = 0.1 * uniform() + if i == j { 0.6 } else { 0.0 };
                    }
                }
                let (mut other_mean, mut other) = (mean, covariance);
                let both = narrow_two(&mut mean[..n], &mut covariance[..triangle(n)], widths);
                let first = narrow_last(&mut other_mean[..n], &mut other[..triangle(n)], widths[0]);
                let second = narrow_last(&mut other_mean[..n - 1], &mut other[..triangle(n - 1)], widths[1]);
                assert_eq!(both, [first, second]);
                assert_eq!(mean[..n - 2], other_mean[..n - 2]);
                assert_eq!(covariance[..triangle(n - 2)], other[..triangle(n - 2)]);
            }
        }
    }
}
