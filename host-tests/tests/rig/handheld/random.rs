//! Seeded random numbers.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.between(0.0, 1.0)).ln()).sqrt() * self.between(0.0, TAU).cos()
    }
    pub fn normal3(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }
    pub fn direction(&mut self) -> Vector3<f64> {
        self.normal3().normalize()
    }
    /// Every element within `largest`, uniformly.
    pub fn matrix(&mut self, largest: f64) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.between(-largest, largest))
    }
    pub fn rotation(&mut self) -> Rotation3<f64> {
        Rotation3::from_scaled_axis(self.direction() * self.between(0.0, 3.1))
    }
}
