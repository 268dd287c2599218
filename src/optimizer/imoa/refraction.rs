//! Refraction of members through the start (paper, eq 26 to 29).

use crate::optimizer::random::uniform;
use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Refraction, eq 26 to 29 in our reading. With probability 0.3 + 0.7 p, p = 1 - exp(-(2 t / T)^2 / 2) (eq
/// 26), one variable is mirrored about the start and shrunk by a ratio from (1, 10) (eq 27). Eq 28 only
/// restates eq 27, so the ratio is drawn; the middle of eq 29's bounds is the least-squares estimate of that
/// variable, the start. Returns `None` if nothing is refracted.
pub(super) fn refracted<const D: usize>(
    member: &[f32; D],
    start: &[f32; D],
    progress: f32,
    generator: &mut Xoshiro128PlusPlus,
) -> Option<[f32; D]> {
    let p = 1.0 - libm::expf(-2.0 * progress * progress);
    if uniform(generator) >= 0.3 + 0.7 * p {
        return None;
    }
    let mut out = *member;
    let variable = generator.next_u32() as usize % if D == 0 { 1 } else { D };
    let ratio = 1.0 + 9.0 * uniform(generator);
    let (x, start) = (out.get_mut(variable)?, start.get(variable)?);
    *x = start - (*x - start) / ratio;
    Some(out)
}

#[cfg(test)]
mod tests;
