//! Rest, as the estimator judges it: nodes in succession that are quiet and read the same, and whose vectors have not
//! turned since the quiet began. The attitude filter has its own, `attitude/rest.rs`.

use super::{
    preintegration::{Preintegration, largest, squared_angle},
    real::{Real, V3, norm, square, zero3},
    rows::REST_WEIGHT,
    settings::Settings,
};
use crate::compensation::Snapshot;
use nalgebra::Vector3;

/// Shortest node that can be half of a rest, seconds.
const LEAST_S: f32 = 0.4;
/// Square of the deviations by which two means have to differ to count as changed: five, once in 20,000 by chance where
/// the scatter of two dozen increments gives the deviation (Student's t).
const CHANGED: f32 = 25.0;
/// Largest deviation of the specific force at rest, m/s^2 (VQF's default; Laidig and Seel, Information Fusion 91,
/// 2023).
const QUIET_M_S2: f32 = 0.5;

/// Readings of a node; a vector without readings is zero.
#[derive(Clone, Copy)]
struct Half<T> {
    rate: V3<T>,
    /// Variance of the rate, and of its mean, on each axis.
    variance: V3<T>,
    mean_variance: V3<T>,
    force: Direction<T>,
    field: Direction<T>,
}

/// Mean of a vector, of any length, and the variance of its direction about an axis, rad^2.
#[derive(Clone, Copy)]
struct Direction<T> {
    mean: V3<T>,
    variance: T,
}

impl<T: Real> Direction<T> {
    fn has_turned(&self, since: &Self, allowed: T) -> bool {
        let are_read = square(&self.mean) > T::ZERO && square(&since.mean) > T::ZERO;
        let angle = if are_read { squared_angle(&self.mean, &since.mean) } else { T::ZERO };
        angle > allowed && angle > T::of(CHANGED) * (self.variance + since.variance)
    }
}

impl<T: Real> Half<T> {
    fn of(pre: &Preintegration<T>, settings: &Settings) -> Self {
        let (variance, rate) = pre.rate_statistics();
        let noise = &settings.noise;
        let over = |variance: T, vector: &V3<T>| {
            let square = square(vector);
            if square > T::ZERO { variance / square } else { T::ZERO }
        };
        let fields = T::of(f32::from(pre.fields));
        let own = T::of(noise.field_share * noise.field_at_rest);
        let of_field = own * own + over(pre.field_variance() * fields * fields, &pre.fields_read);
        let increment = T::of(noise.velocity_increment_m_s);
        let read = pre.mean_vibration() * T::of(settings.sample_period_s) * pre.seconds;
        let fallen = T::of(settings.gravity_m_s2) * pre.seconds;
        let of_force = (increment * increment + read) / (fallen * fallen);
        Self {
            rate,
            variance,
            mean_variance: pre.rate_variance_of_mean(),
            force: Direction { mean: pre.forces_read, variance: of_force },
            field: Direction { mean: pre.fields_read, variance: of_field },
        }
    }

    /// Returns true if force or field points elsewhere, by a squared angle of more than is allowed, rad^2.
    fn has_turned(&self, since: &Self, allowed: T) -> bool {
        self.force.has_turned(&since.force, allowed) || self.field.has_turned(&since.field, allowed)
    }

    /// Returns true if a turn by this angle, rad, would have turned force or field about whatever axis. A turn about
    /// the middle between both turns them least: by its angle times the sine of half the angle between them.
    fn would_show(&self, since: &Self, angle: T) -> bool {
        let across = self.force.mean.cross(&self.field.mean);
        let least = angle * angle * square(&across) * T::of(0.25);
        let variance = [self, since].iter().fold(T::ZERO, |sum, half| sum + half.force.variance + half.field.variance);
        least > T::of(CHANGED) * variance * square(&self.force.mean) * square(&self.field.mean)
    }

    /// Returns true if the mean rate is another one, by more than the rows of a rest allow for.
    fn has_changed(&self, since: &Self) -> bool {
        let change = self.rate - since.rate;
        let chance = (self.mean_variance + since.mean_variance) * T::of(CHANGED);
        let least = T::ONE / T::of(REST_WEIGHT * REST_WEIGHT);
        change.iter().zip(chance.iter()).any(|(change, chance)| *change * *change > *chance + least)
    }
}

/// Judge of rests, with the node before as half of a rest.
#[derive(Clone, Copy)]
pub(super) struct Rests<T> {
    before: Option<Half<T>>,
    /// The first of the quiet nodes, seconds since, and the seconds that have to go by without a turn: as many as
    /// the latest turn needed to be seen.
    first: Option<Half<T>>,
    first_s: T,
    doubted_s: T,
    /// Mean raw rate of these two nodes, rad/s.
    pub rate: V3<T>,
    /// Specific force, m/s^2, its mean square, m^2/s^4, and temperature over the effects' reference temperature, K, of
    /// the latest rest.
    pub force_m_s2: Vector3<f32>,
    pub square_force_m2_s4: f32,
    pub warming_k: f32,
    /// When the latest rest ended, microseconds; 0: there was none.
    pub latest_us: u64,
    /// The latest 64 seconds, one bit each, the newest lowest: 1 for rest. And what there is of the second in progress.
    history: u64,
    second_s: T,
    rest_s: T,
}

impl<T: Real> Rests<T> {
    pub const fn zero() -> Self {
        Self {
            before: None,
            first: None,
            first_s: T::ZERO,
            doubted_s: T::ZERO,
            rate: zero3(),
            force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            square_force_m2_s4: 0.0,
            warming_k: 0.0,
            latest_us: 0,
            history: 0,
            second_s: T::ZERO,
            rest_s: T::ZERO,
        }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Forgets the node before: the next one does not follow it.
    pub fn interrupt(&mut self) {
        (self.before, self.first, self.first_s) = (None, None, T::ZERO);
    }

    /// Returns the number of the last `seconds` (at most 64) that were at rest.
    pub fn seconds(&self, seconds: u32) -> u32 {
        let mask = if seconds >= 64 { u64::MAX } else { (1 << seconds) - 1 };
        (self.history & mask).count_ones()
    }

    /// Readings of the latest rest, without field: nothing of it is in a rate at rest.
    pub fn read(&self) -> Snapshot {
        Snapshot { force_m_s2: self.force_m_s2, ..self.still() }
    }

    /// Readings of the latest rest that are those of the next one, too, whichever way the probe then points: force and
    /// field are zero, for what goes with them turns with the probe and is no bias.
    pub fn still(&self) -> Snapshot {
        Snapshot {
            rate_rad_s: Vector3::zeros(),
            acceleration_rad_s2: Vector3::zeros(),
            force_m_s2: Vector3::zeros(),
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: Vector3::zeros(),
            warming_k: self.warming_k,
        }
    }

    /// Returns true if the node that ends, and the one before it, were at rest.
    pub fn judge(&mut self, pre: &Preintegration<T>, settings: &Settings) -> bool {
        let is_rest = self.is_rest(pre, settings);
        if is_rest {
            self.rest_s += pre.seconds;
            self.latest_us = pre.end_us;
        }
        self.pass(pre.seconds);
        is_rest
    }

    /// Lets seconds pass, of a node or a gap.
    pub fn pass(&mut self, seconds: T) {
        self.second_s += seconds;
        // A node may be shorter or longer than half a second. After 64 s of a gap nothing of the history is left.
        for _ in 0..u64::BITS {
            if self.second_s < T::ONE {
                return;
            }
            self.history = self.history << 1 | u64::from(self.rest_s + self.rest_s > self.second_s);
            self.second_s -= T::ONE;
            self.rest_s = T::ZERO;
        }
        self.second_s = T::ZERO;
    }

    fn is_rest(&mut self, pre: &Preintegration<T>, settings: &Settings) -> bool {
        let limit = T::of(settings.rest_deviation_rad_s);
        let half = Half::of(pre, settings);
        let is_quiet = pre.seconds >= T::of(LEAST_S)
            && largest(&half.variance) < limit * limit
            && pre.mean_vibration() < T::of(QUIET_M_S2 * QUIET_M_S2);
        if !is_quiet {
            self.interrupt();
            self.doubted_s = T::ZERO;
            return false;
        }
        let Some(before) = self.before.replace(half) else { return false };
        self.rate = (before.rate + half.rate) * T::of(0.5);
        let first = *self.first.get_or_insert(before);
        self.first_s += pre.seconds;
        if half.has_turned(&first, T::ZERO) {
            // The probe turns too slowly for two successive nodes to show it. A turn within three times the variance of
            // what the bias walks through in that time, w^2 t^3 / 3, is taken for the field's: it does no harm.
            let walk = T::of(settings.noise.bias_walk_rad_s_rts) * self.first_s;
            let is_of_probe = half.has_turned(&first, walk * walk * self.first_s);
            self.doubted_s = if is_of_probe { self.first_s } else { T::ZERO };
            (self.first, self.first_s) = (Some(half), T::ZERO);
            return false;
        }
        let is_believed = self.first_s >= self.doubted_s;
        // A data sheet bounds each axis by itself.
        let largest = self.rate.iter().fold(T::ZERO, |most, x| if *x * *x > most { *x * *x } else { most });
        let is_usual = largest < T::of(settings.most_bias_rad_s * settings.most_bias_rad_s);
        let is_bias = is_usual || half.would_show(&first, norm(&self.rate) * self.first_s);
        is_believed && is_bias && !half.has_changed(&before)
    }
}
