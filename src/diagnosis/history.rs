#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    report::MAX_CANDIDATES,
    sign_flip::{GROUPS, Scores},
    weak_columns::{COLUMNS, GYRO},
};
use crate::compensation::effect::MAX_PARAMETERS;
use core::ops::Range;

/// Columns of the candidates.
const CANDIDATES: usize = COLUMNS - GYRO;

/// Groups that the past is kept in, half of those of a test; the present fills the other half.
const PAST: usize = GROUPS / 2;

/// Scores of the windows so far, so that evidence adds up: an effect that no window shows by itself may show in all of them. They are
/// those beside one model; with another they are begun anew.
pub(crate) struct History {
    past: [[f32; CANDIDATES]; PAST],
    /// The candidates that were not asked for, one bit each: those in the model.
    model: u32,
    windows: u8,
    /// Of the window before: one less the chance of as clear a show of each candidate without it (all zero, where a static begins), and what it
    /// was worth when the last was chosen, or when it was.
    clearness: [f32; MAX_CANDIDATES],
    worths: [f32; MAX_CANDIDATES],
}

/// Windows after which the older half of what is known counts no more than the newer: some ten minutes.
const MOST_WINDOWS: u8 = 24;

impl History {
    pub const fn zero() -> Self {
        Self {
            past: [[0.0; CANDIDATES]; PAST],
            model: 0,
            windows: 0,
            clearness: [0.0; MAX_CANDIDATES],
            worths: [0.0; MAX_CANDIDATES],
        }
    }

    /// Begins to take a window's scores beside a model.
    pub fn begin(&mut self, model: u32) {
        if model != self.model {
            *self = Self { model, clearness: self.clearness, worths: self.worths, ..Self::zero() };
        }
        if self.windows >= MOST_WINDOWS {
            self.past.as_flattened_mut().iter_mut().for_each(|x| *x *= 0.5);
            self.windows /= 2;
        }
        self.windows += 1;
    }

    /// Keeps what a window showed.
    pub fn remember(&mut self, p_values: &[f32; MAX_CANDIDATES], worths: &[f32; MAX_CANDIDATES]) {
        self.clearness = p_values.map(|p_value| 1.0 - p_value);
        self.worths = *worths;
    }

    /// Chance of as clear a show of a candidate in the window before and in this one together, without it (Fisher, Statistical Methods for
    /// Research Workers, 4th ed., 1932, section 21.1: chi-square with 4 degrees of freedom of minus twice the logarithm of the product).
    pub fn chance_together(&self, index: usize, p_value: f32) -> f32 {
        let product = (1.0 - self.clearness.get(index).copied().unwrap_or(0.0)) * p_value;
        if product > 0.0 { product * (1.0 - libm::logf(product)) } else { 0.0 }
    }

    /// What a candidate was worth in the window before: of two that look alike the one that all data speak for is taken.
    pub fn worth(&self, index: usize) -> f32 {
        self.worths.get(index).copied().unwrap_or(0.0)
    }

    /// Windows in it, the present one included.
    pub const fn windows(&self) -> u8 {
        self.windows
    }

    /// Takes a candidate's scores of the present window, once, and gives them with those of the past; `None` where there is no past.
    pub fn with(&mut self, columns: &Range<usize>, scores: &Scores) -> Option<Scores> {
        let mut together = [[0.0; MAX_PARAMETERS]; GROUPS];
        let (present, past) = together.split_at_mut(PAST);
        let pairs = scores.as_chunks::<2>().0;
        for (((present, past), [first, second]), kept) in present.iter_mut().zip(past).zip(pairs).zip(&mut self.past) {
            let kept = kept.iter_mut().skip(columns.start.saturating_sub(GYRO)).take(columns.len());
            let sums = first.iter().zip(second).map(|(a, b)| a + b);
            for (((present, past), sum), kept) in present.iter_mut().zip(past).zip(sums).zip(kept) {
                (*present, *past) = (sum, *kept);
                *kept += sum;
            }
        }
        (self.windows > 1).then_some(together)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::effect::MAX_PARAMETERS;

    fn window(history: &mut History, model: u32, x: f32) -> Option<Scores> {
        history.begin(model);
        history.with(&(GYRO + 3..GYRO + 5), &[[x; MAX_PARAMETERS]; GROUPS])
    }

    #[test]
    fn windows_add_up_beside_one_model_and_are_forgotten_with_another() {
        let mut history = History::zero();
        assert_eq!(window(&mut history, 1, 1.0), None);
        let sum = |scores: &Scores| scores.iter().map(|z| z[1]).sum::<f32>();
        assert_eq!(window(&mut history, 1, 2.0).map(|scores| sum(&scores)), Some(36.0));
        assert_eq!(window(&mut history, 1, -1.0).map(|scores| sum(&scores)), Some(24.0));
        assert_eq!(history.windows(), 3);
        assert_eq!(window(&mut history, 5, 1.0), None);
        assert_eq!(history.windows(), 1);
        for _ in 0..100 {
            window(&mut history, 5, 1.0);
        }
        assert!(history.windows() <= MOST_WINDOWS);
    }

    #[test]
    fn what_the_window_before_showed_is_kept_whatever_the_model_and_until_the_next() {
        let mut history = History::zero();
        assert!(history.chance_together(3, 1e-3) > 1e-3, "nothing is known of before");
        let (mut p_values, mut worths) = ([1.0; MAX_CANDIDATES], [0.0; MAX_CANDIDATES]);
        (p_values[3], worths[3]) = (0.01, 7.0);
        history.remember(&p_values, &worths);
        window(&mut history, 7, 1.0);
        // Chi-square with 4 degrees of freedom: 13.28 is exceeded once in a hundred, and 2 ln of 1 / 0.01 and of 1 / 0.131 add up to it.
        assert!((history.chance_together(3, 0.130_8) - 0.01).abs() < 1e-4);
        assert_eq!([2, 3, 40].map(|index| history.worth(index)), [0.0, 7.0, 0.0]);
        history.remember(&[1.0; MAX_CANDIDATES], &[0.0; MAX_CANDIDATES]);
        assert_eq!(history.worth(3), 0.0);
    }
}
