use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn a_long_mean_of_a_large_vector_keeps_its_last_digits() {
    let mut mean = BlockMean::new();
    for k in 0..100_000_u32 {
        // Alternates about 9.8, the exact mean.
        mean.add(&Vector3::new(0.0, 0.0, if k % 2 == 0 { -9.75 } else { -9.85 }));
    }
    assert!((mean.mean().unwrap().z + 9.8).abs() < 2e-6, "{}", mean.mean().unwrap().z);
    assert!(BlockMean::new().mean().is_none());
}

#[test]
fn the_covariance_is_that_of_the_mean_of_independent_blocks() {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut uniform = || (rng.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5;
    let (mut stated, mut actual) = (0.0, 0.0);
    for _ in 0..2_000 {
        let mut means = MeanOfBlocks::new();
        (0..8).for_each(|_| means.add(&Vector3::new(uniform() + 50.0, 0.0, 0.0)));
        stated += means.covariance().m11;
        actual += (means.mean().x - 50.0) * (means.mean().x - 50.0);
    }
    assert!((stated / actual - 1.0).abs() < 0.1, "{stated} {actual}");
}
