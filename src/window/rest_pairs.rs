//! Gravity carried by the gyro from one rest to the next.
//!
//! At rest specific force is gravity alone, and the body's axes stand still. With the nominal gyro's rotation R0 from the end of one rest to
//! some instant of the next, and u = R0 v there, `u2 - u1 = [u]x int R0 (dP w_raw - dc) dt`: equations over the whole turn that no
//! acceleration between the rests is in. u is the mean of both ends, which leaves an error of third order where the gyro's grows steadily.

use super::{
    Rest,
    rows::{GYRO, Rows},
};
use crate::rotation::{IDENTITY, exp_quaternion, matrix, renormalised};
use nalgebra::{Matrix3, Quaternion, Vector3, Vector4};

/// Pairs of rests that are used, the latest.
const PAIRS: usize = 12;
/// As many more may come while these are used: within the seconds that a result takes no more than two have a rest and a turn each.
const SPARE: usize = 2;
/// Seconds in the mean of a rest: the noise of a second is halved.
const MEAN_S: u16 = 4;
/// Longest turn, seconds: a bias that is not known better than 0.01 deg/s (`RestBias`) turns by half of the least change that a P has
/// to promise.
const LONGEST_S: u16 = 15;

/// What a pair of rests says of the gyro.
#[derive(Clone, Copy)]
pub(crate) struct RestPair {
    /// End of the first second of the second rest, microseconds.
    pub t_us: u64,
    /// Over their deviation.
    pub rows: Rows<GYRO>,
}

/// Finds pairs of rests in the increments and seconds of rest as they come. Only where no field is read, which sees the rotation itself, and
/// no effect is taken out.
pub(crate) struct RestPairs {
    /// The nominal P, row-major, of the next turn.
    p: [f32; 9],
    /// Seconds of motion since the last rest; `None`: at rest, or lost.
    moving_s: Option<u16>,
    from: RestMean,
    to: RestMean,
    turn: Turn,
    arrived: Option<Arrived>,
    kept: [RestPair; PAIRS + SPARE],
    /// Pairs since the start; the last ones are kept.
    count: u32,
}

/// Specific force at rest, body axes.
#[derive(Clone, Copy)]
struct RestMean {
    sum_m_s2: Vector3<f32>,
    /// Sum of the variances of the seconds' means.
    variance: f32,
    seconds: u16,
}

/// Integrals over a turn: of R0, and of R0 times each axis of the raw rate.
struct Turn {
    /// The nominal model: P row-major, and c that takes off what was read at the rest before.
    theta: [f32; GYRO],
    attitude: Quaternion<f32>,
    before_rad: Vector3<f32>,
    time: Matrix3<f32>,
    rates: [Matrix3<f32>; 3],
}

/// A turn that has ended in a rest whose mean is still growing.
#[derive(Clone, Copy)]
struct Arrived {
    t_us: u64,
    rotation: Matrix3<f32>,
    theta: [f32; GYRO],
    rows: [[f32; GYRO]; 3],
    /// Of the angle that the gyro's noise has added, rad^2.
    variance: f32,
}

impl RestMean {
    const NONE: Self = Self { sum_m_s2: Vector3::new(0.0, 0.0, 0.0), variance: 0.0, seconds: 0 };

    fn add(&mut self, force_m_s2: &Vector3<f32>, variance: f32) {
        self.sum_m_s2 += force_m_s2;
        self.variance += variance;
        self.seconds += 1;
    }

    fn mean_m_s2(&self) -> Vector3<f32> {
        self.sum_m_s2 / f32::from(self.seconds)
    }

    fn variance(&self) -> f32 {
        self.variance / (f32::from(self.seconds) * f32::from(self.seconds))
    }
}

impl Turn {
    const ZERO: Matrix3<f32> = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

    const fn zero() -> Self {
        Self {
            theta: [0.0; GYRO],
            attitude: Quaternion::from_vector(Vector4::new(0.0, 0.0, 0.0, 0.0)),
            before_rad: Vector3::new(0.0, 0.0, 0.0),
            time: Self::ZERO,
            rates: [Self::ZERO; 3],
        }
    }

    fn start(p: &[f32; 9], at_rest_rad_s: &Vector3<f32>) -> Self {
        let [p00, p01, p02, p10, p11, p12, p20, p21, p22] = *p;
        let c = Matrix3::new(p00, p01, p02, p10, p11, p12, p20, p21, p22) * at_rest_rad_s;
        let theta = [p00, p01, p02, p10, p11, p12, p20, p21, p22, c.x, c.y, c.z];
        Self { theta, attitude: IDENTITY, ..Self::zero() }
    }

    fn add(&mut self, raw: &Vector3<f32>, dt_s: f32) {
        let [p00, p01, p02, p10, p11, p12, p20, p21, p22, c0, c1, c2] = self.theta;
        let rate = Matrix3::new(p00, p01, p02, p10, p11, p12, p20, p21, p22) * raw - Vector3::new(c0, c1, c2);
        let angle = rate * dt_s;
        // half of the angle before the middle, and half, with the coning of the whole, after it
        let half = angle * 0.5;
        self.turn(&half);
        let middle = matrix(&self.attitude) * dt_s;
        self.time += middle;
        for (sum, rate) in self.rates.iter_mut().zip(raw.iter()) {
            *sum += middle * *rate;
        }
        self.turn(&(half + self.before_rad.cross(&angle) / 12.0));
        self.before_rad = angle;
    }

    #[inline(never)]
    fn turn(&mut self, angle_rad: &Vector3<f32>) {
        self.attitude = renormalised(&(self.attitude * exp_quaternion(angle_rad)));
    }

    /// Coefficients of P and c in what turns `u`.
    fn rows(&self, u: &Vector3<f32>) -> [[f32; GYRO]; 3] {
        let mut rows = [[0.0; GYRO]; 3];
        for (k, sum) in self.rates.iter().enumerate() {
            for (j, column) in sum.column_iter().enumerate() {
                set_column(&mut rows, 3 * j + k, &u.cross(&column));
            }
        }
        for (j, column) in self.time.column_iter().enumerate() {
            set_column(&mut rows, 9 + j, &column.cross(u));
        }
        rows
    }
}

#[inline(never)]
fn set_column(rows: &mut [[f32; GYRO]; 3], column: usize, values: &Vector3<f32>) {
    for (row, value) in rows.iter_mut().zip(values) {
        // Beyond the columns there is nothing to set; said so that no panic can be reached.
        if let Some(element) = row.get_mut(column) {
            *element = *value;
        }
    }
}

impl RestPairs {
    pub const fn zero() -> Self {
        const EMPTY: RestPair = RestPair { t_us: 0, rows: Rows::NONE };
        Self {
            p: [0.0; 9],
            moving_s: None,
            from: RestMean::NONE,
            to: RestMean::NONE,
            turn: Turn::zero(),
            arrived: None,
            kept: [EMPTY; PAIRS + SPARE],
            count: 0,
        }
    }

    /// Begins with nothing and the nominal model w = P w_raw - c.
    pub fn start(&mut self, theta: &[f32; GYRO]) {
        self.count = 0;
        self.interrupt();
        self.change_model(theta);
    }

    /// Another nominal model, from the next turn on: what is kept holds for any.
    pub fn change_model(&mut self, theta: &[f32; GYRO]) {
        let [p @ .., _, _, _] = theta;
        self.p = *p;
    }

    /// Forgets the turn in progress.
    #[inline(never)]
    pub fn interrupt(&mut self) {
        (self.moving_s, self.from, self.to, self.arrived) = (None, RestMean::NONE, RestMean::NONE, None);
    }

    /// Takes the raw rate of an increment of `dt_s` seconds; `None`: there is none, or it is not to be used.
    pub fn push(&mut self, raw: Option<&Vector3<f32>>, dt_s: f32) {
        match raw {
            _ if self.is_lost() => {}
            Some(raw) => self.turn.add(raw, dt_s),
            None => self.interrupt(),
        }
    }

    /// Whether no rest is known to carry gravity from.
    const fn is_lost(&self) -> bool {
        self.moving_s.is_none() && self.to.seconds == 0
    }

    /// Takes a second that has ended: the rest that it was, with readings of the accelerometer.
    pub fn second(&mut self, t_us: u64, rest: Option<&Rest>) {
        let read = rest.and_then(|rest| Some((rest, rest.force_m_s2?)));
        match (read, self.moving_s) {
            (None, None) if self.is_lost() => {}
            (None, None) => {
                self.keep();
                (self.from, self.to, self.moving_s) = (self.to, RestMean::NONE, Some(1));
            }
            (None, Some(seconds)) if seconds < LONGEST_S => self.moving_s = Some(seconds + 1),
            (None, Some(_)) => self.interrupt(),
            (Some((rest, force)), moving_s) => {
                if let Some(seconds) = moving_s {
                    self.arrive(t_us, rest, &force, f32::from(seconds + 1));
                } else if self.to.seconds == MEAN_S {
                    self.keep();
                    self.to = RestMean::NONE;
                }
                self.to.add(&force, rest.force_variance);
                (self.moving_s, self.turn) = (None, Turn::start(&self.p, &rest.rate));
            }
        }
    }

    fn arrive(&mut self, t_us: u64, rest: &Rest, force_m_s2: &Vector3<f32>, turn_s: f32) {
        let rotation = matrix(&self.turn.attitude);
        let u = (self.from.mean_m_s2() + rotation * force_m_s2) * 0.5;
        // The variance of a second's mean is the density of white noise.
        let variance = turn_s * rest.variance / f32::from(rest.samples);
        self.arrived = Some(Arrived { t_us, rotation, theta: self.turn.theta, rows: self.turn.rows(&u), variance });
        self.to = RestMean::NONE;
    }

    /// The rest in which a turn ended is over.
    fn keep(&mut self) {
        let Some(Arrived { t_us, rotation, theta, rows, variance }) = self.arrived.take() else { return };
        let u = self.from.mean_m_s2();
        let u2 = rotation * self.to.mean_m_s2();
        // what is along u is the norm's, which no rotation changes
        let along = (u + u2) * (u2.norm_squared() - u.norm_squared()) / (u + u2).norm_squared();
        let residual = u2 - u - along;
        let variance = self.from.variance() + self.to.variance() + variance * u.norm_squared();
        if let Some(slot) = self.kept.get_mut(self.count as usize % (PAIRS + SPARE)) {
            let weight = 1.0 / libm::sqrtf(variance);
            let rows = Rows::new(&rows.map(|row| row.map(|x| x * weight)), &(residual * weight).into(), &theta);
            *slot = RestPair { t_us, rows };
            self.count = self.count.wrapping_add(1);
        }
    }

    /// Pairs since the start.
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// The latest of the first `until` pairs; none when some of them have been overwritten.
    pub fn until(&self, until: u32) -> impl Iterator<Item = &RestPair> + Clone {
        let held = until <= self.count && self.count - until <= SPARE as u32;
        let from = if held { until.saturating_sub(PAIRS as u32) } else { until };
        (from..until).filter_map(|number| self.kept.get(number as usize % (PAIRS + SPARE)))
    }
}

#[cfg(test)]
mod tests;
