//! Functions on a Gaussian, given as mean and packed covariance: they narrow the prior of its last variables, and
//! marginalise them.

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
mod tests;
