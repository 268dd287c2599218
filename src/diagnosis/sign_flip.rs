use super::whitening::total;
use crate::compensation::effect::MAX_PARAMETERS;

/// Groups of contiguous test windows; 2^11 patterns of signs, as the sign of all together does not count.
pub(super) const GROUPS: usize = 12;

/// Whitened scores of one candidate, group by group.
pub(super) type Scores = [[f32; MAX_PARAMETERS]; GROUPS];

const PATTERNS: u32 = 1 << (GROUPS - 1);

/// Twice the gain in log-likelihood of a candidate, |sum of z|^2, and the share of the patterns of signs that would give as much: the
/// probability of it where the candidate is not there. Under that hypothesis the groups' scores are independent and as likely
/// of one sign as of the other, however unlike their noises are. Counted some patterns at a time.
pub(super) struct SignFlip {
    scores: Scores,
    /// Parameters that count; the others' scores are zero.
    dimension: usize,
    sum: [f32; MAX_PARAMETERS],
    signs: [f32; GROUPS],
    /// The next pattern.
    pattern: u32,
    as_large: u32,
    observed: f32,
}

impl SignFlip {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            scores: [[0.0; MAX_PARAMETERS]; GROUPS],
            dimension: 0,
            sum: [0.0; MAX_PARAMETERS],
            signs: [0.0; GROUPS],
            pattern: 0,
            as_large: 0,
            observed: 0.0,
        }
    }

    /// Begins with the whitened scores of the first `dimension` parameters.
    pub fn start(&mut self, scores: &Scores, dimension: usize) {
        self.scores = *scores;
        self.dimension = dimension;
        self.sum = total(scores);
        self.signs = [1.0; GROUPS];
        self.pattern = 1;
        self.as_large = 1;
        self.observed = self.square();
    }

    fn square(&self) -> f32 {
        self.sum.iter().take(self.dimension).fold(0.0, |total, x| total + x * x)
    }

    /// Counts at most so many patterns; the result when all are counted.
    #[inline(never)]
    pub fn count(&mut self, patterns: u32) -> Option<(f32, f32)> {
        // Rounding must not make a pattern as large as itself smaller.
        let limit = self.observed * (1.0 - 1e-5);
        let end = if PATTERNS - self.pattern < patterns { PATTERNS } else { self.pattern + patterns };
        for pattern in self.pattern..end {
            // Gray code: one group's sign changes from one pattern to the next.
            let group = pattern.trailing_zeros() as usize;
            let (Some(sign), Some(scores)) = (self.signs.get_mut(group), self.scores.get(group)) else { continue };
            *sign = -*sign;
            let change = 2.0 * *sign;
            self.sum.iter_mut().zip(scores).take(self.dimension).for_each(|(s, z)| *s += change * z);
            self.as_large += u32::from(self.square() >= limit);
        }
        self.pattern = end;
        (end == PATTERNS).then_some((self.observed, self.as_large as f32 / PATTERNS as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// In pieces of any size.
    fn sign_flip(scores: &Scores) -> (f32, f32) {
        let mut flip = SignFlip::zero();
        flip.start(scores, MAX_PARAMETERS);
        let mut pieces = [1, 7, 500].into_iter().cycle();
        loop {
            if let Some(found) = flip.count(pieces.next().unwrap()) {
                return found;
            }
        }
    }

    #[test]
    fn groups_that_agree_are_as_rare_as_can_be_and_one_group_alone_says_nothing() {
        let mut scores = [[0.0; MAX_PARAMETERS]; GROUPS];
        scores.iter_mut().for_each(|score| score[2] = 0.5);
        assert_eq!(sign_flip(&scores), (36.0, 1.0 / 2048.0));
        scores.iter_mut().for_each(|score| *score = [0.0; MAX_PARAMETERS]);
        scores[3] = [7.0; MAX_PARAMETERS];
        assert_eq!(sign_flip(&scores).1, 1.0);
    }

    #[test]
    fn without_an_effect_the_p_value_is_uniform_whatever_the_groups_noises() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
        let mut deviate = || generator.next_u32() as f32 / (u32::MAX / 2) as f32 - 1.0;
        let runs = 2_000;
        let mut below = [0; 2];
        for _ in 0..runs {
            let mut scores = [[0.0; MAX_PARAMETERS]; GROUPS];
            for (group, score) in scores.iter_mut().enumerate() {
                // Noises from 1 to 12.
                score.iter_mut().take(3).for_each(|z| *z = (group + 1) as f32 * deviate());
            }
            let (_, p) = sign_flip(&scores);
            for (count, level) in below.iter_mut().zip([0.05, 0.5]) {
                *count += i32::from(p <= level);
            }
        }
        // 100 +- 9.7 and 1000 +- 22.
        assert!((60..140).contains(&below[0]) && (910..1_090).contains(&below[1]), "{below:?}");
    }
}
