#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::sign_flip::{GROUPS, Scores};
use crate::compensation::effect::MAX_PARAMETERS;
use core::hint::black_box;

type Vector = [f32; MAX_PARAMETERS];

/// The numbers of the parameters, in a loop that the compiler leaves a loop: unrolled, such ones took kilobytes. What it cannot see through it is
/// told, so that an index needs no check.
pub(super) fn each_parameter() -> impl Iterator<Item = usize> {
    (0..MAX_PARAMETERS).map(black_box).take_while(|k| *k < MAX_PARAMETERS)
}

/// The information S = L L^T that a candidate has beside the model, by its Cholesky factor; parameters that are not seen are left out.
pub(super) struct Whitening {
    lower: [Vector; MAX_PARAMETERS],
    seen: [bool; MAX_PARAMETERS],
}

impl Whitening {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { lower: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS], seen: [false; MAX_PARAMETERS] }
    }

    /// `floor`: the pivot under which a parameter is not seen. `None` where none is.
    pub fn new(information: &[Vector; MAX_PARAMETERS], dimension: usize, floor: impl Fn(usize) -> f32) -> Option<Self> {
        let mut lower = [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS];
        let mut seen = [false; MAX_PARAMETERS];
        for i in 0..MAX_PARAMETERS {
            if i >= dimension {
                break;
            }
            for j in 0..i {
                let sum = (0..j).fold(information[i][j], |sum, k| sum - lower[i][k] * lower[j][k]);
                lower[i][j] = if seen[j] { sum / lower[j][j] } else { 0.0 };
            }
            let pivot = (0..i).fold(information[i][i], |sum, k| sum - lower[i][k] * lower[i][k]);
            seen[i] = pivot > floor(i) && pivot.is_finite();
            lower[i][i] = if seen[i] { libm::sqrtf(pivot) } else { 1.0 };
            if !seen[i] {
                lower[i].iter_mut().take(i).for_each(|x| *x = 0.0);
            }
        }
        // Beyond the dimension: the identity, so that what is zero there stays so.
        for i in 0..MAX_PARAMETERS {
            if i >= dimension {
                lower[i][i] = 1.0;
            }
        }
        seen.contains(&true).then_some(Self { lower, seen })
    }

    /// L^-1 h of each group.
    #[inline(never)]
    pub fn whitened(&self, scores: &Scores) -> Scores {
        let mut whitened = *scores;
        for score in &mut whitened {
            for i in 0..MAX_PARAMETERS {
                let done = (0..i).fold(score[i], |sum, k| sum - self.lower[i][k] * score[k]);
                score[i] = if self.seen[i] { done / self.lower[i][i] } else { 0.0 };
            }
        }
        whitened
    }

    /// Twice the gain in log-likelihood of parameters x that were not estimated from these scores: 2 x s - x S x. Negative where 0 is likelier.
    #[inline(never)]
    pub fn twice_the_gain(&self, whitened: &Scores, x: &Vector) -> f32 {
        let score = total(whitened);
        (0..MAX_PARAMETERS).filter(|i| self.seen[*i]).fold(0.0, |gain, i| {
            let turned = (i..MAX_PARAMETERS).fold(0.0, |sum, k| sum + self.lower[k][i] * x[k]);
            gain + turned * (2.0 * score[i] - turned)
        })
    }

    /// L^-T z.
    fn back(&self, mut z: Vector) -> Vector {
        for i in (0..MAX_PARAMETERS).rev() {
            let done = (i + 1..MAX_PARAMETERS).fold(z[i], |sum, k| sum - self.lower[k][i] * z[k]);
            z[i] = done / self.lower[i][i];
        }
        z
    }

    /// What the whitened scores of all groups say that the parameters are.
    pub fn estimate(&self, whitened: &Scores) -> Vector {
        self.back(total(whitened))
    }

    /// Deviations of that estimate by the scatter of the groups (sandwich), so that they hold whatever the noise is; 1, the usual size, of
    /// what is not seen.
    pub fn sandwich(&self, whitened: &Scores) -> Vector {
        let groups = GROUPS as f32;
        let mean = total(whitened).map(|sum| sum / groups);
        let mut squares = [0.0; MAX_PARAMETERS];
        for z in whitened {
            let part = self.back(core::array::from_fn(|i| z[i] - mean[i]));
            for k in each_parameter() {
                squares[k] += part[k] * part[k];
            }
        }
        let unbiased = groups / (groups - 1.0);
        core::array::from_fn(|i| if self.seen[i] { libm::sqrtf(squares[i] * unbiased) } else { 1.0 })
    }
}

/// The scores of all groups together.
#[inline(never)]
pub(super) fn total(whitened: &Scores) -> Vector {
    let mut total = [0.0; MAX_PARAMETERS];
    for k in each_parameter() {
        total[k] = whitened.iter().fold(0.0, |sum, z| sum + z[k]);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_estimated_and_what_is_not_seen_is_left_out() {
        let mut information = [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS];
        information[0][0] = 50.0;
        information[0][1] = 20.0;
        information[1][0] = 20.0;
        information[1][1] = 40.0;
        information[2][2] = 0.1;
        let whitening = Whitening::new(&information, 3, |_| 1.0).unwrap();
        let truth = [0.7, -1.2];
        // S x, dealt out evenly; a little of it scattered, and something in what is not seen.
        let mut scores = [[0.0; MAX_PARAMETERS]; GROUPS];
        for (number, score) in scores.iter_mut().enumerate() {
            let scatter = if number % 2 == 0 { 0.5 } else { -0.5 };
            for i in 0..2 {
                score[i] = (information[i][0] * truth[0] + information[i][1] * truth[1]) / GROUPS as f32 + scatter;
            }
            score[2] = 9.0;
        }
        let whitened = whitening.whitened(&scores);
        let estimate = whitening.estimate(&whitened);
        assert!((estimate[0] - truth[0]).abs() < 1e-5 && (estimate[1] - truth[1]).abs() < 1e-5, "{estimate:?}");
        assert_eq!(estimate[2], 0.0);
        let sigma = whitening.sandwich(&whitened);
        // S^-1 (1, 1) / 2 is what a half in both scores moves the estimate by; 12 of them, 12 / 11 for the mean.
        let moved = 0.5 * (40.0 - 20.0) / (50.0 * 40.0 - 400.0);
        assert!((sigma[0] / (moved * libm::sqrtf(12.0 * 12.0 / 11.0)) - 1.0).abs() < 1e-4, "{sigma:?}");
        assert_eq!(sigma[2], 1.0);
        // x S x of the truth; less of twice as much; and what is not seen says nothing.
        let square = 50.0 * 0.49 - 40.0 * 0.84 + 40.0 * 1.44;
        for (times, gain) in [(1.0, square), (2.0, 0.0), (-1.0, -3.0 * square)] {
            let mut x = [0.0; MAX_PARAMETERS];
            (x[0], x[1], x[2]) = (times * truth[0], times * truth[1], 5.0);
            assert!((whitening.twice_the_gain(&whitened, &x) - gain).abs() < 1e-3 * square, "{times}");
        }
        assert!(Whitening::new(&information, 3, |_| 1e3).is_none());
    }
}
