//! Check of how the sensors are mounted: whether they agree on a turn about each axis of the probe.

use crate::sample::{Sample, SampleFlags};
use nalgebra::{Matrix3, Vector3};

/// Time over which readings are averaged: short against a turn by hand, long against noise, seconds.
const STEP_S: f32 = 0.1;
/// Largest turn of a step, rad: within it a vector moves along its chord, to 2 %.
const MOST_TURN_RAD: f32 = 0.5;
/// Rates between which nothing is judged, rad/s: faster than a hand turns, where an accelerometer off the axis feels
/// the rotation itself, and slower than what no gyro reads (2,000 deg/s), which is a wrong unit.
const DRILLING_RAD_S: core::ops::Range<f32> = 3.0..35.0;
/// Least part of a vector across an axis for a turn about the axis to show, of its length: 12 deg, beside which biases
/// are small.
const ACROSS: f32 = 0.2;
/// Deviations within which a factor has to be known: three, twice as wide because successive steps share a reading.
const KNOWN: f32 = 6.0;
/// Largest distance of a factor from one: half of the way to zero, which another axis gives.
const NEAR: f32 = 0.5;
/// Least number of steps: a deviation from fewer is a guess.
const LEAST_STEPS: f32 = 10.0;
/// Steps after which what was seen counts half: the turns of the last five minutes tell.
const MOST_STEPS: f32 = 3_000.0;
/// Least mean square of a row's error, rad^2: a hundredth of the vector's length, for motion and the sensors' own
/// errors.
const LEAST_NOISE: f32 = 1e-4;
/// Bias that a gyro may have, rad/s: 20 deg/s, twice the zero-rate level of data sheets (LSM6DS: 10 deg/s).
const BIAS_RAD_S: f32 = 0.35;
/// Part of a column's square that keeps an inverse finite where nothing turned.
const FINITE: f32 = 1e-6;

bitflags::bitflags! {
    /// Turns about the probe's axes, as gyro and accelerometer and as gyro and magnetometer agree on them.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct TurnFlags: u16 {
        /// A turn about x, by gravity.
        const X_BY_ACCEL = 1;
        /// A turn about y, by gravity.
        const Y_BY_ACCEL = 1 << 1;
        /// A turn about z, by gravity.
        const Z_BY_ACCEL = 1 << 2;
        /// A turn about x, by the field.
        const X_BY_MAG = 1 << 3;
        /// A turn about y, by the field.
        const Y_BY_MAG = 1 << 4;
        /// A turn about z, by the field.
        const Z_BY_MAG = 1 << 5;
    }
}

/// Check of the mounting. Turn the probe about each of its axes by a quarter, more than once; a wrong sign, unit or
/// axis of a sensor then shows.
///
/// A vector v that stands still in the earth turns in the body by `dv/dt = v x w`. By least squares each axis of the
/// gyro gets the factor by which its rate has to be multiplied to turn gravity, and the field, as they turn. It is one
/// if all is well, minus one for a wrong sign, 57 or 1/57 for a wrong unit, and near zero for another axis. An
/// accelerometer or a magnetometer with one axis turned round differs from the gyro about the two others, with two
/// exchanged about all.
#[derive(Clone, Copy, Debug)]
pub struct MountingCheck {
    step: Step,
    before: Option<Means>,
    /// By the accelerometer, by the magnetometer.
    fits: [Fit; 2],
}

/// Sums of a step. A magnetometer may be slower than the rest.
#[derive(Clone, Copy, Debug)]
struct Step {
    begun_us: u64,
    rate: Vector3<f32>,
    samples: f32,
    vectors: [Vector3<f32>; 2],
    readings: [f32; 2],
}

/// Means of a step: rate in rad/s, specific force in m/s^2 and field in microtesla.
#[derive(Clone, Copy, Debug)]
struct Means {
    rate: Vector3<f32>,
    vectors: [Option<Vector3<f32>>; 2],
}

/// Least squares of three factors f and the gyro's bias b: the change of a vector v in `seconds` is
/// `v x (diag(turn) f - seconds b)`.
#[derive(Clone, Copy, Debug)]
struct Fit {
    of_factors: Matrix3<f32>,
    mixed: Matrix3<f32>,
    of_bias: Matrix3<f32>,
    right: [Vector3<f32>; 2],
    square: f32,
    steps: f32,
}

impl MountingCheck {
    /// Before any sample. All zero, so that a `static` of it costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self { step: Step::new(0), before: None, fits: [Fit::ZERO; 2] }
    }

    /// Adds a sample, in the probe's axes.
    pub fn update(&mut self, sample: &Sample) {
        const GYRO: SampleFlags = SampleFlags::GYRO_MISSING.union(SampleFlags::GYRO_CLIPPED).union(SampleFlags::FAULT);
        const ACCEL: SampleFlags = SampleFlags::ACCEL_MISSING.union(SampleFlags::ACCEL_CLIPPED);
        const MAG: SampleFlags = SampleFlags::MAG_MISSING.union(SampleFlags::MAG_CLIPPED);
        let passed_us = sample.t_us.checked_sub(self.step.begun_us);
        let is_next = passed_us.is_some_and(|us| us as f32 * 1e-6 < 2.0 * STEP_S);
        let is_finite = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut].iter().flatten().all(|x| x.is_finite());
        if sample.flags.intersects(GYRO) || !is_finite || !is_next {
            (self.step, self.before) = (Step::new(sample.t_us), None);
            return;
        }
        self.step.rate += Vector3::from(sample.gyro_rad_s);
        self.step.samples += 1.0;
        let read = [(sample.accel_m_s2, ACCEL), (sample.mag_ut, MAG)];
        for ((sum, readings), (vector, unusable)) in self.step.vectors.iter_mut().zip(&mut self.step.readings).zip(read)
        {
            if !sample.flags.intersects(unusable) {
                *sum += Vector3::from(vector);
                *readings += 1.0;
            }
        }
        let seconds = passed_us.unwrap_or(0) as f32 * 1e-6;
        if seconds >= STEP_S {
            let now = self.step.means();
            if let Some(before) = self.before.replace(now) {
                self.turned(&before, &now, seconds);
            }
            self.step = Step::new(sample.t_us);
        }
    }

    /// Takes the turn from the middle of one step to that of the next.
    fn turned(&mut self, before: &Means, now: &Means, seconds: f32) {
        let rate = (before.rate + now.rate) * 0.5;
        if DRILLING_RAD_S.contains(&rate.norm()) {
            return;
        }
        let turn = rate * seconds;
        for ((fit, before), now) in self.fits.iter_mut().zip(&before.vectors).zip(&now.vectors) {
            if let (Some(before), Some(now)) = (before, now) {
                // Scaled to a length of one on the average, so that one limit serves all units.
                let length = 0.5 * (before.norm() + now.norm());
                let change = (now - before) / length;
                // By the vector and not by the gyro, whose unit may be wrong. A NaN, of vectors of no length, is none.
                if change.norm_squared() < MOST_TURN_RAD * MOST_TURN_RAD {
                    fit.add(&((before + now) / (2.0 * length)), &change, &turn, seconds);
                }
            }
        }
    }

    /// Turns that have been seen well enough to judge.
    #[must_use]
    pub fn seen(&self) -> TurnFlags {
        self.flags(|factor| factor.is_some())
    }

    /// Those of the turns seen about which the sensors do not agree.
    #[must_use]
    pub fn wrong(&self) -> TurnFlags {
        self.flags(|factor| factor.is_some_and(|factor| libm::fabsf(factor - 1.0) > NEAR))
    }

    /// Factors by which the gyro's rates about x, y and z have to be multiplied to turn gravity, and the field, as they
    /// turn: one if units, signs and axes are right. `None`: not turned enough about this axis.
    #[must_use]
    pub fn factors(&self) -> [[Option<f32>; 3]; 2] {
        self.fits.each_ref().map(Fit::factors)
    }

    fn flags(&self, holds: impl Fn(Option<f32>) -> bool) -> TurnFlags {
        let factors = self.factors();
        (0_u16..)
            .zip(factors.iter().flatten())
            .filter(|(_, factor)| holds(**factor))
            .fold(TurnFlags::empty(), |flags, (bit, _)| flags | TurnFlags::from_bits_truncate(1 << bit))
    }

    /// Norms of the last step's mean specific force, m/s^2, and field, microtesla: gravity and the earth's field at
    /// rest.
    #[must_use]
    pub fn norms(&self) -> [Option<f32>; 2] {
        self.before.map_or([None; 2], |means| means.vectors.map(|vector| vector.map(|vector| vector.norm())))
    }
}

impl Default for MountingCheck {
    fn default() -> Self {
        Self::new()
    }
}

impl Step {
    const fn new(begun_us: u64) -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { begun_us, rate: zero, samples: 0.0, vectors: [zero; 2], readings: [0.0; 2] }
    }

    fn means(&self) -> Means {
        let mean = |(sum, readings): (&Vector3<f32>, &f32)| (*readings > 0.0).then(|| sum / *readings);
        let mut means = self.vectors.iter().zip(&self.readings).map(mean);
        Means { rate: self.rate / self.samples, vectors: [(); 2].map(|()| means.next().flatten()) }
    }
}

impl Fit {
    const ZERO: Self = {
        let zero = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let right = [Vector3::new(0.0, 0.0, 0.0); 2];
        Self { of_factors: zero, mixed: zero, of_bias: zero, right, square: 0.0, steps: 0.0 }
    };

    fn add(&mut self, vector: &Vector3<f32>, change: &Vector3<f32>, turn: &Vector3<f32>, seconds: f32) {
        if self.steps >= MOST_STEPS {
            for matrix in [&mut self.of_factors, &mut self.mixed, &mut self.of_bias] {
                *matrix *= 0.5;
            }
            self.right.iter_mut().for_each(|right| *right *= 0.5);
            (self.square, self.steps) = (self.square * 0.5, self.steps * 0.5);
        }
        let by_bias = vector.cross_matrix() * -seconds;
        let mut by_factors = vector.cross_matrix();
        for (mut column, turn) in by_factors.column_iter_mut().zip(turn.iter()) {
            let shown = if column.norm_squared() > ACROSS * ACROSS { *turn } else { 0.0 };
            column *= shown;
        }
        self.of_factors += by_factors.transpose() * by_factors;
        self.mixed += by_factors.transpose() * by_bias;
        self.of_bias += by_bias.transpose() * by_bias;
        let [right, of_bias] = &mut self.right;
        *right += by_factors.transpose() * change;
        *of_bias += by_bias.transpose() * change;
        self.square += change.norm_squared();
        self.steps += 1.0;
    }

    fn factors(&self) -> [Option<f32>; 3] {
        self.solved().unwrap_or([None; 3])
    }

    fn solved(&self) -> Option<[Option<f32>; 3]> {
        if self.steps < LEAST_STEPS {
            return None;
        }
        let of_bias = self.of_bias + Matrix3::identity() * (LEAST_NOISE / (BIAS_RAD_S * BIAS_RAD_S));
        let inverse = of_bias.try_inverse()?;
        let [right, of_bias] = &self.right;
        let right = right - self.mixed * inverse * of_bias;
        let normal = self.of_factors - self.mixed * inverse * self.mixed.transpose();
        let covariance = (normal + Matrix3::identity() * FINITE).try_inverse()?;
        let factors = covariance * right;
        let left = self.square - of_bias.dot(&(inverse * of_bias)) - factors.dot(&right);
        // Three rows a step, six unknowns.
        let mean = left / (3.0 * self.steps - 6.0);
        let noise = if mean > LEAST_NOISE { mean } else { LEAST_NOISE };
        let known = covariance.diagonal().map(|x| x * noise * KNOWN * KNOWN);
        let [factors, known]: [[f32; 3]; 2] = [factors.into(), known.into()];
        let mut both = factors.into_iter().zip(known);
        // A NaN is not known.
        let of_axis = |(factor, known): (f32, f32)| (known > 0.0 && known < 1.0).then_some(factor);
        Some([(); 3].map(|()| both.next().and_then(of_axis)))
    }
}

#[cfg(test)]
mod tests;
