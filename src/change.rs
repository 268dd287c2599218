//! Rate of change of a vector, which bounds the vector in gaps between readings.

use nalgebra::Vector3;

/// Least rate that counts as turning, rad/s: 20 deg/s, VQF's default (Laidig and Seel, Information Fusion 91,
/// 2023).
pub(crate) const TURNING_RAD_S: f32 = 0.35;
/// Uncertainty added to the last rate while none is read, rad/s: a probe that turns more slowly than [`TURNING_RAD_S`]
/// counts as still.
pub(crate) const UNSEEN_RATE_RAD_S: f32 = 0.3;
/// Correlation time of an unread rate, seconds: one radian of phase of a 0.5 Hz swing.
pub(crate) const UNREAD_RATE_TIME_S: f32 = 0.3;
/// Length of the means that are compared, seconds: an increment of the estimator. Noise and vibration are faster.
const MEAN_S: f32 = 0.04;
/// Memory of the derivative's mean square, seconds: ten nodes of the estimator.
const MEMORY_S: f32 = 5.0;

/// Least angular acceleration assumed in a gap, rad/s^2: from rest to [`UNSEEN_RATE_RAD_S`] in [`UNREAD_RATE_TIME_S`].
pub(crate) const RATE_RAD_S2: f32 = UNSEEN_RATE_RAD_S / UNREAD_RATE_TIME_S;
/// Least change of specific force assumed in a gap, m/s^3: gravity in a body that turns at [`UNSEEN_RATE_RAD_S`].
pub(crate) const FORCE_M_S3: f32 = 9.81 * UNSEEN_RATE_RAD_S;

/// Mean square, per axis, of a vector's derivative over the last seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Change {
    sum: Vector3<f32>,
    seconds: f32,
    before: Vector3<f32>,
    has_before: bool,
    /// Mean square of the derivative per axis, (vector's unit per second)^2.
    square: f32,
    known_s: f32,
    /// Square of the least derivative that is assumed.
    least: f32,
}

impl Change {
    /// All zero, for a static.
    pub(crate) const ZERO: Self = Self::of_at_least(0.0);

    /// Change of a vector whose derivative is assumed to be at least this large in gaps.
    pub(crate) const fn of_at_least(derivative: f32) -> Self {
        Self {
            sum: Vector3::new(0.0, 0.0, 0.0),
            seconds: 0.0,
            before: Vector3::new(0.0, 0.0, 0.0),
            has_before: false,
            square: 0.0,
            known_s: 0.0,
            least: derivative * derivative,
        }
    }

    /// Adds the vector, which held for the `dt_s` seconds that end now.
    #[inline]
    pub(crate) fn update(&mut self, vector: &Vector3<f32>, dt_s: f32) {
        self.sum += vector * dt_s;
        self.seconds += dt_s;
        // A mean ends at the step nearest to its length: up to half a step early or late.
        if self.seconds + 0.5 * dt_s >= MEAN_S {
            self.learn();
        }
    }

    /// Updates the mean square by the change from one mean to the next.
    #[inline(never)]
    fn learn(&mut self) {
        let mean = self.sum / self.seconds;
        if self.has_before {
            let square = (mean - self.before).norm_squared() / (3.0 * self.seconds * self.seconds);
            self.known_s += self.seconds;
            let memory_s = if self.known_s < MEMORY_S { self.known_s } else { MEMORY_S };
            self.square += (square - self.square) * (self.seconds / memory_s);
        }
        (self.before, self.has_before) = (mean, true);
        (self.sum, self.seconds) = (Vector3::zeros(), 0.0);
    }

    /// Drops the mean in progress and the one before it: the next vector comes after a gap.
    pub(crate) fn interrupt(&mut self) {
        (self.sum, self.seconds, self.has_before) = (Vector3::zeros(), 0.0, false);
    }

    /// Mean square of the derivative per axis in a gap: the measured one, but no less than the assumed one.
    pub(crate) const fn square(&self) -> f32 {
        if self.square > self.least { self.square } else { self.least }
    }

    /// Variance, per axis, of a vector's integral over a gap about that of the straight line from `before` to `after`.
    /// The vector is taken to change as fast as before the gap, or as over it if that is faster, in an unknown
    /// direction. A derivative d that reverses in the middle puts the integral off by d gap^2 / 4; the deviation is
    /// taken as d gap^2 / sqrt(12).
    pub(crate) fn unread_variance(&self, before: &Vector3<f32>, after: &Vector3<f32>, gap_s: f32) -> f32 {
        let over_gap = (after - before).norm_squared() / (3.0 * gap_s * gap_s);
        // A NaN fails this comparison and stays NaN.
        let square = if over_gap <= self.square() { self.square() } else { over_gap };
        let time = gap_s * gap_s;
        square * time * time / 12.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::TAU;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const DT_S: f32 = 0.005;

    fn change_of(vector: impl Fn(f32) -> Vector3<f32>) -> Change {
        let mut change = Change::of_at_least(0.0);
        (0..2_000_u16).for_each(|k| change.update(&vector(f32::from(k) * DT_S), DT_S));
        change
    }

    #[test]
    fn a_steady_change_is_its_own_derivative() {
        let change = change_of(|t| Vector3::new(3.0, -4.0, 0.0) * t);
        assert!((change.square() - 25.0 / 3.0).abs() < 0.01, "{}", change.square());
        assert!(Change::of_at_least(2.0).square() >= 4.0);
    }

    #[test]
    fn a_change_over_the_gap_counts_where_none_was_before() {
        let still = change_of(|_| Vector3::new(0.1, 0.2, 0.3));
        let (before, after) = (Vector3::zeros(), Vector3::new(0.6, 0.0, 0.0));
        // 12 rad/s^2 on one axis, for 0.05 s.
        let expected = 144.0 / 3.0 * (0.05 * 0.05 * 0.05 * 0.05) / 12.0;
        assert!((still.unread_variance(&before, &after, 0.05) / expected - 1.0).abs() < 1e-3);
        assert!(still.unread_variance(&before, &before, 0.05) < 1e-12);
    }

    #[test]
    fn swings_that_nobody_reads_stay_within_the_deviations_told() {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(23);
        let mut uniform = move || random.next_u32() as f32 / u32::MAX as f32;
        let (mut within, mut beyond, mut sum, mut cases) = (0, 0, 0.0, 0);
        for _ in 0..400 {
            let (hz, phase, size) = (0.3 + 2.0 * uniform(), TAU * uniform(), 0.5 + 4.0 * uniform());
            let rate = |t: f32| Vector3::new(size * libm::sinf(TAU * hz * t + phase), 0.0, 0.0);
            let change = change_of(rate);
            let (from, gap) = (10.0 + uniform(), 0.02 + 0.15 * uniform());
            let (before, after) = (rate(from), rate(from + gap));
            let integral = |t: f32| -size * libm::cosf(TAU * hz * t + phase) / (TAU * hz);
            let missed = integral(from + gap) - integral(from) - 0.5 * gap * (before.x + after.x);
            let of_told = missed * missed / change.unread_variance(&before, &after, gap);
            (within, beyond) = (within + i32::from(of_told < 1.0), beyond + i32::from(of_told > 9.0));
            (sum, cases) = (sum + of_told, cases + 1);
        }
        assert!(within > 9 * cases / 10 && beyond == 0, "{within} and {beyond} of {cases}");
        // Nor is the variance needlessly wide: the mean squared error is over 1 % of it.
        assert!(sum / cases as f32 > 0.01, "{sum}");
    }

    #[test]
    fn nan_is_no_variance() {
        let change = change_of(|t| Vector3::new(t, 0.0, 0.0));
        assert!(change.unread_variance(&Vector3::new(f32::NAN, 0.0, 0.0), &Vector3::zeros(), 0.1).is_nan());
    }
}
