//! The register-level models against their data sheets, by register addresses as those print them, with no
//! driver between.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod faults;
mod ism330dhcx;
mod rm3100;
mod wire;

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Uniform numbers within a range either side of zero.
struct Random(Xoshiro128PlusPlus);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    fn within(&mut self, range: f32) -> f32 {
        range * (self.0.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0)
    }

    fn vector(&mut self, range: f32) -> [f32; 3] {
        [self.within(range), self.within(range), self.within(range)]
    }
}
