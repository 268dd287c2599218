//! Sustained rotation, distinguished from a drill string's swing.

use super::filter_step::FilterStep;
use nalgebra::Vector3;

/// Least duration of a sustained rotation, seconds: longer than a drill string swings by itself. A string of
/// 3,200 m, held above and free below, swings with a period of four times its length over the speed of
/// torsional waves in steel, 3,200 m/s.
pub(super) const SUSTAINED_S: f32 = 4.0;
/// Sustained part of the rotation above which it has an axis; at least half of the mean rate's square is then
/// about that axis. A string that stops at each swing (speed 1 + cos) sustains a third; the limit is lower to allow for
/// the mean's own swing.
const STEADY: f32 = 0.25;

/// Sustained part of the probe's rotation: the excess of the squared mean rate over the variance.
pub(super) struct SustainedRotation {
    /// Mean rate over [`SUSTAINED_S`].
    mean_rad_s: Vector3<f32>,
    /// Mean of the squared rate, (rad/s)^2.
    mean_square: f32,
    /// Sustained part of that mean square, (rad/s)^2: now, and after it last grew or waned.
    square: f32,
    held_square: f32,
}

impl SustainedRotation {
    pub(super) const fn new() -> Self {
        Self { mean_rad_s: Vector3::new(0.0, 0.0, 0.0), mean_square: 0.0, square: 0.0, held_square: 0.0 }
    }

    /// Takes a filter step. Returns by how much the square of the sustained rate grew or waned, (rad/s)^2; 0 while the
    /// rotation remains the same.
    pub(super) fn update(&mut self, step: &FilterStep) -> f32 {
        let weight = step.time_s / (SUSTAINED_S + step.time_s);
        self.mean_rad_s += (step.angle_rad / step.time_s - self.mean_rad_s) * weight;
        self.mean_square += (step.squared_rate() - self.mean_square) * weight;
        let square = 2.0 * self.mean_rad_s.norm_squared() - self.mean_square;
        self.square = if square > 0.0 { square } else { 0.0 };
        let before = self.held_square;
        // A rotation that swings with stick-slip remains the same rotation.
        let waned = self.square < 0.25 * before;
        if self.square > before || waned {
            self.held_square = self.square;
            libm::fabsf(self.square - before)
        } else {
            0.0
        }
    }

    /// Mean rate of the body over [`SUSTAINED_S`], rad/s.
    pub(super) const fn mean_rad_s(&self) -> Vector3<f32> {
        self.mean_rad_s
    }

    /// Square of the sustained rate, (rad/s)^2.
    pub(super) const fn square(&self) -> f32 {
        self.square
    }

    /// Sustained share of the rotation, 0 to 1.
    pub(super) fn part(&self) -> f32 {
        if self.square > 0.0 { self.square / self.mean_square } else { 0.0 }
    }

    /// Body axes of the sustained rotation; `None` while there is none.
    pub(super) fn axes(&self) -> Option<[bool; 3]> {
        let rate = &self.mean_rad_s;
        let least = 0.5 * rate.norm_squared();
        (self.part() > STEADY).then(|| [rate.x, rate.y, rate.z].map(|axis| axis * axis > least))
    }
}

#[cfg(test)]
mod tests;
