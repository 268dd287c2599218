//! Shocks are told from vibration.

use super::{super::shocks::Shocks, deviate, shake};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Largest specific force of four samples of Gaussian vibration of this deviation, with gravity.
fn vibration(generator: &mut Xoshiro128PlusPlus, deviation: f64, gravity: f64) -> f32 {
    let sample = |generator: &mut Xoshiro128PlusPlus| {
        let [x, y, z] = core::array::from_fn(|_| deviation * deviate(generator));
        libm::sqrt(x * x + y * y + (z + gravity) * (z + gravity))
    };
    (0..4).map(|_| sample(generator)).fold(0.0, f64::max) as f32
}

#[test]
fn vibration_alone_is_a_shock_once_in_eight_minutes_or_less() {
    for (seed, deviation, gravity) in [(1, 5.0, 9.81), (2, 0.05, 9.81), (3, 100.0, 9.81), (4, 1.0, 0.0)] {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let (mut shocks, mut now_us) = (Shocks::zero(), 0);
        shake(&mut shocks, &mut now_us, 3_600, || vibration(&mut generator, deviation, gravity));
        assert!(shocks.seen <= 20, "{} of {deviation} m/s^2", shocks.seen);
    }
}

#[test]
fn a_shock_is_seen_once_with_its_ringing_and_a_fourth_is_lost_where_three_steps_have_shown() {
    for seed in 0..20 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let (mut shocks, mut now_us) = (Shocks::zero(), 0);
        let mut vibrate = |shocks: &mut Shocks, now_us: &mut u64, seconds| {
            shake(shocks, now_us, seconds, || vibration(&mut generator, 3.0, 9.81));
        };
        vibrate(&mut shocks, &mut now_us, 20);
        // Ten times as hard as the vibration; then it rings for 1.5 s.
        let hit = |shocks: &mut Shocks, now_us: &mut u64| {
            let mut peak = 150.0_f32;
            let at_us = *now_us + 40_000;
            for _ in 0..38 {
                *now_us += 40_000;
                if shocks.look_at(*now_us, peak) {
                    shocks.begin_step(*now_us, peak);
                }
                peak *= 0.95;
            }
            at_us
        };
        for step in 0..3 {
            let at_us = hit(&mut shocks, &mut now_us);
            vibrate(&mut shocks, &mut now_us, 10);
            assert_eq!((shocks.seen, shocks.lost), (u32::from(step) + 1, 0), "{seed}");
            assert_eq!(shocks.at_us(step), Some(at_us));
            shocks.show(step, 5.0 - f32::from(step));
        }
        hit(&mut shocks, &mut now_us);
        vibrate(&mut shocks, &mut now_us, 10);
        assert_eq!((shocks.seen, shocks.lost), (4, 1), "{seed}");
        // The place of one that shows least goes to the next, a free one first.
        shocks.show(0, -1.0);
        shocks.show(2, -2.0);
        let at_us = hit(&mut shocks, &mut now_us);
        vibrate(&mut shocks, &mut now_us, 10);
        assert_eq!((shocks.lost, shocks.at_us(2)), (1, Some(at_us)), "{seed}");
        // A place that is free again is taken by the next.
        shocks.drop_step(1);
        assert_eq!(shocks.at_us(1), None);
        let at_us = hit(&mut shocks, &mut now_us);
        assert_eq!((shocks.seen, shocks.lost, shocks.at_us(1)), (6, 1, Some(at_us)), "{seed}");
    }
}

#[test]
fn nothing_is_a_shock_before_the_vibration_is_known() {
    let (mut shocks, mut now_us) = (Shocks::zero(), 0);
    shake(&mut shocks, &mut now_us, 5, || 9.81);
    shake(&mut shocks, &mut now_us, 1, || 500.0);
    assert_eq!(shocks.seen, 0);
}
