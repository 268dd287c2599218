use super::Grid;
use crate::rotation::sine_and_cosine;
use core::f32::consts::PI;

/// Test windows under way at a time: each begins a quarter of its length after the one before it, as sin^2 windows want it
/// (equations half a length apart lose a third of what the samples hold).
pub(in crate::diagnosis) const UNDER_WAY: usize = 4;

/// From one test window to the next, seconds: two seconds are the length that measures best (1 s: 1.3 times the rate error).
const HOP_S: f32 = 0.5;

/// Longest quarter of a test window in increments; a grid interval is at least 19.98 ms.
const CAPACITY: usize = 25;

/// Twice the test function over each quarter in terms of 1, cos a and sin a: 1 - C, C being cos a, -sin a, -cos a and sin a.
const SHAPES: [[i8; 3]; UNDER_WAY] = [[1, -1, 0], [1, 0, 1], [1, 1, 0], [1, 0, -1]];

/// sin^2 over a test window, and its slope.
///
/// sin^2 is (1 - cos a) / 2 and its slope proportional to sin a, the angle a going round once in a test window: by a quarter of a turn
/// in a quarter of it, so that in all quarters the two are the first one's cosine and sine, exchanged and with other signs.
pub(in crate::diagnosis) struct TestFunction {
    /// Increments of a test window.
    length: usize,
    interval_s: f32,
    /// Cosine and sine of the angle at each increment of the first quarter.
    angles: [[f32; 2]; CAPACITY],
}

impl TestFunction {
    pub const fn zero() -> Self {
        Self { length: 0, interval_s: 0.0, angles: [[0.0; 2]; CAPACITY] }
    }

    pub fn configure(&mut self, grid: Grid) {
        self.length = UNDER_WAY * grid.increments_in(HOP_S);
        self.interval_s = grid.interval_s();
        for (k, angle) in self.angles.iter_mut().enumerate() {
            let (sine, cosine) = sine_and_cosine(2.0 * PI * (k as f32 + 0.5) / self.length as f32);
            *angle = [cosine, sine];
        }
    }

    /// Weight, and slope with its sign turned, at an increment of a test window, times the interval; `None` beyond its end.
    pub fn at(&self, position: usize) -> Option<(f32, f32)> {
        if position >= self.length {
            return None;
        }
        let hop = self.hop();
        let [cosine, sine] = self.angles.get(position.checked_rem(hop)?).copied()?;
        let [plain, c, s] = SHAPES.get(position.checked_div(hop)?)?.map(|halves| 0.5 * f32::from(halves));
        let slope = 0.5 * PI / hop as f32;
        let [plain, weight_c, weight_s] = [plain, c, s].map(|w| w * self.interval_s);
        Some((plain + weight_c * cosine + weight_s * sine, -s * slope * cosine + c * slope * sine))
    }

    /// Variance of an equation whose vector has a white noise of variance 1 in each increment: the sum of the squared slopes.
    #[inline(never)]
    pub fn noise_gain(&self) -> f32 {
        0.125 * PI * PI / self.hop() as f32
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
            assert!((1..=CAPACITY).contains(&function.hop()), "{period}: {}", function.length);
        }
    }

    #[test]
    fn the_quarters_make_a_squared_sine_and_its_slope() {
        for period in [3_500, 5_000, 7_000, 33_333] {
            let mut function = TestFunction::zero();
            function.configure(Grid::new(period));
            let mut squares = 0.0;
            for k in 0..function.length {
                let phase = core::f64::consts::PI * (k as f64 + 0.5) / function.length as f64;
                let (weight, slope) = function.at(k).unwrap();
                let dt = f64::from(function.interval_s);
                assert!((f64::from(weight) / dt - phase.sin().powi(2)).abs() < 1e-6, "{period} {k}");
                let expected = -(2.0 * phase).sin() * core::f64::consts::PI / function.length as f64;
                assert!((f64::from(slope) - expected).abs() < 1e-6, "{period} {k}");
                squares += slope * slope;
            }
            assert!(function.at(function.length).is_none());
            assert!((squares / function.noise_gain() - 1.0).abs() < 1e-5);
        }
    }
}
