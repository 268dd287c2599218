//! Rates of change of vectors, and their deviations over gaps.

use super::*;
use core::f32::consts::TAU;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const DT_S: f32 = 0.005;

fn change_of(vector: impl Fn(f32) -> Vector3<f32>) -> Change {
    let mut change = Change::of_at_least(0.0);
    (0..2_000_u16).for_each(|k| change.update(&vector(f32::from(k) * DT_S), DT_S));
    change
}

#[test]
fn a_steady_change_is_its_own_derivative() {
    let change = change_of(|t| Vector3::new(3.0, -4.0, 0.0) * t);
    assert!((change.square() - 25.0 / 3.0).abs() < 0.01, "{}", change.square());
    assert!(Change::of_at_least(2.0).square() >= 4.0);
}

#[test]
fn a_change_over_the_gap_counts_where_none_was_before() {
    let still = change_of(|_| Vector3::new(0.1, 0.2, 0.3));
    let (before, after) = (Vector3::zeros(), Vector3::new(0.6, 0.0, 0.0));
    // 12 rad/s^2 on one axis, for 0.05 s.
    let expected = 144.0 / 3.0 * (0.05 * 0.05 * 0.05 * 0.05) / 12.0;
    assert!((still.unread_variance(&before, &after, 0.05) / expected - 1.0).abs() < 1e-3);
    assert!(still.unread_variance(&before, &before, 0.05) < 1e-12);
}

#[test]
fn swings_that_nobody_reads_stay_within_the_deviations_told() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(23);
    let mut uniform = move || random.next_u32() as f32 / u32::MAX as f32;
    let (mut within, mut beyond, mut sum, mut cases) = (0, 0, 0.0, 0);
    for _ in 0..400 {
        let (hz, phase, size) = (0.3 + 2.0 * uniform(), TAU * uniform(), 0.5 + 4.0 * uniform());
        let rate = |t: f32| Vector3::new(size * libm::sinf(TAU * hz * t + phase), 0.0, 0.0);
        let change = change_of(rate);
        let (from, gap) = (10.0 + uniform(), 0.02 + 0.15 * uniform());
        let (before, after) = (rate(from), rate(from + gap));
        let integral = |t: f32| -size * libm::cosf(TAU * hz * t + phase) / (TAU * hz);
        let missed = integral(from + gap) - integral(from) - 0.5 * gap * (before.x + after.x);
        let of_told = missed * missed / change.unread_variance(&before, &after, gap);
        (within, beyond) = (within + i32::from(of_told < 1.0), beyond + i32::from(of_told > 9.0));
        (sum, cases) = (sum + of_told, cases + 1);
    }
    assert!(within > 9 * cases / 10 && beyond == 0, "{within} and {beyond} of {cases}");
    // Nor is the variance needlessly wide: the mean squared error is over 1 % of it.
    assert!(sum / cases as f32 > 0.01, "{sum}");
}

#[test]
fn nan_is_no_variance() {
    let change = change_of(|t| Vector3::new(t, 0.0, 0.0));
    assert!(change.unread_variance(&Vector3::new(f32::NAN, 0.0, 0.0), &Vector3::zeros(), 0.1).is_nan());
}
