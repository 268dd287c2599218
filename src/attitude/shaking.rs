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
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    fn mean_density(force: impl Fn(f32, f32) -> f32) -> f32 {
        mean_density_without(0, force)
    }

    /// The same, with no force in every step of this number; 0: in none.
    fn mean_density_without(every: u16, force: impl Fn(f32, f32) -> f32) -> f32 {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut uniform = || (rng.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5;
        let (mut shaking, mut sum) = (Shaking::new(), 0.0);
        for step in 0..60_000_u16 {
            let mut axis = || force(f32::from(step) * 0.05, uniform() * 3.464_1);
            let force = Vector3::new(axis(), axis(), -9.8);
            let is_read = every == 0 || step % every > 0;
            shaking.update(is_read.then_some(&force), 0.05);
            sum += if step < 2_000 { 0.0 } else { shaking.density() / 58_000.0 };
        }
        sum
    }

    #[test]
    fn white_noise_is_measured_and_neither_a_wrong_tilt_nor_a_shaking_in_place_is_noise() {
        // White noise of 1 m/s^2 in steps of 50 ms: 0.05 (m/s^2)^2/Hz.
        let white = mean_density(|_, noise| noise);
        assert!((white - 0.05).abs() < 0.01, "{white}");
        let tilted = mean_density(|_, noise| 0.5 + 0.01 * noise);
        assert!(tilted < 1e-4, "{tilted}");
        let shaken = mean_density(|t_s, _| 3.0 * libm::sinf(18.0 * t_s));
        assert!(shaken < 0.01, "{shaken}");
    }

    #[test]
    fn steps_without_a_force_restart_nothing() {
        for every in [2, 20] {
            let white = mean_density_without(every, |_, noise| noise);
            assert!((white - 0.05).abs() < 0.01, "{every}: {white}");
        }
    }
}
