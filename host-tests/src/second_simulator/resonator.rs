//! A lightly damped mode driven by noise.

use std::f64::consts::TAU;
use testbed::simulate::Random;

/// x'' + 2 z w x' + w^2 x = noise, stepped half implicitly.
pub(super) struct Resonator {
    rad_s: f64,
    damping: f64,
    drive: f64,
    pub(super) x: f64,
    pub(super) rate: f64,
}

impl Resonator {
    /// A mode whose displacement has this deviation once it has settled.
    pub(super) fn new(hz: f64, damping: f64, deviation: f64, step_s: f64) -> Self {
        let rad_s = TAU * hz;
        // White noise of density q gives x the variance q / (4 z w^3); a step's noise has the variance q / step.
        let drive = deviation * (4.0 * damping * rad_s.powi(3) / step_s).sqrt();
        Self { rad_s, damping, drive, x: 0.0, rate: 0.0 }
    }

    /// One step; returns x''.
    pub(super) fn step(&mut self, step_s: f64, random: &mut Random) -> f64 {
        let noise = self.drive * random.normal();
        let acceleration = noise - 2.0 * self.damping * self.rad_s * self.rate - self.rad_s * self.rad_s * self.x;
        self.rate += acceleration * step_s;
        self.x += self.rate * step_s;
        acceleration
    }
}
