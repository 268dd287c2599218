//! Shaking: the part of the specific force that is no gravity, and the noise that follows from it.

use nalgebra::{Vector2, Vector3};

/// Integration time of the force, seconds: a turn at 30 rpm, the slowest rotary drilling. In that time a probe in its
/// hole stays in place, and a wrong tilt hardly changes.
const IMPULSE_S: f32 = 2.0;
/// Weight of the newest impulse (the force's integral over [`IMPULSE_S`]) in the mean of squares. The mean is over
/// about nine impulses of two axes, 18 squares, so the density is known to a third (sqrt(2 / 18)).
const WEIGHT: f32 = 0.2;

/// Spectral density of the acceleration while no force is read, (m/s^2)^2/Hz: 1 m/s^2 correlated over 0.2 s.
pub(super) const UNSEEN_FORCE_DENSITY: f32 = 0.4;

/// Largest density, (m/s^2)^2/Hz: that of the acceleration assumed where no force is read.
const MOST: f32 = UNSEEN_FORCE_DENSITY;

/// Slow variation of the horizontal specific force, measured by its integral from one interval to the next.
///
/// A probe that stays in place has no slow acceleration. Yet vibration of the tool's own axes at the rotation's
/// frequency is slow in the earth frame, and sampling folds vibration to every frequency: at low frequency both are
/// white noise.
pub(super) struct Shaking {
    impulse_m_s: Vector2<f32>,
    last_m_s: Vector2<f32>,
    time_s: f32,
    /// Density at low frequency, (m/s^2)^2/Hz.
    density: f32,
}

impl Shaking {
    pub(super) const fn new() -> Self {
        const ZERO: Vector2<f32> = Vector2::new(0.0, 0.0);
        Self { impulse_m_s: ZERO, last_m_s: ZERO, time_s: 0.0, density: 0.0 }
    }

    /// Takes a step's mean force, NED. Only the time with a force counts: an accelerometer that is read less often than
    /// the filter steps is measured, too.
    pub(super) fn update(&mut self, force_m_s2: Option<&Vector3<f32>>, time_s: f32) {
        let Some(force) = force_m_s2 else { return };
        self.impulse_m_s += force.xy() * time_s;
        self.time_s += time_s;
        if self.time_s > IMPULSE_S {
            // Expected square of the change: on each of two axes twice the density times the time. A constant force, as
            // of a wrong tilt, drops out.
            let change = self.impulse_m_s - self.last_m_s;
            let density = change.norm_squared() / (4.0 * self.time_s);
            self.density += (if density < MOST { density } else { MOST } - self.density) * WEIGHT;
            (self.last_m_s, self.impulse_m_s, self.time_s) = (self.impulse_m_s, Vector2::zeros(), 0.0);
        }
    }

    /// Spectral density of each horizontal axis at low frequency, two-sided, (m/s^2)^2/Hz.
    pub(super) const fn density(&self) -> f32 {
        self.density
    }
}

#[cfg(test)]
mod tests;
