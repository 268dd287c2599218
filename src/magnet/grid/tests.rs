use super::*;

#[test]
fn grid_is_a_whole_number_of_samples_and_never_shorter_than_the_ring_is_sized_for() {
    for (period, interval) in [(3_500, 21_000), (3_333, 19_998), (10_000, 20_000), (15_000, 30_000), (33_333, 33_333)] {
        assert_eq!(Grid::new(period).interval_us, interval);
    }
    for period in 100..=20_000 {
        let interval = Grid::new(period).interval_us;
        assert!(interval.is_multiple_of(period) && (19_980..40_000).contains(&interval), "{period}");
    }
}
