//! Seconds of rest and of motion, with readings that are missing or clipped.

use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const LIMITS: RestLimits = RestLimits { deviation_rad_s: 0.0087, bias_rad_s: 0.087 };

/// One second at 200 Hz of a bias plus noise, with the field turning at `turn_rad_s`.
fn second(bias: f32, noise: f32, turn_rad_s: f32, seed: u64) -> Option<Rest> {
    let mut detector = RestDetector::zero();
    detector.start(5_000);
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut uniform = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
    let mut found = None;
    for k in 0..200 {
        let rate = Vector3::new(bias + turn_rad_s, bias, bias) + Vector3::from_fn(|_, _| noise * uniform());
        let angle = turn_rad_s * k as f32 * 0.005;
        let field = Vector3::new(20.0, 40.0 * libm::cosf(angle), -40.0 * libm::sinf(angle))
            + Vector3::from_fn(|_, _| 0.7 * uniform());
        let force = Vector3::new(9.81, 0.0, 0.0) + Vector3::from_fn(|_, _| 0.1 * uniform());
        found = detector.push(Reading::Usable(rate), Reading::Usable(force), Reading::Usable(field), &LIMITS);
    }
    found.unwrap()
}

#[test]
fn missing_readings_are_left_out_of_a_rest_and_a_clipped_one_ends_it() {
    let rest = |odd: Reading, every: usize| {
        let mut detector = RestDetector::zero();
        detector.start(5_000);
        let readings = (0..200).map(|k| {
            let wave = if k % 2 == 0 { 0.001 } else { -0.001 };
            if k % every == 3 { odd } else { Reading::Usable(Vector3::repeat(0.03 + wave)) }
        });
        readings.fold(None, |_, reading| detector.push(reading, Reading::Missing, Reading::Missing, &LIMITS)).unwrap()
    };
    let found = rest(Reading::Missing, 4).unwrap();
    assert_eq!(found.samples, 150);
    assert!((found.rate - Vector3::repeat(0.03)).amax() < 1e-3);
    assert!(rest(Reading::Missing, 200).is_some());
    assert!(rest(Reading::Unusable, 200).is_none());
    assert!(RestDetector::zero().judge(&LIMITS).is_none(), "nothing read");
}

#[test]
fn a_still_second_gives_its_mean_and_a_moving_one_nothing() {
    for seed in 0..20 {
        let rest = second(0.03, 0.004, 0.0, seed).unwrap();
        // Uniform noise of width 0.004 has deviation 0.0012, its mean of 200 has 8e-5; the bound is 5
        // sigma.
        assert!((rest.rate - Vector3::repeat(0.03)).amax() < 4e-4);
        assert!(second(0.03, 0.05, 0.0, seed).is_none(), "vibrating");
        assert!(second(0.03, 0.004, 1.0, seed).is_none(), "turning fast");
        assert!(
            second(0.03, 0.004, 0.04, seed).is_none(),
            "turning at 2.3 deg/s, which only the field can tell from a bias"
        );
        assert!(second(0.0, 0.0, 0.0, seed).is_none(), "frozen gyro");
    }
}
