//! Intervals of samples with gaps, missing readings and the ends of time.

use super::*;

#[test]
fn samples_fall_into_their_interval_and_one_empty_one_is_bridged() {
    let grid = Grid::new(5_000);
    assert_eq!(grid.interval_us, 20_000);
    let mut accumulator = Accumulator::zero();
    accumulator.start(1_000_000, grid, 5_000);
    let mut closed = 0;
    for k in 0..12_u64 {
        let t = 1_000_000 + 5_000 * k;
        while let Some(increment) = accumulator.close_before(t, grid) {
            // Samples 0..4 and 4..8: the means of k are 1.5 and 5.5.
            assert_eq!(increment.rate, Some(Vector3::repeat(1.5 + 4.0 * closed as f32)));
            closed += 1;
        }
        accumulator.add(Reading::Usable(Vector3::repeat(k as f32)), Reading::Missing);
    }
    assert_eq!(closed, 2);
    assert!(accumulator.close_before(1_060_000, grid).is_some_and(|i| i.rate.is_some()));
    // Means 1.5, 5.5, 9.5: a straight line bridges one empty interval and no second one.
    let empty = accumulator.close_before(1_080_000, grid).unwrap();
    assert_eq!(empty.rate, Some(Vector3::repeat(13.5)));
    assert_eq!(accumulator.close_before(1_100_000, grid).unwrap().rate, None);
}

#[test]
fn a_missing_reading_is_stood_for_by_the_others_and_a_clipped_one_is_not() {
    let grid = Grid::new(5_000);
    let rate_of = |odd: Reading| {
        let mut accumulator = Accumulator::zero();
        accumulator.start(0, grid, 5_000);
        for reading in [Reading::Usable(Vector3::x()), odd, Reading::Usable(Vector3::x() * 2.0), Reading::Missing] {
            accumulator.add(reading, Reading::Missing);
        }
        accumulator.close_before(20_000, grid).unwrap().rate
    };
    assert_eq!(rate_of(Reading::Missing), Some(Vector3::x() * 1.5));
    assert_eq!(rate_of(Reading::Unusable), None);
}

#[test]
fn intervals_close_at_the_ends_of_time_too() {
    let grid = Grid::new(10_000);
    for start in [0, 4_999, u64::MAX - 100_000, u64::MAX - 5_000, u64::MAX] {
        let mut accumulator = Accumulator::zero();
        accumulator.start(start, grid, 10_000);
        let mut closed = 0;
        for t in (0..8).map_while(|k| start.checked_add(10_000 * k)) {
            while accumulator.close_before(t, grid).is_some() {
                closed += 1;
            }
        }
        assert!(closed <= 3, "{closed}");
    }
}
