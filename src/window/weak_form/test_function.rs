use super::{super::Grid, UNDER_WAY};
use crate::rotation::sine_and_cosine;
use core::f32::consts::PI;

/// From one test window to the next, seconds: two seconds are the length that measures best (1 s: 1.3 times the rate error).
const HOP_S: f32 = 0.5;

/// Longest test window in increments; a grid interval is at least 19.98 ms.
const CAPACITY: usize = 100;

/// sin^2 over a test window, and its slope, increment by increment.
pub(crate) struct TestFunction {
    /// Increments of a test window.
    pub length: usize,
    pub interval_s: f32,
    weight: [f32; CAPACITY],
    slope: [f32; CAPACITY],
}

impl TestFunction {
    pub const fn zero() -> Self {
        Self { length: 0, interval_s: 0.0, weight: [0.0; CAPACITY], slope: [0.0; CAPACITY] }
    }

    pub fn configure(&mut self, grid: Grid) {
        self.length = UNDER_WAY * grid.increments_in(HOP_S);
        self.interval_s = grid.interval_s();
        let duration = self.length as f32 * self.interval_s;
        for (k, (weight, slope)) in self.weight.iter_mut().zip(&mut self.slope).enumerate().take(self.length) {
            let angle = PI * (k as f32 + 0.5) / self.length as f32;
            let (sine, cosine) = sine_and_cosine(angle);
            *weight = sine * sine;
            *slope = 2.0 * sine * cosine * PI / duration;
        }
    }

    /// Weight, and slope with its sign turned, at an increment of a test window, times the interval; `None` beyond its end.
    pub fn at(&self, position: usize) -> Option<(f32, f32)> {
        if position >= self.length {
            return None;
        }
        let (weight, slope) = (self.weight.get(position)?, self.slope.get(position)?);
        Some((weight * self.interval_s, -slope * self.interval_s))
    }

    /// Variance of an equation whose vector has a white noise of variance 1 in each increment.
    pub fn noise_gain(&self) -> f32 {
        let slopes = self.slope.get(..self.length).unwrap_or_default();
        slopes.iter().fold(0.0, |sum, slope| sum + slope * slope) * self.interval_s * self.interval_s
    }

    /// Increments from one test window to the next.
    pub const fn hop(&self) -> usize {
        self.length / UNDER_WAY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_grid_has_a_whole_test_window() {
        for period in 100..=20_000 {
            let mut function = TestFunction::zero();
            function.configure(Grid::new(period));
            assert!((2..=CAPACITY).contains(&function.length), "{period}: {}", function.length);
        }
    }
}
