use super::{super::Grid, UNDER_WAY};
use crate::rotation::sine_and_cosine;
use core::f32::consts::PI;

/// From one test window to the next, seconds: two seconds are the length that measures best (1 s: 1.3 times the rate error).
const HOP_S: f32 = 0.5;

/// Longest quarter of a test window in increments; a grid interval is at least 19.98 ms.
const CAPACITY: usize = 25;

/// cos a (sin a - cos a) over the first quarter in terms of 1, cos a and sin a: least squares, which leave 8 % of it.
const ODD_PART: [f32; 3] = [-1.754_932, 0.651_642, 1.819_601];

/// Mean square of sin a - cos a over the first quarter, 1 - 2 / pi.
pub(super) const ODD_SQUARE: f32 = 0.363_380;

/// Twice the test functions over each quarter in terms of 1, cos a and sin a. Of four quarters 1 - C, C being cos a, -sin a, -cos a and sin a;
/// of two half a wave, 2 sin a and 2 cos a; of one what of these is zero at both ends, 2 (sin a + cos a - 1).
const SHAPES: [[i8; 3]; 7] = [[1, -1, 0], [1, 0, 1], [1, 1, 0], [1, 0, -1], [0, 0, 2], [0, 2, 0], [-2, 2, 2]];

/// What a quarter's sums, plain, with the cosine and with the sine, count in a test window, times the interval.
pub(crate) struct QuarterWeights {
    /// In sums with the test function.
    pub weight: [f32; 3],
    /// In sums with its slope, with the sign turned; per increment.
    pub slope: [f32; 3],
    /// In sums with the test function times sin a - cos a, which goes from -1 to 1 over a quarter.
    pub turning: [f32; 3],
}

/// sin^2 over a test window, and its slope.
///
/// sin^2 is (1 - cos a) / 2 and its slope proportional to sin a, the angle a going round once in a test window: by a quarter of a turn
/// in a quarter of it, so that in all quarters the two are the first one's cosine and sine, exchanged and with other signs.
pub(crate) struct TestFunction {
    /// Increments of a test window.
    pub length: usize,
    pub interval_s: f32,
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

    /// Cosine and sine of the angle at an increment of the first quarter.
    pub fn angle(&self, position: usize) -> [f32; 2] {
        self.angles.get(position).copied().unwrap_or_default()
    }

    /// What the sums of a quarter count in a test window of `quarters` of them (4, 2 or 1) whose `number`th it is.
    pub fn of_quarter(&self, quarters: usize, number: usize) -> QuarterWeights {
        let shape = SHAPES.get(2 * UNDER_WAY - 2 * quarters + number).copied().unwrap_or_default();
        let [plain, cosine, sine] = shape.map(|halves| 0.5 * f32::from(halves));
        let slope = 0.5 * PI / self.hop() as f32;
        let [odd, same, other] = ODD_PART;
        // Seen from the quarter's end sine is cosine, and what is odd has the other sign.
        let turning =
            [(cosine - sine) * odd, cosine * same - sine * other - plain, cosine * other - sine * same + plain];
        QuarterWeights {
            weight: [plain, cosine, sine].map(|w| w * self.interval_s),
            slope: [0.0, -sine * slope, cosine * slope],
            turning: turning.map(|w| w * self.interval_s),
        }
    }

    /// Weight, and slope with its sign turned, at an increment of a test window, times the interval; `None` beyond its end.
    pub fn at(&self, position: usize) -> Option<(f32, f32)> {
        if position >= self.length {
            return None;
        }
        let hop = self.hop();
        let [cosine, sine] = self.angle(position.checked_rem(hop)?);
        let QuarterWeights { weight, slope, .. } = self.of_quarter(UNDER_WAY, position.checked_div(hop)?);
        let at = |[plain, c, s]: [f32; 3]| plain + c * cosine + s * sine;
        Some((at(weight), at(slope)))
    }

    /// Variance of an equation of a test window of `quarters` whose vector has a white noise of variance 1 in each increment: the sum of the
    /// squared slopes.
    #[inline(never)]
    pub fn noise_gain(&self, quarters: usize) -> f32 {
        let squares = match quarters {
            UNDER_WAY => 0.5,
            1 => ODD_SQUARE,
            _ => 1.0,
        };
        0.25 * PI * PI * squares / self.hop() as f32
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
            assert!((squares / function.noise_gain(UNDER_WAY) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn every_test_function_is_zero_at_both_ends_and_smooth_between_and_has_the_slope_that_it_states() {
        let mut function = TestFunction::zero();
        function.configure(Grid::new(5_000));
        for quarters in [UNDER_WAY, 2, 1] {
            let dt = function.interval_s;
            let (mut value, mut squares, mut most) = (0.0, 0.0, 0.0_f32);
            for k in 0..quarters * function.hop() {
                let [cosine, sine] = function.angle(k % function.hop());
                let QuarterWeights { weight, slope, turning } = function.of_quarter(quarters, k / function.hop());
                let at = |[plain, c, s]: [f32; 3]| plain + c * cosine + s * sine;
                // From the last increment's end to this one's middle.
                value -= 0.5 * at(slope);
                assert!((at(weight) / dt - value).abs() < 2e-3, "{quarters} {k}: {} {value}", at(weight) / dt);
                value -= 0.5 * at(slope);
                squares += at(slope) * at(slope);
                most = if value > most { value } else { most };
                // 8 % of it are left.
                let product = at(weight) * (sine - cosine);
                assert!((at(turning) - product).abs() < 0.2 * dt, "{quarters} {k}: {} {product}", at(turning));
            }
            assert!(value.abs() < 2e-3 && most > 0.4, "{quarters}: {value} {most}");
            assert!((squares / function.noise_gain(quarters) - 1.0).abs() < 2e-3, "{quarters}");
        }
    }
}
