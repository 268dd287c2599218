//! Random deviates of the searches, from a seeded generator.

use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Uniform deviate in [0, 1), 24 bits.
// Not inlined, like `normal`.
#[inline(never)]
pub(crate) fn uniform(generator: &mut Xoshiro128PlusPlus) -> f32 {
    (generator.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Nearly standard normal deviate: the sum of eight uniforms of 16 bits (Irwin-Hall), standardised. Tails end
/// at 4.9 sigma and the excess kurtosis is -0.15; a logarithm and a cosine would cost ten times as much on
/// the chip.
// Not inlined: loops over the variables are unrolled, and the chip's flash is small.
#[inline(never)]
pub(crate) fn normal(generator: &mut Xoshiro128PlusPlus) -> f32 {
    let mut sum = 0;
    for _ in 0..4 {
        let bits = generator.next_u32();
        sum += (bits & 0xffff) + (bits >> 16);
    }
    // Eight uniforms have mean 4 and variance 8/12.
    (sum as f32 * (1.0 / 65_536.0) - (4.0 - 4.0 / 65_536.0)) * 1.224_744_9
}

/// Cosine of 2 pi a for a in [0, 1): Bhaskara's rational form on half-turns, error under 0.0017, enough for
/// the spiral's random phase.
pub(crate) fn cosine_of_turn(a: f32) -> f32 {
    // Distance from the nearest whole turn, 0 to 0.5; the cosine is even about it.
    let b = if a < 0.5 { a } else { 1.0 - a };
    let (x, sign) = if b < 0.25 { (b, 1.0) } else { (0.5 - b, -1.0) };
    let x2 = x * x;
    sign * (1.0 - 16.0 * x2) / (1.0 + 4.0 * x2)
}

#[cfg(test)]
mod tests;
