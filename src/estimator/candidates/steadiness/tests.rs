//! Steady motion.

#![allow(clippy::indexing_slicing)]
extern crate std;
use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const FIRST: CandidateId = CandidateId::new(0);

/// Estimates of a constant from so many readings of unit variance, noted every 20 of them; `extra` is added to each
/// reading.
fn noted(seed: u64, readings: usize, extra: impl Fn(usize) -> f64) -> f32 {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX);
    let mut steadiness = Steadiness::zero();
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 0..readings {
        let deviate = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        sum += 3.0 + deviate + extra(k);
        count += 1.0;
        if k % 20 == 19 {
            steadiness.start(CandidateSet::EMPTY);
            steadiness.note(FIRST, 0, core::iter::once(((sum / count) as f32, (1.0 / count) as f32)));
        }
    }
    steadiness.dispersion(FIRST)
}

#[test]
fn what_is_as_noisy_as_it_is_said_to_be_is_steady_and_what_comes_and_goes_is_not() {
    let mean = |extra: fn(usize) -> f64| (0..20).map(|seed| noted(seed, 400, extra)).sum::<f32>() / 20.0;
    // At least 1 of each: about 1.15 on the mean where chi-square of 19 over 19 has a deviation of a third.
    let honest = mean(|_| 0.0);
    assert!((1.0..1.3).contains(&honest), "{honest}");
    // Waves with periods of 30 and 50 readings.
    let waves = [mean(|k| libm::sin(k as f64 * 0.2)), mean(|k| libm::sin(k as f64 * 0.125))];
    assert!(waves.iter().all(|wave| *wave > 2.5), "{waves:?}");
}

/// When each weighing teaches little, several together do.
#[test]
fn what_begins_to_vary_late_in_a_run_is_not_steady() {
    let late = |k: usize| if k < 6_000 { 0.0 } else { libm::sin(0.002 * k as f64) };
    for seed in 0..20 {
        let (honest, varying) = (noted(seed, 20_000, |_| 0.0), noted(seed, 20_000, late));
        assert!(honest < 2.0 && varying > 2.0, "{seed}: {honest} {varying}");
    }
}

#[test]
fn estimates_beside_other_candidates_are_not_compared() {
    let mut steadiness = Steadiness::zero();
    let mut other = CandidateSet::EMPTY;
    other.insert(CandidateId::new(1));
    for (beside, mean, variance) in [(CandidateSet::EMPTY, 0.0, 1.0), (other, 30.0, 0.5), (other, 30.1, 0.4)] {
        steadiness.start(beside);
        steadiness.note(FIRST, 0, core::iter::once((mean, variance)));
    }
    assert_eq!(steadiness.dispersion(FIRST), 1.0);
    steadiness.note(FIRST, 0, core::iter::once((31.0, 0.3)));
    assert!((steadiness.dispersion(FIRST) - (0.01 / 0.1 + 0.81 / 0.1) / 2.0).abs() < 1e-3);
}
