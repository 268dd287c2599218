//! Grid of the increments in time.

/// Nominal interval of one increment, microseconds: sums at 50 Hz lose nothing of the identification, those at 10 Hz
/// most of it.
const NOMINAL_INTERVAL_US: u32 = 20_000;

/// Time grid of the increments: the fewest whole nominal sample periods that make 20 ms, less a thousandth
/// for periods rounded to microseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub interval_us: u32,
}

impl Grid {
    pub const fn zero() -> Self {
        Self { interval_us: 0 }
    }

    pub fn new(sample_period_us: u32) -> Self {
        let shortest_us = NOMINAL_INTERVAL_US - NOMINAL_INTERVAL_US / 1_000;
        let samples = (shortest_us + sample_period_us.saturating_sub(1)).checked_div(sample_period_us).unwrap_or(0);
        Self { interval_us: samples * sample_period_us }
    }

    pub fn interval_s(self) -> f32 {
        self.interval_us as f32 * 1e-6
    }
}

#[cfg(test)]
mod tests;
