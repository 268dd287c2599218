//! More samples than the processor can fly.

use super::desk_board::{Desk, fly};

/// 2,000 samples a second on a fifth of the speed: four of five are lost and counted, and the watchdog is fed.
#[test]
fn two_thousand_samples_a_second_on_a_fifth_of_the_speed_are_counted_loss_and_no_reset() {
    let defaults = Desk::default();
    let desk = Desk {
        period_us: 500,
        sample_us: 5 * defaults.sample_us,
        work_us: 5 * defaults.work_us,
        telemetry_us: 5 * defaults.telemetry_us,
        ..defaults
    };
    let seen = fly(desk, 30);
    println!("{} samples, {} flown, {} lost, {} resets", seen.acquired, seen.processed, seen.lost, seen.resets);
    assert_eq!(seen.resets, 0);
    assert!(seen.acquired >= 60_000 && seen.lost > seen.acquired / 2, "this is no overload");
    // All that were not lost were flown, but for those that still wait.
    assert!(seen.acquired - seen.lost - seen.processed < 32);
}
