//! Seeded random numbers.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Seeded random numbers. Every function is exact or from `libm`, so the same seed gives the same numbers on
/// every machine.
pub struct Random {
    generator: Xoshiro256PlusPlus,
    spare_normal: Option<f64>,
}

impl Random {
    /// The first stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self { generator: Xoshiro256PlusPlus::seed_from_u64(seed), spare_normal: None }
    }

    /// Splits off a stream of 2^128 numbers; this one continues behind it. Draws from one stream do not move
    /// another.
    pub fn split(&mut self) -> Self {
        let stream = Self { generator: self.generator.clone(), spare_normal: None };
        self.generator.jump();
        stream
    }

    /// Uniform in [0, 1), with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An index of so many, each as likely; 0 of none.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Plus or minus one.
    pub fn sign(&mut self) -> f64 {
        if self.uniform() < 0.5 { -1.0 } else { 1.0 }
    }

    /// Exponential with mean 1.
    pub fn exponential(&mut self) -> f64 {
        -libm::log(1.0 - self.uniform())
    }

    /// Normal with mean 0 and standard deviation 1 (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare_normal.take() {
            return spare;
        }
        loop {
            let (u, v) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = u * u + v * v;
            if square > 0.0 && square < 1.0 {
                let factor = libm::sqrt(-2.0 * libm::log(square) / square);
                self.spare_normal = Some(v * factor);
                return u * factor;
            }
        }
    }

    /// Three independent normals.
    pub fn normal3(&mut self) -> nalgebra::Vector3<f64> {
        nalgebra::Vector3::from_fn(|_, _| self.normal())
    }

    /// Normal with standard deviation `sigma`, drawn again while it is nearer to zero than `sigma` / 2.
    pub fn normal_off_centre(&mut self, sigma: f64) -> f64 {
        loop {
            let draw = self.normal();
            if draw.abs() >= 0.5 {
                return sigma * draw;
            }
        }
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        // Archimedes: the height of a uniform point on a sphere is uniform.
        let z = self.between(-1.0, 1.0);
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * self.uniform());
        let radius = libm::sqrt(1.0 - z * z);
        [radius * cosine, radius * sine, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_the_draws_are_those_of_their_distributions() {
        let mut random = Random::new(1);
        let n = 100_000;
        let mean = |f: &mut dyn FnMut() -> f64| (0..n).map(|_| f()).sum::<f64>() / f64::from(n);
        // Five standard errors each.
        assert!(mean(&mut || random.normal()).abs() < 5.0 / f64::from(n).sqrt());
        assert!((mean(&mut || random.normal().powi(2)) - 1.0).abs() < 5.0 * (2.0 / f64::from(n)).sqrt());
        assert!((mean(&mut || random.normal().powi(4)) - 3.0).abs() < 5.0 * (96.0 / f64::from(n)).sqrt());
        assert!((mean(&mut || random.exponential()) - 1.0).abs() < 5.0 / f64::from(n).sqrt());
        assert!((mean(&mut || random.direction()[0].powi(2)) - 1.0 / 3.0).abs() < 5.0 * (0.09 / f64::from(n)).sqrt());
        assert!(mean(&mut || random.sign()).abs() < 5.0 / f64::from(n).sqrt());
    }

    #[test]
    fn streams_of_a_seed_differ_and_are_repeatable() {
        let first_of = |seed| {
            let mut root = Random::new(seed);
            [root.split().uniform(), root.split().uniform(), root.uniform()]
        };
        let [a, b, c] = first_of(7);
        assert!(a != b && b != c && a != c);
        assert_eq!(first_of(7), [a, b, c]);
        assert_ne!(first_of(8), [a, b, c]);
    }
}
