//! Consistency of what is stated with what is seen: how large innovations are against what was expected of them.

use crate::change::TURNING_RAD_S;
use nalgebra::{Matrix3, Vector3};

/// Time in which one innovation tells nothing new, seconds: a turn by a radian at the slowest rate that counts as
/// turning. A mean that is exceeded grows within that time.
const CORRELATION_S: f32 = 1.0 / TURNING_RAD_S;
/// Memory of a mean that is not reached, seconds: ten innovations that have nothing in common.
const MEMORY_S: f32 = 10.0 * CORRELATION_S;
/// Least ratio: so many innovations bound none below their number's inverse.
const LEAST: f32 = CORRELATION_S / MEMORY_S;

/// Mean squared innovations over the variances that the filter expects. It weighs with bounds of what sensors and
/// motion may do, and states by what they do. The gain is that of the bounds.
pub(super) struct Consistency {
    tilt: f32,
    heading: f32,
}

impl Consistency {
    /// All zero, for a static.
    pub const ZERO: Self = Self { tilt: 0.0, heading: 0.0 };

    /// Means at what is expected.
    pub const fn new() -> Self {
        Self { tilt: 1.0, heading: 1.0 }
    }

    /// Takes one of the two velocities at the end of a step: its square over its expected square.
    pub fn note_velocity(&mut self, ratio: f32, time_s: f32) {
        note(&mut self.tilt, ratio, 0.5 * time_s);
    }

    /// Takes a heading by the field: the same.
    pub fn note_heading(&mut self, ratio: f32, time_s: f32) {
        note(&mut self.heading, ratio, time_s);
    }

    /// Covariance of the attitude error by what was seen, from that by what was expected (NED). No larger: what exceeds
    /// its expectation is the business of gates.
    pub fn stated(&self, covariance: &Matrix3<f32>) -> Matrix3<f32> {
        let (tilt, heading) = (deviation(self.tilt), deviation(self.heading));
        let by = Matrix3::from_diagonal(&Vector3::new(tilt, tilt, heading));
        by * covariance * by
    }
}

/// Moves a mean: up at once, down slowly.
fn note(mean: &mut f32, ratio: f32, time_s: f32) {
    // Beyond one nothing is stated; a NaN is no innovation.
    let ratio = if ratio < 1.0 { ratio } else { 1.0 };
    let smoothing_s = if ratio > *mean { CORRELATION_S } else { MEMORY_S };
    *mean += (ratio - *mean) * (time_s / (smoothing_s + time_s));
}

/// Factor of a deviation.
fn deviation(mean: f32) -> f32 {
    libm::sqrtf(if mean > LEAST { mean } else { LEAST })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_follows_what_is_seen_down_within_half_a_minute_and_up_within_seconds() {
        let mut consistency = Consistency::new();
        let one = Matrix3::<f32>::identity();
        let steps = |consistency: &mut Consistency, seconds: u16, ratio: f32| {
            for _ in 0..seconds * 20 {
                consistency.note_heading(ratio, 0.05);
                consistency.note_velocity(0.04, 0.05);
                consistency.note_velocity(0.04, 0.05);
            }
        };
        assert_eq!(consistency.stated(&one), one);
        steps(&mut consistency, 120, 0.25);
        let stated = consistency.stated(&one);
        assert!((stated.m33 - 0.25).abs() < 0.02 && stated.m11 >= LEAST && stated.m11 < 0.12, "{stated}");
        steps(&mut consistency, 9, 4.0);
        assert!((0.9..=1.0).contains(&consistency.stated(&one).m33));
        // The part that both share stays correlated.
        let mut common = one;
        (common.m13, common.m31) = (0.5, 0.5);
        let stated = consistency.stated(&common);
        assert!((stated.m13 / libm::sqrtf(stated.m11 * stated.m33) - 0.5).abs() < 1e-5);
    }
}
