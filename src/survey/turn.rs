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

    /// Turn that takes `block` onto `first` across the tool axis; `None` where under a tenth of them lies there,
    /// 6 deg off the axis: 10 mg or 500 nT of noise then pass for a turn of 6 deg.
    pub(crate) fn between(first: &Vector3<f32>, block: &Vector3<f32>) -> Option<Self> {
        let (cosine, sine) = (first.x * block.x + first.y * block.y, first.y * block.x - first.x * block.y);
        let norm = libm::sqrtf(cosine * cosine + sine * sine);
        (norm > 0.01 * block.norm_squared()).then(|| Self { cosine: cosine / norm, sine: sine / norm })
    }

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
mod tests;
