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
mod tests;
