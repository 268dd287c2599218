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
mod tests;
