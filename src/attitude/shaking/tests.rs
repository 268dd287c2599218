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
