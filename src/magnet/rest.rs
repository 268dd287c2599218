//! Detection of rest, second by second, for the watch for magnets and for calibrations: the mean of a raw gyro at rest
//! is its bias. The attitude filter and the estimator have detectors of their own (`attitude/rest.rs`,
//! `estimator/rest.rs`), which go on from sample to sample.

pub use crate::sample::Reading;

use nalgebra::Vector3;

/// Detector of seconds of rest: gyro deviation under a limit on every axis, a mean rate that a bias can
/// explain, and vector sensors that do not turn (a steady turntable is no rest).
#[derive(Clone, Copy, Debug)]
pub struct RestDetector {
    samples: u16,
    /// Number of samples with a raw rate.
    rates: u16,
    samples_per_second: u16,
    /// First raw rate of the second, subtracted from the others to preserve the sums' precision.
    origin: Vector3<f32>,
    sum: Vector3<f32>,
    square: Vector3<f32>,
    clipped: bool,
    force: Halves,
    field: Halves,
}

/// Limits of the detector.
#[derive(Clone, Copy, Debug)]
pub struct RestLimits {
    /// Largest deviation of the gyro on an axis, rad/s.
    pub deviation_rad_s: f32,
    /// Largest mean rate that a bias can explain, rad/s.
    pub bias_rad_s: f32,
}

/// One second of rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Mean raw rate, rad/s: the bias.
    pub rate: Vector3<f32>,
    /// Variance of one sample of the raw rate, mean of the axes, (rad/s)^2.
    pub variance: f32,
    /// Number of samples with a raw rate.
    pub samples: u16,
}

/// Sums over the first and the second half of a second.
#[derive(Clone, Copy, Debug)]
struct Halves {
    sums: [Vector3<f32>; 2],
    counts: [u16; 2],
    square: f32,
    origin: Vector3<f32>,
}

impl Halves {
    const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { sums: [zero; 2], counts: [0; 2], square: 0.0, origin: zero }
    }

    fn add(&mut self, reading: Reading, second_half: bool) {
        let Reading::Usable(vector) = reading else { return };
        if self.counts == [0, 0] {
            self.origin = vector;
        }
        let [first, second] = &mut self.sums;
        let [n_first, n_second] = &mut self.counts;
        let (sum, n) = if second_half { (second, n_second) } else { (first, n_first) };
        *sum += vector - self.origin;
        *n += 1;
        self.square += (vector - self.origin).norm_squared();
    }

    fn mean(&self) -> Option<Vector3<f32>> {
        let n = self.counts[0] + self.counts[1];
        if n == 0 { None } else { Some(self.origin + (self.sums[0] + self.sums[1]) / f32::from(n)) }
    }

    /// Returns true if the direction turned by more than `limit_rad` between the halves, beyond 3 standard
    /// errors.
    fn turned(&self, limit_rad: f32) -> bool {
        let [n0, n1] = self.counts.map(f32::from);
        let Some(mean) = self.mean() else { return false };
        if n0 < 2.0 || n1 < 2.0 {
            return false;
        }
        let means = [self.sums[0] / n0, self.sums[1] / n1];
        let change = means[0] - means[1];
        // Variance of one reading, summed over the axes, about each half's own mean and less that of a steady turn by
        // `change`: n readings of such a turn vary within the halves by n/12 - 1/(3 n) of its square.
        let n = n0 + n1;
        let within = self.square - n0 * means[0].norm_squared() - n1 * means[1].norm_squared();
        let noise = within - change.norm_squared() * (n / 12.0 - 1.0 / (3.0 * n));
        let variance = if noise > 0.0 { noise / (n - 2.0) } else { 0.0 };
        let error = libm::sqrtf(variance * (1.0 / n0 + 1.0 / n1));
        change.norm() > limit_rad * mean.norm() + 3.0 * error
    }
}

impl RestDetector {
    /// Returns a detector that has not been started.
    #[must_use]
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        let halves = Halves::zero();
        Self {
            samples: 0,
            rates: 0,
            samples_per_second: 0,
            origin: zero,
            sum: zero,
            square: zero,
            clipped: false,
            force: halves,
            field: halves,
        }
    }

    /// Starts a second.
    pub fn start(&mut self, sample_period_us: u32) {
        *self = Self::zero();
        self.samples_per_second = 1_000_000_u32.checked_div(sample_period_us).unwrap_or(1) as u16;
    }

    /// Takes one sample. At the end of a second returns the rest, or `Some(None)` if the second was no rest.
    pub fn push(&mut self, rate: Reading, force: Reading, field: Reading, limits: &RestLimits) -> Option<Option<Rest>> {
        let second_half = 2 * self.samples >= self.samples_per_second;
        match rate {
            Reading::Usable(rate) => {
                if self.rates == 0 {
                    self.origin = rate;
                }
                let centred = rate - self.origin;
                self.sum += centred;
                self.square += centred.component_mul(&centred);
                self.rates += 1;
            }
            Reading::Unusable => self.clipped = true,
            Reading::Missing => {}
        }
        self.force.add(force, second_half);
        self.field.add(field, second_half);
        self.samples += 1;
        if self.samples < self.samples_per_second {
            return None;
        }
        let rest = self.judge(limits);
        self.start_second();
        Some(rest)
    }

    fn start_second(&mut self) {
        *self = Self { samples_per_second: self.samples_per_second, ..Self::zero() };
    }

    fn judge(&self, limits: &RestLimits) -> Option<Rest> {
        // At least half of the second must be read.
        if self.clipped || self.rates < 2 || 2 * self.rates < self.samples {
            return None;
        }
        let n = f32::from(self.rates);
        let mean = self.sum / n;
        let variance = (self.square / n - mean.component_mul(&mean)) * (n / (n - 1.0));
        let rate = self.origin + mean;
        // Half the deviation limit, as a rate over one second, turns a vector by this angle between the
        // centres of the halves.
        let turn = 0.5 * limits.deviation_rad_s;
        let quiet = variance.iter().all(|v| *v < limits.deviation_rad_s * limits.deviation_rad_s);
        // No deviation on any axis is a frozen sensor, not a quiet one.
        let alive = variance.iter().any(|v| *v > 0.0);
        let bias_like = rate.amax() < limits.bias_rad_s;
        if !quiet || !alive || !bias_like || self.force.turned(turn) || self.field.turned(turn) {
            return None;
        }
        Some(Rest { rate, variance: variance.sum() / 3.0, samples: self.rates })
    }
}

#[cfg(test)]
mod tests;
