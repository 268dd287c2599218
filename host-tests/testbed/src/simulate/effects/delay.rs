//! Delay of readings.

use std::collections::VecDeque;

use nalgebra::Vector3;

/// A delay of any length: linear between the surrounding samples. A vector that turns by a in one sample
/// loses up to a^2 / 8 of its length and none of its direction.
pub(super) struct Delay {
    /// Delay in samples.
    lag: f64,
    history: VecDeque<Vector3<f64>>,
}

impl Delay {
    /// A delay of `lag_ms` milliseconds where a sample takes `period_s`.
    pub(super) fn new(lag_ms: f64, period_s: f64) -> Self {
        Self { lag: lag_ms * 1e-3 / period_s, history: VecDeque::new() }
    }

    pub(super) fn next(&mut self, value: Vector3<f64>) -> Vector3<f64> {
        self.history.push_front(value);
        let whole = self.lag as usize;
        self.history.truncate(whole + 2);
        // Before the first sample everything stood still.
        let ago = |n: usize| self.history.get(n).or(self.history.back()).copied().unwrap_or(value);
        ago(whole).lerp(&ago(whole + 1), self.lag - whole as f64)
    }
}

#[cfg(test)]
mod tests {
    use crate::simulate::effects::{
        Effects,
        clean_run::{readings, vector},
    };

    #[test]
    fn a_lag_of_whole_samples_moves_the_column_and_a_broken_one_lies_between() {
        let clean = readings(&Effects::default());
        let late = readings(&Effects { mag_lag_ms: 20.0, accel_lag_ms: 30.0, gyro_lag_ms: 5.0, ..Effects::default() });
        for i in 3..clean.len() {
            assert_eq!(late[i].mag_ut, clean[i - 2].mag_ut);
            assert_eq!(late[i].accel_m_s2, clean[i - 3].accel_m_s2);
            let middle = 0.5 * (vector(clean[i].gyro_rad_s) + vector(clean[i - 1].gyro_rad_s));
            assert!((vector(late[i].gyro_rad_s) - middle).norm() < 1e-6);
        }
    }
}
