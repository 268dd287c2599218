//! Increments of 40 ms, made of samples: the rotation by the gyro, and the vectors' means turned to the middle. The
//! samples themselves are not stored.

use super::real::{M3, Real, V3, identity, norm, rotation, rotation_vector, square, widened, zero3, zero33};
use crate::{
    change::{Change, FORCE_M_S3, RATE_RAD_S2},
    compensation::GyroModel,
    sample::Reading,
    time_step::GAP_PERIODS,
};
use nalgebra::Matrix3;

/// Number of increments in a second, rounded to whole samples. By hand 12.5 are as good; the rates of drilling need 25.
const INCREMENTS_PER_S: f32 = 25.0;
/// Most that a probe can turn between two readings for its rotation to be known, rad.
const MOST_RAD: f32 = 1.5;
/// Angle from which on an increment ends early, rad: if the true scale is off by d from that of the P that composes it,
/// the angles across the axis of rotation are off by d angle^2 / 6.
const LONGEST_TURN_RAD: f32 = 0.5;
/// Deviation of the turn in lost samples, rad, from which on it is not bridged: its square is then a hundredth, as much
/// as a linear model of the turn may leave out.
const MOST_BRIDGED_RAD: f32 = 0.1;
/// Time without samples from which on a clock that stepped is as likely, s: ten periods at 100 Hz, after which a part
/// that is silent is started anew. No sample was lost then, and the turn is not what it seems but none.
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

/// Piece of work that waits for its turn: an increment, a gap, or a question at an instant.
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
    /// Question for the posterior of everything before.
    Close {
        /// True if a search about the posterior is to follow.
        is_searched: bool,
    },
}

/// The gyro model that rotations are composed with.
#[derive(Clone, Copy)]
pub struct Composition<T> {
    p: M3<T>,
    inverse: M3<T>,
    bias: V3<T>,
}

impl<T: Real> Composition<T> {
    pub const fn zero() -> Self {
        Self { p: zero33(), inverse: zero33(), bias: zero3() }
    }

    /// `None` where P has no inverse.
    pub fn new(model: &GyroModel) -> Option<Self> {
        let p = model.p_matrix();
        let inverse = p.try_inverse()?;
        let wide = |m: &nalgebra::Matrix3<f32>| M3::from_fn(|i, j| m.get((i, j)).map_or(T::ZERO, |x| T::of(*x)));
        Some(Self { p: wide(&p), inverse: wide(&inverse), bias: widened(&V3::from(model.b_rad_s)) })
    }
}

/// Sums of the increment in progress.
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
    samples: u16,
    seconds: T,
    turned: T,
    with: Composition<T>,
    rotation: Matrix3<T>,
    force: V3<T>,
    forces: u16,
    field: V3<T>,
    fields: u16,
    steps: T,
    pairs: u16,
    rates: V3<T>,
    squares: V3<T>,
    square_force: T,
    square_peak: T,
    unread_turn: T,
    unread_velocity: T,
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
            samples: 0,
            seconds: T::ZERO,
            turned: T::ZERO,
            with: Composition::zero(),
            rotation: zero33(),
            force: zero3(),
            forces: 0,
            field: zero3(),
            fields: 0,
            steps: T::ZERO,
            pairs: 0,
            rates: zero3(),
            squares: zero3(),
            square_force: T::ZERO,
            square_peak: T::ZERO,
            unread_turn: T::ZERO,
            unread_velocity: T::ZERO,
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
        let (force, field) = (good(force), good(field));
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
        let force_before = core::mem::replace(&mut self.force_before, force);
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
            self.begin(with);
            return None;
        }
        let ends = rate_before.filter(|_| !is_whole).map(|before| [before, rate]);
        let is_bridged = ends.is_some_and(|ends| self.bridge(unread_s, &ends, [force_before, force]));
        if !is_bridged && (self.is_lost || interval_s > longest) {
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
            self.add(interval_s, &rate, [force_before, force], field);
        }
        if self.samples < self.per_increment && self.turned < T::of(LONGEST_TURN_RAD) {
            return None;
        }
        let increment = self.end(t_us);
        self.begin(with);
        Some(Item::Increment(increment))
    }

    /// Bridges lost samples with the mean of the readings on either side. Returns `false`, and does nothing, if the
    /// turn would be too uncertain.
    fn bridge(&mut self, seconds: T, [before, after]: &[V3<T>; 2], forces: [Option<V3<T>>; 2]) -> bool {
        let narrow = |v: &V3<T>| v.map(|x| x.narrow());
        let readings = libm::roundf((seconds / self.period_s).narrow());
        let count = T::of(readings);
        let centred = (before + after) * T::of(0.5) - self.with.bias;
        let turn = self.with.p * centred * seconds;
        let by_change = T::of(self.rate_change.unread_variance(&narrow(before), &narrow(after), seconds.narrow()));
        let is_long = readings > libm::roundf(LONGEST_LOSS_S / self.period_s.narrow());
        let unread_turn = by_change + if is_long { square(&turn) } else { T::ZERO };
        // A NaN is not bridged.
        let is_known = unread_turn < T::of(MOST_BRIDGED_RAD * MOST_BRIDGED_RAD);
        if !is_known {
            return false;
        }
        let half = rotation(&(turn * T::of(0.5)));
        let middle = self.rotation * half;
        if let [Some(before), Some(after)] = &forces {
            self.force += middle * (before + after) * (count * T::of(0.5));
            self.forces = self.forces.saturating_add(readings as u16);
            let unread = self.force_change.unread_variance(&narrow(before), &narrow(after), seconds.narrow());
            self.unread_velocity += T::of(unread);
        }
        self.rotation = middle * half;
        self.turn_before = self.with.p * (after - self.with.bias) * self.period_s;
        self.rates += centred * count;
        self.squares += centred.component_mul(&centred) * count;
        self.samples = self.samples.saturating_add(readings as u16);
        self.seconds += seconds;
        self.turned += norm(&turn);
        self.unread_turn += unread_turn;
        true
    }

    /// Makes a gap of the increment in progress and of the time since the last usable rate.
    fn gap(&mut self, with: &Composition<T>) -> Item<T> {
        let lost_s = self.seconds + self.waiting_s;
        self.waiting_s = T::ZERO;
        self.is_lost = true;
        self.rate_before = None;
        self.begin(with);
        Item::Gap { seconds: lost_s, silent_s: core::mem::replace(&mut self.silent_s, T::ZERO) }
    }

    fn begin(&mut self, with: &Composition<T>) {
        self.samples = 0;
        (self.seconds, self.turned) = (T::ZERO, T::ZERO);
        self.with = *with;
        self.rotation = identity();
        (self.force, self.forces, self.field, self.fields) = (zero3(), 0, zero3(), 0);
        (self.steps, self.pairs) = (T::ZERO, 0);
        (self.rates, self.squares) = (zero3(), zero3());
        (self.square_force, self.square_peak) = (T::ZERO, T::ZERO);
        (self.unread_turn, self.unread_velocity) = (T::ZERO, T::ZERO);
    }

    /// Sets the temperature of the samples to come, over the effects' reference temperature, K.
    pub fn warm(&mut self, warming_k: Option<f32>) {
        self.warming_k = warming_k.map(T::of);
    }

    /// Adds the interval between two samples.
    fn add(&mut self, seconds: T, rate: &V3<T>, [force_before, force]: [Option<V3<T>>; 2], field: Option<V3<T>>) {
        let centred = rate - self.with.bias;
        let turn = self.with.p * centred * seconds;
        // The mean rate of an interval through which the axis itself turns is not yet its rotation: Bortz, to second
        // order.
        let coning = self.turn_before.cross(&turn) * T::of(1.0 / 12.0);
        self.turn_before = turn;
        let whole = turn + coning;
        let (at, end) = if self.is_instant {
            let half = rotation(&(whole * T::of(0.5)));
            let middle = self.rotation * half;
            (middle, middle * half)
        } else {
            let end = self.rotation * rotation(&whole);
            (end, end)
        };
        // A sensor's reading is a mean as the gyro's is, over a sample period: what turns through it is shorter by
        // angle^2 / 24 across the axis.
        let turned = |read: &V3<T>| at * (read - turn.cross(&turn.cross(read)) * T::of(1.0 / 24.0));
        if let Some(force) = force {
            self.force += turned(&force);
            self.forces += 1;
            if let Some(before) = force_before {
                self.steps += square(&(force - before));
                self.pairs += 1;
            }
            let square = square(&force);
            self.square_force += square;
            self.square_peak = if square > self.square_peak { square } else { self.square_peak };
        }
        if let Some(field) = field {
            self.field += turned(&field);
            self.fields += 1;
        }
        self.rotation = end;
        self.rates += centred;
        self.squares += centred.component_mul(&centred);
        self.samples += 1;
        self.seconds += seconds;
        self.turned += norm(&turn);
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
            rate: self.with.inverse * turned / self.seconds + self.with.bias,
            force: mean(&self.force, self.forces),
            field: mean(&self.field, self.fields),
            // The difference of two samples has twice the variance, and there are three axes.
            vibration: if self.pairs > 0 { self.steps / T::of(6.0 * f32::from(self.pairs)) } else { T::ZERO },
            mean_rate: rates + self.with.bias,
            rate_variance: self.squares / n - rates.component_mul(&rates),
            square_force: if self.forces > 0 { self.square_force / T::of(f32::from(self.forces)) } else { T::ZERO },
            peak: self.square_peak.root(),
            warming_k: self.warming_k,
            unread_turn: self.unread_turn,
            unread_velocity: self.unread_velocity,
        }
    }
}
