use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// A rate table: 300 deg/s, noise of 20 mdps, 61 mdps a count, starting at a fraction of a count that is as likely as
/// any.
#[test]
fn a_steady_turn_whose_noise_is_below_the_resolution_is_no_rail() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(30);
    let mut uniform = move || f64::from(random.next_u32()) / f64::from(u32::MAX);
    let mut railed = 0;
    for _ in 0..20 {
        let (mut rail, turn) = (Rail::zero(), 300.0 + 0.061 * uniform());
        for _ in 0..6_000 {
            let noise = libm::sqrt(-2.0 * libm::log(uniform() + 1e-12)) * libm::cos(core::f64::consts::TAU * uniform());
            let count = libm::round((turn + 0.02 * noise) / 0.061);
            railed += u32::from(rail.update((count * 0.061).to_radians() as f32));
        }
    }
    // Until the first reading beside the first one has come.
    assert!(railed < 120_000 / 100, "{railed} of 120000");
}

#[test]
fn an_outlier_hides_no_rail_for_ever() {
    let mut rail = Rail::zero();
    rail.update(40.0);
    (0..70_000).for_each(|k| assert!(!rail.update((k % 100) as f32 * 0.01)));
    assert_eq!((0..15).filter(|_| rail.update(34.9)).count(), 5);
}

#[test]
fn ten_repeats_of_the_largest_reading_are_a_rail_and_no_others() {
    let mut rail = Rail::zero();
    let seen = (0..15).filter(|_| rail.update(-4.0)).count();
    assert_eq!(seen, 5, "the first and nine repeats are not yet one");
    assert!(!rail.update(3.9), "below it");
    assert!(!rail.update(4.1), "beyond it: it was none");
    assert!(!rail.update(4.0));
    let mut slow = Rail::zero();
    assert!((0..100).all(|_| !slow.update(1.9)), "no gyro's rail is so low");
}
