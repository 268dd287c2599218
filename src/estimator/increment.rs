//! Increments of 40 ms, made of samples: the rotation by the gyro, and the vectors' means turned to the middle. The
//! samples themselves are not stored.

mod sums;

pub use sums::Composition;

use super::real::{Real, V3, norm, rotation, square, widened, zero3};
use crate::{
    change::{Change, FORCE_M_S3, RATE_RAD_S2},
    sample::Reading,
    time_step::GAP_PERIODS,
};
use sums::Sums;

/// Number of increments in a second, rounded to whole samples. By hand 12.5 are as good; the rates of drilling need 25.
const INCREMENTS_PER_S: f32 = 25.0;
/// Most that a probe can turn between two readings for its rotation to be known, rad.
const MOST_RAD: f32 = 1.5;
/// Turn at which an increment ends early, rad. An error d of the gyro's scale makes its angles across the axis of
/// rotation wrong by d turn^2 / 6.
const LONGEST_TURN_RAD: f32 = 0.5;
/// Deviation of the turn in lost samples, rad, from which on it is not bridged: its square is then a hundredth, as much
/// as a linear model of the turn may leave out.
const MOST_BRIDGED_RAD: f32 = 0.1;
/// Turn of an increment with lost samples, rad, from which on these are a gap: a little less than half a turn.
const MOST_TURNED_RAD: f32 = 3.0;
/// Time without samples, s, beyond which the clock may as well have stepped, and the probe not have turned: ten periods
/// at 100 Hz, after which a silent part is started anew.
const LONGEST_LOSS_S: f32 = 0.1;
/// Longest gap in one item, seconds; a longer gap becomes several items.
const LONGEST_GAP_S: f32 = 1.0;

/// One increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment<T> {
    /// Time of the last sample, microseconds.
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
    /// Mean square of specific force, sample by sample, (m/s^2)^2, and its largest size, m/s^2.
    pub square_force: T,
    pub peak: T,
    /// Temperature over the effects' reference temperature, K.
    pub warming_k: Option<T>,
    /// Variances, of each axis, by lost samples: of the turn, rad^2, and of the velocity gained, (m/s)^2.
    pub unread_turn: T,
    pub unread_velocity: T,
}

/// Piece of work that waits for its turn: an increment, a gap, or a question or news at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item<T> {
    /// An increment.
    Increment(Increment<T>),
    /// Time in which the rotation of the probe is unknown.
    Gap {
        /// Length, seconds.
        seconds: T,
        /// Part of the length in which no sample came at all, seconds.
        silent_s: T,
    },
    /// Question for the attitude at the end of the increment before.
    Look,
    /// The probe's own hard iron is another from about here on.
    IronChanged,
    /// Question for the posterior of everything before.
    Close {
        /// True if a search about the posterior is to follow.
        is_searched: bool,
        /// Number of the request, which begins again after 255.
        number: u8,
    },
}

/// Maker of increments.
#[derive(Clone, Copy)]
pub struct Builder<T> {
    period_s: T,
    per_increment: u16,
    /// True if a rate stands for the interval about its time; else it stands for the one that ends with it.
    is_instant: bool,
    /// Angle of the interval before, rad.
    turn_before: V3<T>,
    has_begun: bool,
    /// The last usable readings; no rate after an unusable one.
    rate_before: Option<V3<T>>,
    force_before: Option<V3<T>>,
    rate_change: Change,
    force_change: Change,
    /// Seconds since the last usable rate.
    waiting_s: T,
    /// Part of the waiting and of the lost time without any sample, seconds.
    silent_s: T,
    is_lost: bool,
    /// The increment in progress.
    sums: Sums<T>,
    warming_k: Option<T>,
}

impl<T: Real> Builder<T> {
    /// Before the first sample.
    pub const fn zero() -> Self {
        Self {
            period_s: T::ZERO,
            per_increment: 0,
            is_instant: false,
            turn_before: zero3(),
            has_begun: false,
            rate_before: None,
            force_before: None,
            rate_change: Change::ZERO,
            force_change: Change::ZERO,
            waiting_s: T::ZERO,
            silent_s: T::ZERO,
            is_lost: false,
            sums: Sums::zero(),
            warming_k: None,
        }
    }

    /// Begins anew. `is_instant`: readings are of an instant, not means over the interval that they end.
    pub fn start(&mut self, sample_period_s: f32, is_instant: bool) {
        let samples = libm::roundf(1.0 / (INCREMENTS_PER_S * sample_period_s));
        *self = Self {
            period_s: T::of(sample_period_s),
            per_increment: if samples > 1.0 { samples as u16 } else { 1 },
            is_instant,
            rate_change: Change::of_at_least(RATE_RAD_S2),
            force_change: Change::of_at_least(FORCE_M_S3),
            ..Self::zero()
        };
    }

    /// Nominal length of an increment, seconds.
    pub fn seconds(&self) -> T {
        self.period_s * T::of(f32::from(self.per_increment))
    }

    /// Takes a sample, `step_s` after the one before; `with` is what rotations are composed with.
    pub fn push(
        &mut self,
        (t_us, step_s): (u64, f32),
        with: &Composition<T>,
        [rate, force, field]: [Reading; 3],
    ) -> Option<Item<T>> {
        let good = |reading| if let Reading::Usable(v) = reading { Some(widened::<T>(&v)) } else { None };
        let is_clipped = matches!(force, Reading::Unusable);
        if is_clipped {
            self.sums.lose_force(self.period_s);
        }
        let (force, field) = (good(force), good(field));
        if let Some(force) = &force {
            self.sums.note_peak(force);
        }
        let step_s = T::of(step_s);
        let longest = self.period_s * T::of(GAP_PERIODS as f32);
        let interval_s = self.waiting_s + step_s;
        if step_s > longest {
            self.silent_s += step_s;
        }
        // A rate that turns the probe by more than this in a sample period does not show its rotation.
        let most = T::of(MOST_RAD) / self.period_s;
        let shown = |rate: &V3<T>| square(rate) < most * most;
        let is_missing = matches!(rate, Reading::Missing);
        let Some(rate) = good(rate).filter(shown) else {
            self.waiting_s = interval_s;
            if !is_missing {
                // The true value behind a clipped reading lies beyond its neighbours.
                self.rate_before = None;
            }
            if interval_s < T::of(LONGEST_GAP_S) {
                self.is_lost |= interval_s > longest;
                return None;
            }
            return Some(self.gap(with));
        };
        self.waiting_s = T::ZERO;
        let force_before = self.force_before;
        // An accelerometer may be slower than the samples.
        if force.is_some() || is_clipped {
            self.force_before = force;
        }
        let rate_before = self.rate_before.replace(rate);
        let unread_s = interval_s - self.period_s;
        let is_whole = unread_s < self.period_s * T::of(0.5);
        if !is_whole {
            self.rate_change.interrupt();
            self.force_change.interrupt();
        }
        let step_s = self.period_s.narrow();
        self.rate_change.update(&rate.map(|x| x.narrow()), step_s);
        if let Some(force) = &force {
            self.force_change.update(&force.map(|x| x.narrow()), step_s);
        }
        if !self.has_begun {
            (self.has_begun, self.is_lost, self.silent_s) = (true, false, T::ZERO);
            self.sums = Sums::begun(with);
            return None;
        }
        let ends = rate_before.filter(|_| !is_whole).map(|before| [before, rate]);
        let is_bridged = ends.is_some_and(|ends| self.bridge(unread_s, &ends, [force_before, force]));
        let [_, turn] = self.sums.turn(&rate, interval_s);
        let is_half_a_turn = self.sums.turned + norm(&turn) >= T::of(MOST_TURNED_RAD);
        if !is_bridged && (self.is_lost || interval_s > longest || is_half_a_turn) {
            self.waiting_s = interval_s;
            let gap = self.gap(with);
            self.is_lost = false;
            self.rate_before = Some(rate);
            return Some(gap);
        }
        if is_bridged {
            (self.is_lost, self.silent_s) = (false, T::ZERO);
            self.add(self.period_s, &rate, [None, force], field);
        } else {
            if !is_whole {
                // This rate is held for one that was not read, and is as uncertain as it is large: a clipped one was
                // larger.
                let [_, turn] = self.sums.turn(&rate, unread_s);
                self.sums.unread_turn += square(&turn);
            }
            self.add(interval_s, &rate, [force_before, force], field);
        }
        if self.sums.samples < self.per_increment && self.sums.turned < T::of(LONGEST_TURN_RAD) {
            return None;
        }
        let increment = self.sums.end(t_us, self.warming_k);
        self.sums = Sums::begun(with);
        Some(Item::Increment(increment))
    }

    /// Bridges lost samples with the mean of the readings on either side. Returns `false`, and does nothing, if the
    /// turn would be too uncertain.
    fn bridge(&mut self, seconds: T, [before, after]: &[V3<T>; 2], forces: [Option<V3<T>>; 2]) -> bool {
        let narrow = |v: &V3<T>| v.map(|x| x.narrow());
        let readings = libm::roundf((seconds / self.period_s).narrow());
        let count = T::of(readings);
        let [centred, turn] = self.sums.turn(&((before + after) * T::of(0.5)), seconds);
        let by_change = T::of(self.rate_change.unread_variance(&narrow(before), &narrow(after), seconds.narrow()));
        let is_long = readings > libm::roundf(LONGEST_LOSS_S / self.period_s.narrow());
        let unread_turn = by_change + if is_long { square(&turn) } else { T::ZERO };
        let [_, own] = self.sums.turn(after, self.period_s);
        // A NaN is not bridged. Beyond half a turn an increment's rotation would be taken for the shorter one.
        let is_known = unread_turn < T::of(MOST_BRIDGED_RAD * MOST_BRIDGED_RAD)
            && self.sums.turned + norm(&turn) + norm(&own) < T::of(MOST_TURNED_RAD);
        if !is_known {
            return false;
        }
        let sums = &mut self.sums;
        let half = rotation(&(turn * T::of(0.5)));
        let middle = sums.rotation * half;
        if let [Some(before), Some(after)] = &forces {
            sums.force += middle * (before + after) * (count * T::of(0.5));
            sums.forces = sums.forces.saturating_add(readings as u16);
            let unread = self.force_change.unread_variance(&narrow(before), &narrow(after), seconds.narrow());
            sums.unread_velocity += T::of(unread);
        }
        sums.rotation = middle * half;
        sums.rates += centred * count;
        sums.squares += centred.component_mul(&centred) * count;
        sums.samples = sums.samples.saturating_add(readings as u16);
        sums.seconds += seconds;
        sums.turned += norm(&turn);
        sums.unread_turn += unread_turn;
        self.turn_before = own;
        true
    }

    /// Makes a gap of the increment in progress and of the time since the last usable rate.
    fn gap(&mut self, with: &Composition<T>) -> Item<T> {
        let lost_s = self.sums.seconds + self.waiting_s;
        self.waiting_s = T::ZERO;
        self.is_lost = true;
        self.rate_before = None;
        self.sums.begin_after_gap(with);
        Item::Gap { seconds: lost_s, silent_s: core::mem::replace(&mut self.silent_s, T::ZERO) }
    }

    /// Sets the temperature of the samples to come, over the effects' reference temperature, K. Without a new reading
    /// the latest one holds, as it does for the effects that fly.
    pub fn warm(&mut self, warming_k: Option<f32>) {
        if let Some(kelvins) = warming_k {
            self.warming_k = Some(T::of(kelvins));
        }
    }

    /// Adds the interval between two samples.
    fn add(&mut self, seconds: T, rate: &V3<T>, forces: [Option<V3<T>>; 2], field: Option<V3<T>>) {
        let [centred, turn] = self.sums.turn(rate, seconds);
        // The mean rate of an interval through which the axis itself turns is not yet its rotation: Bortz, to second
        // order.
        let coning = self.turn_before.cross(&turn) * T::of(1.0 / 12.0);
        self.turn_before = turn;
        let at = self.sums.go_on(&(turn + coning), self.is_instant);
        self.sums.add(seconds, [&centred, &turn], &at, forces, field);
    }
}

#[cfg(test)]
mod tests;
