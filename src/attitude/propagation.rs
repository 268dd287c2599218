//! Propagation of the attitude by the compensated rate, sample by sample.

use crate::rotation::{IDENTITY, exp_quaternion, renormalised};
use nalgebra::{Quaternion, Vector3, Vector4};

/// Body-to-earth quaternion, integrated from body rates sample by sample.
///
/// Each interval's increment becomes a rotation vector by the coning term `a0 x a1 / 12` of the previous
/// increment and this one (Savage, Strapdown inertial navigation integration algorithm design part 1, J.
/// Guidance 21(1), 1998). For readings that are means over their interval, less than 1 % of the coning drift
/// remains up to 0.2 rad of phase per step. The quaternion step errs by less than 3e-7 (see `rotation`); its
/// norm stays within 1e-6 of one.
pub(crate) struct Propagation {
    /// Rotation from body to earth.
    pub(crate) q: Quaternion<f32>,
    increment_rad: Vector3<f32>,
    moving: bool,
    /// Attitude at the mark, and the product of the corrections since, in the earth frame.
    marked: Quaternion<f32>,
    corrected: Quaternion<f32>,
    has_mark: bool,
}

impl Propagation {
    /// All zero, for a static; set `q` before the first step.
    pub(crate) const fn new() -> Self {
        Self {
            q: Quaternion::from_vector(Vector4::new(0.0, 0.0, 0.0, 0.0)),
            increment_rad: Vector3::new(0.0, 0.0, 0.0),
            moving: false,
            marked: Quaternion::from_vector(Vector4::new(0.0, 0.0, 0.0, 0.0)),
            corrected: Quaternion::from_vector(Vector4::new(0.0, 0.0, 0.0, 0.0)),
            has_mark: false,
        }
    }

    /// Forgets the previous sample, so that the next step adds no coning term across a gap.
    pub(crate) const fn interrupt(&mut self) {
        self.moving = false;
        self.has_mark = false;
    }

    /// Leaves the coning term out of the next step. The mark stays.
    pub(crate) const fn break_off(&mut self) {
        self.moving = false;
    }

    /// Marks the attitude of this instant.
    pub(crate) const fn mark(&mut self) {
        (self.marked, self.corrected, self.has_mark) = (self.q, IDENTITY, true);
    }

    /// Takes the mark. Returns the rotation, earth frame, that brings the attitude now to where it would be if it had
    /// been `rotation` (body to earth) at the mark, with the same increments since; `None` without a mark.
    pub(crate) fn since_mark(&mut self, rotation: &Quaternion<f32>) -> Option<Quaternion<f32>> {
        // The attitude now is corrected * marked * increments.
        core::mem::replace(&mut self.has_mark, false)
            .then(|| rotation * self.marked.conjugate() * self.corrected.conjugate())
    }

    /// Advances by the `dt_s` seconds that end now, at their mean rate.
    pub(crate) fn step(&mut self, dt_s: f32, rate_rad_s: &Vector3<f32>) {
        let increment = rate_rad_s * dt_s;
        let mut rotation = increment;
        if self.moving {
            rotation += self.increment_rad.cross(&increment) * (1.0 / 12.0);
        }
        self.q = renormalised(&(self.q * exp_quaternion(&rotation)));
        self.increment_rad = increment;
        self.moving = true;
    }

    /// Rotates the estimate by a rotation vector in the earth frame.
    pub(crate) fn correct(&mut self, rotation_vector_rad: &Vector3<f32>) {
        self.turn(&exp_quaternion(rotation_vector_rad));
    }

    /// Rotates the estimate in the earth frame.
    pub(crate) fn turn(&mut self, by: &Quaternion<f32>) {
        self.q = renormalised(&(by * self.q));
        self.corrected = renormalised(&(by * self.corrected));
    }
}

#[cfg(test)]
mod tests;
