//! Samples become increments of 40 ms: what the gyro turned, and the vectors' means turned to the middle. Nothing else of them is kept.

use super::real::{Real, V3, identity, norm, rotation, rotation_vector, square, widened, zero3, zero33};
use crate::sample::Reading;
use nalgebra::Matrix3;

/// Increments a second, about: 12.5 are as good by hand, and 25 are enough for the rates of drilling.
const INCREMENTS_PER_S: f32 = 25.0;
/// Most that a probe can turn between two readings for its rotation to be known, rad.
const MOST_RAD: f32 = 1.5;
/// A longer gap is told piece by piece, seconds.
const LONGEST_GAP_S: f32 = 1.0;

/// One increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment<T> {
    /// Its last sample, microseconds.
    pub end_us: u64,
    /// Length, seconds.
    pub seconds: T,
    /// The steady raw rate that turns as far, rad/s: rotations composed sample by sample, coning included.
    pub rate: V3<T>,
    /// Mean specific force, turned to the middle of the increment, m/s^2.
    pub force: Option<V3<T>>,
    /// Mean field, turned to the middle, in the caller's units.
    pub field: Option<V3<T>>,
    /// Variance of specific force from sample to sample, per axis, (m/s^2)^2.
    pub vibration: T,
    /// Mean of the raw rates, rad/s.
    pub mean_rate: V3<T>,
    /// Variance of the raw rates, of each axis, (rad/s)^2.
    pub rate_variance: V3<T>,
}

/// What the samples of an increment come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item<T> {
    /// An increment.
    Increment(Increment<T>),
    /// A time through which nobody knows how the probe turned.
    Gap {
        /// Its length.
        seconds: T,
        /// As much of it as no sample came at all.
        silent_s: T,
    },
    /// The posterior of everything before is asked for.
    Close,
}

/// Sums of the increment in progress.
#[derive(Clone, Copy)]
pub struct Builder<T> {
    period_s: T,
    per_increment: u16,
    /// How much of the rate of the sample before goes into an interval: 0.5 between instants, 0 of means over the interval.
    held: T,
    has_begun: bool,
    rate_before: V3<T>,
    force_before: Option<V3<T>>,
    field_before: Option<V3<T>>,
    /// Since the last usable rate.
    waiting_s: T,
    /// Of it, and of what is lost, without any sample.
    silent_s: T,
    is_lost: bool,
    samples: u16,
    seconds: T,
    bias: V3<T>,
    rotation: Matrix3<T>,
    force: V3<T>,
    forces: u16,
    field: V3<T>,
    fields: u16,
    steps: T,
    pairs: u16,
    rates: V3<T>,
    squares: V3<T>,
}

impl<T: Real> Builder<T> {
    /// Before the first sample.
    pub const fn zero() -> Self {
        Self {
            period_s: T::ZERO,
            per_increment: 0,
            held: T::ZERO,
            has_begun: false,
            rate_before: zero3(),
            force_before: None,
            field_before: None,
            waiting_s: T::ZERO,
            silent_s: T::ZERO,
            is_lost: false,
            samples: 0,
            seconds: T::ZERO,
            bias: zero3(),
            rotation: zero33(),
            force: zero3(),
            forces: 0,
            field: zero3(),
            fields: 0,
            steps: T::ZERO,
            pairs: 0,
            rates: zero3(),
            squares: zero3(),
        }
    }

    /// Begins anew. `is_instant`: readings are of an instant, not means over the interval that they end.
    pub fn start(&mut self, sample_period_s: f32, is_instant: bool) {
        let samples = libm::roundf(1.0 / (INCREMENTS_PER_S * sample_period_s));
        *self = Self {
            period_s: T::of(sample_period_s),
            per_increment: if samples > 1.0 { samples as u16 } else { 1 },
            held: if is_instant { T::of(0.5) } else { T::ZERO },
            ..Self::zero()
        };
    }

    /// Nominal length of an increment, seconds.
    pub fn seconds(&self) -> T {
        self.period_s * T::of(f32::from(self.per_increment))
    }

    /// Takes a sample, `step_s` after the one before; `bias` is the raw bias about which rotations are composed.
    pub fn push(
        &mut self,
        (t_us, step_s): (u64, f32),
        bias: &V3<T>,
        [rate, force, field]: [Reading; 3],
    ) -> Option<Item<T>> {
        let good = |reading| if let Reading::Good(v) = reading { Some(widened::<T>(&v)) } else { None };
        let (force, field) = (good(force), good(field));
        let step_s = T::of(step_s);
        let longest = self.period_s * T::of(3.0);
        let interval_s = self.waiting_s + step_s;
        if step_s > longest {
            self.silent_s += step_s;
        }
        // What turns by more from one reading to the next is no rotation that they show.
        let shown = |rate: &V3<T>| norm(rate) * self.period_s < T::of(MOST_RAD);
        let Some(rate) = good(rate).filter(shown) else {
            self.waiting_s = interval_s;
            if interval_s < T::of(LONGEST_GAP_S) {
                self.is_lost |= interval_s > longest;
                return None;
            }
            return Some(self.gap(bias));
        };
        self.waiting_s = T::ZERO;
        let before = (self.rate_before, self.force_before, self.field_before);
        (self.rate_before, self.force_before, self.field_before) = (rate, force, field);
        if !self.has_begun {
            (self.has_begun, self.is_lost, self.silent_s) = (true, false, T::ZERO);
            self.begin(bias);
            return None;
        }
        if self.is_lost || interval_s > longest {
            self.waiting_s = interval_s;
            let gap = self.gap(bias);
            self.is_lost = false;
            return Some(gap);
        }
        self.add(interval_s, [before.0, rate], [before.1, force], [before.2, field]);
        if self.samples < self.per_increment {
            return None;
        }
        let increment = self.end(t_us);
        self.begin(bias);
        Some(Item::Increment(increment))
    }

    /// What was gathered, and waited for, is a gap.
    fn gap(&mut self, bias: &V3<T>) -> Item<T> {
        let lost_s = self.seconds + self.waiting_s;
        self.waiting_s = T::ZERO;
        self.is_lost = true;
        self.begin(bias);
        Item::Gap { seconds: lost_s, silent_s: core::mem::replace(&mut self.silent_s, T::ZERO) }
    }

    fn begin(&mut self, bias: &V3<T>) {
        self.samples = 0;
        self.seconds = T::ZERO;
        self.bias = *bias;
        self.rotation = identity();
        (self.force, self.forces, self.field, self.fields) = (zero3(), 0, zero3(), 0);
        (self.steps, self.pairs) = (T::ZERO, 0);
        (self.rates, self.squares) = (zero3(), zero3());
    }

    /// An interval between two samples.
    fn add(&mut self, seconds: T, rates: [V3<T>; 2], forces: [Option<V3<T>>; 2], fields: [Option<V3<T>>; 2]) {
        let [before, now] = rates;
        let centred = now + (before - now) * self.held - self.bias;
        let half = rotation(&(centred * (seconds * T::of(0.5))));
        let middle = self.rotation * half;
        let end = middle * half;
        // Of a sensor that is read less often than the gyro each reading stands where it was read.
        let turned = |pair: [Option<V3<T>>; 2]| match pair {
            [Some(before), Some(now)] => Some(middle * ((before + now) * T::of(0.5))),
            [None, Some(now)] => Some(end * now),
            [_, None] => None,
        };
        if let Some(force) = turned(forces) {
            self.force += force;
            self.forces += 1;
        }
        if let [Some(before), Some(now)] = forces {
            self.steps += square(&(now - before));
            self.pairs += 1;
        }
        if let Some(field) = turned(fields) {
            self.field += field;
            self.fields += 1;
        }
        self.rotation = end;
        self.rates += centred;
        self.squares += centred.component_mul(&centred);
        self.samples += 1;
        self.seconds += seconds;
    }

    fn end(&self, end_us: u64) -> Increment<T> {
        let turned = rotation_vector(&self.rotation);
        let back = rotation(&(turned * T::of(-0.5)));
        let mean = |sum: &V3<T>, count: u16| (count > 0).then(|| back * (sum / T::of(f32::from(count))));
        let n = T::of(f32::from(self.samples));
        let rates = self.rates / n;
        Increment {
            end_us,
            seconds: self.seconds,
            rate: turned / self.seconds + self.bias,
            force: mean(&self.force, self.forces),
            field: mean(&self.field, self.fields),
            // The difference of two samples has twice the variance, and there are three axes.
            vibration: if self.pairs > 0 { self.steps / T::of(6.0 * f32::from(self.pairs)) } else { T::ZERO },
            mean_rate: rates + self.bias,
            rate_variance: self.squares / n - rates.component_mul(&rates),
        }
    }
}
