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

/// Second at 200 Hz of a gyro that reads a steady turn about the vertical, as a bias would be, with a noisy field in
/// every sample of this number.
fn turned_second(deg_s: f32, every: u16, seed: u64) -> Option<Rest> {
    let mut detector = RestDetector::zero();
    detector.start(5_000);
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut noise = |width: f32| Vector3::from_fn(|_, _| width * (generator.next_u32() as f32 / u32::MAX as f32 - 0.5));
    let limits = RestLimits { bias_rad_s: 0.2, ..LIMITS };
    let mut found = None;
    for k in 0..200_u16 {
        let angle = deg_s.to_radians() * 0.005 * f32::from(k);
        let rate = Vector3::new(0.0, 0.0, deg_s.to_radians()) + noise(0.004);
        let field = Vector3::new(20.0 * libm::cosf(angle), -20.0 * libm::sinf(angle), 40.0) + noise(0.3);
        let field = if k % every == 0 { Reading::Usable(field) } else { Reading::Missing };
        found = detector.push(Reading::Usable(rate), Reading::Usable(Vector3::new(0.0, 0.0, -9.8)), field, &limits);
    }
    found.unwrap()
}

/// A turn is none of the noise by which it is judged: at 10 and at 5 Hz.
#[test]
fn a_slow_field_shows_a_turn_that_a_bias_would_explain() {
    for seed in 0..20 {
        for (deg_s, every) in [(5.0, 20), (9.0, 20), (9.0, 40)] {
            assert!(turned_second(deg_s, every, seed).is_none(), "{deg_s} {every} {seed}");
        }
        assert!(turned_second(0.0, 20, seed).is_some(), "at rest: {seed}");
    }
}
