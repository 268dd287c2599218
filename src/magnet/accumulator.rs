//! Accumulator: samples become increments of the grid.

use super::{grid::Grid, increment::Increment};
use crate::sample::Reading;
use nalgebra::Vector3;

/// Accumulator of the samples of one grid interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accumulator {
    end_us: u64,
    rate: Vector3<f32>,
    field: Vector3<f32>,
    rates: u16,
    fields: u16,
    rate_unusable: bool,
    field_unusable: bool,
    /// Mean rates of the last two intervals, twice the same after the first; `None` before it, and after a bridged or
    /// clipped one.
    last_rates: Option<[Vector3<f32>; 2]>,
}

impl Accumulator {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            end_us: 0,
            rate: zero,
            field: zero,
            rates: 0,
            fields: 0,
            rate_unusable: false,
            field_unusable: false,
            last_rates: None,
        }
    }

    /// Mean rate of the interval. A single interval without readings is bridged by the straight line through
    /// the two before it: of a rate that swings at 0.25 Hz by 180 deg/s the line misses 0.2 deg/s over 20 ms.
    /// A clipped interval is not bridged.
    fn rate(&self) -> Option<Vector3<f32>> {
        match (self.rate_unusable, self.rates) {
            (true, _) => None,
            (false, 0) => self.last_rates.map(|[before, last]| last * 2.0 - before),
            (false, count) => Some(self.rate / f32::from(count)),
        }
    }

    /// Starts a grid whose first interval holds the sample at `t_us`, half a sample period after its
    /// beginning.
    pub fn start(&mut self, t_us: u64, grid: Grid, sample_period_us: u32) {
        *self = Self::zero();
        self.end_us = t_us.wrapping_add(u64::from(grid.interval_us) - u64::from(sample_period_us / 2));
    }

    /// Returns the increment that ends before `t_us`, if any. Call this function until it returns `None` before adding
    /// the sample of `t_us`.
    pub fn close_before(&mut self, t_us: u64, grid: Grid) -> Option<Increment> {
        // The end is at most a gap away, so a wrapped difference orders the two at every 64-bit time.
        if t_us.wrapping_sub(self.end_us).cast_signed() < 0 {
            return None;
        }
        let mean = |sum: Vector3<f32>, n: u16| if n == 0 { None } else { Some(sum / f32::from(n)) };
        let increment = Increment {
            rate: self.rate(),
            field: if self.field_unusable { None } else { mean(self.field, self.fields) },
        };
        let read = increment.rate.filter(|_| self.rates > 0);
        let last_rates = read.map(|rate| [self.last_rates.map_or(rate, |[_, last]| last), rate]);
        *self = Self { end_us: self.end_us.wrapping_add(u64::from(grid.interval_us)), last_rates, ..Self::zero() };
        Some(increment)
    }

    /// Adds one sample: raw rate and calibrated field.
    pub fn add(&mut self, rate: Reading, field: Reading) {
        let add = |reading, sum: &mut Vector3<f32>, count: &mut u16, unusable: &mut bool| match reading {
            Reading::Usable(vector) => {
                *sum += vector;
                *count += 1;
            }
            Reading::Unusable => *unusable = true,
            Reading::Missing => {}
        };
        add(rate, &mut self.rate, &mut self.rates, &mut self.rate_unusable);
        add(field, &mut self.field, &mut self.fields, &mut self.field_unusable);
    }
}

#[cfg(test)]
mod tests {
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
}
