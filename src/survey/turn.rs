//! Angle of a turn about the tool axis.

use crate::rotation::sine_and_cosine;
use nalgebra::Vector3;

/// Angle about the tool axis, kept as cosine and sine so that it never needs reduction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    cosine: f32,
    sine: f32,
}

impl Turn {
    pub(crate) const NONE: Self = Self { cosine: 1.0, sine: 0.0 };

    /// Turns by a further angle, radians.
    pub(crate) fn by(&mut self, angle_rad: f32) {
        let (s, c) = sine_and_cosine(angle_rad);
        let cosine = self.cosine * c - self.sine * s;
        let sine = self.sine * c + self.cosine * s;
        let renormalised = 1.5 - 0.5 * (cosine * cosine + sine * sine);
        (self.cosine, self.sine) = (cosine * renormalised, sine * renormalised);
    }

    /// Rotates a vector of the tool into the frame that does not turn.
    pub(crate) fn back(&self, v: &Vector3<f32>) -> Vector3<f32> {
        Vector3::new(self.cosine * v.x - self.sine * v.y, self.sine * v.x + self.cosine * v.y, v.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_every_size_add_up_to_their_sum() {
        for step in [1e-4_f32, 0.03, -0.1, 0.49, 0.51, -2.0] {
            let mut turn = Turn::NONE;
            (0..2_000).for_each(|_| turn.by(step));
            let (s, c) = libm::sincos(2_000.0 * f64::from(step));
            let v = turn.back(&Vector3::x());
            assert!((f64::from(v.x) - c).abs() < 2e-4 && (f64::from(v.y) - s).abs() < 2e-4, "{step} {v} {c} {s}");
        }
    }
}
