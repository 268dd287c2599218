//! Check of how the sensors are mounted: whether they agree on a turn about each axis of the probe.

use crate::{
    algebra::Packed,
    sample::{Sample, SampleFlags, TurnFlags},
};
use nalgebra::{Matrix3, Vector3};

/// Time over which readings are averaged: short against a turn by hand, long against noise, seconds.
const STEP_S: f32 = 0.1;
/// Steps of a stretch: half a second. A hand's acceleration that comes and goes within it cancels, a quarter turn goes
/// on.
const STEPS: usize = 5;
/// Rates between which nothing is judged, rad/s: faster than a hand turns, where an accelerometer off the axis feels
/// the rotation itself, and slower than what no gyro reads (2,000 deg/s), which is a wrong unit.
const DRILLING_RAD_S: core::ops::Range<f32> = 3.0..35.0;
/// Least way of a vector in a stretch, by the gyro or by itself, of its length: where nothing moves, nothing shows. A
/// tool that rotates at the slower of the rates above with 0.07 of its gravity across the axis goes so far; biases, and
/// what an accelerometer off the axis feels, are smaller.
const MOVED: f32 = 0.1;
/// Largest distance of a factor from that of a right mounting. A gyro that reads twice the rate gives a factor of 0.5;
/// one of a data sheet errs by 0.1 at most, and what is not known of a factor is below [`KNOWN`].
const NEAR: f32 = 0.4;
/// Largest deviation of a factor that is judged, of its size where that is above one.
const KNOWN: f32 = 0.25;
/// Largest part of a vector's motion that turns may leave unexplained. What a hand's acceleration, a magnet or iron on
/// the probe adds to the readings stands on both sides of the fit and draws the factors towards zero, by about its
/// part.
const UNEXPLAINED: f32 = 0.05;
/// Least range of a component of the vector's direction across an axis for turns about the axis to be judged: 45 deg. A
/// probe that swings on a rope or an arm feels less of its turns than there is, in step with them and with nothing left
/// over, and does not swing so far.
const LEAST_RANGE: f32 = 0.7;
/// Steps without a stretch in which something moved after which all is forgotten: ten minutes.
const MOST_STILL: u32 = 6_000;
/// Least number of stretches: 18 rows for nine factors.
const LEAST_STRETCHES: f32 = 6.0;
/// Stretches after which what was seen counts half: the turns of the last five minutes of motion tell.
const MOST_STRETCHES: f32 = 600.0;
/// Part of the largest column's square that keeps the factor of the normal equations real where nothing turned.
const FINITE: f32 = 1e-5;
/// Share of the vector's motion to which f32's rounding leaves its unexplained part known.
const ROUNDING: f32 = 1e-6;

/// Check of the mounting. Turn the probe about each of its axes by a quarter, more than once; a wrong sign, unit or
/// axis of a sensor then shows.
///
/// A vector v that stands still in the earth turns in the body by `dv/dt = v x (M w)`, where M is one if all is well,
/// has a minus one for a wrong sign, 57 or 1/57 for a wrong unit, and exchanged columns for exchanged axes of the gyro.
/// M is fitted by least squares for gravity and for the field, over stretches of half a second. An accelerometer or a
/// magnetometer with one axis turned round differs from the gyro about the two others, with two exchanged about all.
///
/// Noise averages out; what a hand, a magnet or a bias adds does not, for it may go along with the turns. So a factor
/// is judged only where all that the turns leave unexplained could not move it far, and is little, and where the vector
/// has gone far: the acceleration of a probe that swings goes along with its turns and leaves nothing over.
#[derive(Clone, Copy, Debug)]
pub struct MountingCheck {
    step: Step,
    /// Means of the last step. Not an `Option` of them: that would not be all zero bytes.
    last: [Option<Vector3<f32>>; 2],
    /// By the accelerometer, by the magnetometer.
    stretches: [Stretch; 2],
    fits: [Fit; 2],
    seen: TurnFlags,
    wrong: TurnFlags,
    /// Steps since something moved.
    still: u32,
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

/// Some steps of a vector v while the gyro reads w. From the mean of one stretch to that of the next, v changes by the
/// integral of `v x (M w)` under a weight that rises over the first and falls over the second.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    steps: usize,
    sum: Vector3<f32>,
    /// Integral of `v w^T`.
    turned: Matrix3<f32>,
    /// Integral of `v w^T` under the rising weight.
    rising: Matrix3<f32>,
    /// Mean and rising integral of the stretch before.
    before: Option<(Vector3<f32>, Matrix3<f32>)>,
}

/// Least squares of M, column by column.
#[derive(Clone, Copy, Debug)]
struct Fit {
    normal: Packed<9, 45>,
    right: [f32; 9],
    square: f32,
    stretches: f32,
    /// Least and largest component of the vector's direction along each axis.
    range: [Vector3<f32>; 2],
}

impl MountingCheck {
    /// Before any sample. All zero, so that a `static` of it costs no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            step: Step::new(0),
            last: [None; 2],
            stretches: [Stretch::ZERO; 2],
            fits: [Fit::ZERO; 2],
            seen: TurnFlags::empty(),
            wrong: TurnFlags::empty(),
            still: 0,
        }
    }

    /// Adds a sample, in the probe's axes; `bias_rad_s` is the gyro's, as far as it is known.
    pub fn update(&mut self, sample: &Sample, bias_rad_s: [f32; 3]) {
        const GYRO: SampleFlags = SampleFlags::GYRO_MISSING.union(SampleFlags::GYRO_CLIPPED).union(SampleFlags::FAULT);
        const ACCEL: SampleFlags = SampleFlags::ACCEL_MISSING.union(SampleFlags::ACCEL_CLIPPED);
        const MAG: SampleFlags = SampleFlags::MAG_MISSING.union(SampleFlags::MAG_CLIPPED);
        let passed_us = sample.t_us.checked_sub(self.step.begun_us);
        let is_next = passed_us.is_some_and(|us| us as f32 * 1e-6 < 2.0 * STEP_S);
        let vectors = [&sample.gyro_rad_s, &sample.accel_m_s2, &sample.mag_ut, &bias_rad_s];
        let is_finite = vectors.iter().all(|vector| vector.iter().all(|x| x.is_finite()));
        if sample.flags.intersects(GYRO) || !is_finite || !is_next {
            (self.step, self.last, self.stretches) = (Step::new(sample.t_us), [None; 2], [Stretch::ZERO; 2]);
            return;
        }
        self.step.rate += Vector3::from(sample.gyro_rad_s) - Vector3::from(bias_rad_s);
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
            let means = self.step.means();
            self.step = Step::new(sample.t_us);
            self.last = means.vectors;
            self.turned(&means, seconds);
        }
    }

    /// Adds a step to the stretches.
    fn turned(&mut self, means: &Means, seconds: f32) {
        let is_drilling = DRILLING_RAD_S.contains(&means.rate.norm());
        let mut moved = false;
        for ((fit, stretch), vector) in self.fits.iter_mut().zip(&mut self.stretches).zip(&means.vectors) {
            match vector {
                Some(vector) if !is_drilling => moved |= stretch.add(vector, &(means.rate * seconds), fit),
                _ => *stretch = Stretch::ZERO,
            }
        }
        self.still = if moved { 0 } else { self.still.saturating_add(1) };
        if self.still > MOST_STILL {
            self.fits = [Fit::ZERO; 2];
        }
        if moved || self.still > MOST_STILL {
            self.judge();
        }
    }

    /// Turns that have been seen well enough to judge.
    #[must_use]
    pub const fn seen(&self) -> TurnFlags {
        self.seen
    }

    /// Seen turns on which the sensors do not agree.
    #[must_use]
    pub const fn wrong(&self) -> TurnFlags {
        self.wrong
    }

    /// Judges every turn anew.
    fn judge(&mut self) {
        (self.seen, self.wrong) = (TurnFlags::empty(), TurnFlags::empty());
        let mut bit = TurnFlags::X_BY_ACCEL.bits();
        for fit in &self.fits {
            for (axis, column) in fit.columns().into_iter().enumerate() {
                let turn = TurnFlags::from_bits_truncate(bit);
                bit <<= 1;
                let Some(column) = column else { continue };
                self.seen |= turn;
                for (of, factor) in column.into_iter().enumerate() {
                    let right = if of == axis { 1.0 } else { 0.0 };
                    if factor.is_some_and(|factor| libm::fabsf(factor - right) > NEAR) {
                        self.wrong |= turn;
                    }
                }
            }
        }
    }

    /// Columns of M for a turn about x, y and z, by gravity and by the field: the axis about which the vector turned,
    /// and how far, for each radian of the gyro's. `None`: not turned enough about this axis, or its factor is not
    /// known.
    #[must_use]
    pub fn columns(&self) -> [[Option<[Option<f32>; 3]>; 3]; 2] {
        self.fits.each_ref().map(Fit::columns)
    }

    /// Norms of the last step's mean specific force, m/s^2, and field, microtesla: gravity and the earth's field at
    /// rest.
    #[must_use]
    pub fn norms(&self) -> [Option<f32>; 2] {
        self.last.map(|vector| vector.map(|vector| vector.norm()))
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

impl Stretch {
    const ZERO: Self = {
        let zero = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self { steps: 0, sum: Vector3::new(0.0, 0.0, 0.0), turned: zero, rising: zero, before: None }
    };

    /// Adds a step: the vector, and the turn by the gyro. At the stretch's end the fit takes the change since the one
    /// before; returns true if something moved.
    // Not inlined, nor is `Fit::columns`: the images are full, and that saves 0.1 KiB of flash.
    #[inline(never)]
    fn add(&mut self, vector: &Vector3<f32>, turn: &Vector3<f32>, fit: &mut Fit) -> bool {
        let turned = vector * turn.transpose();
        self.sum += vector;
        self.turned += turned;
        self.rising += turned * ((self.steps as f32 + 0.5) / STEPS as f32);
        self.steps += 1;
        if self.steps < STEPS {
            return false;
        }
        let mean = self.sum / STEPS as f32;
        let mut moved = false;
        if let Some((before, rising)) = &self.before {
            // Scaled to a length of one on the average, so that one limit serves all units.
            let length = 0.5 * (before.norm() + mean.norm());
            let change = (mean - before) / length;
            let turned = (rising + self.turned - self.rising) / length;
            // A NaN, of vectors of no length, is no motion.
            moved = change.norm() > MOVED || across(&turned) > MOVED;
            if moved && (change.norm_squared() + turned.norm_squared()).is_finite() {
                fit.add(&change, &turned);
                fit.extend(&(mean / length));
            }
        }
        *self = Self { before: Some((mean, self.rising)), ..Self::ZERO };
        moved
    }
}

/// Norm of how far the vector goes by the gyro's turns about x, y and z, for the integral of `v w^T` under the weight.
fn across(turned: &Matrix3<f32>) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| Vector3::ith(axis, 1.0).cross(&turned.column(axis)).norm_squared());
    libm::sqrtf(x + y + z)
}

impl Fit {
    const ZERO: Self = Self {
        normal: Packed::zero(),
        right: [0.0; 9],
        square: 0.0,
        stretches: 0.0,
        range: [Vector3::new(0.0, 0.0, 0.0); 2],
    };

    fn add(&mut self, change: &Vector3<f32>, turned: &Matrix3<f32>) {
        if self.stretches >= MOST_STRETCHES {
            self.normal.0.iter_mut().chain(&mut self.right).for_each(|sum| *sum *= 0.5);
            (self.square, self.stretches) = (self.square * 0.5, self.stretches * 0.5);
        }
        // The change is the sum over the axes j of `u_j x m_j`, with u_j of the integral and m_j of M.
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]]: [[f32; 3]; 3] = (*turned).into();
        let rows = [
            [0.0, -az, ay, 0.0, -bz, by, 0.0, -cz, cy],
            [az, 0.0, -ax, bz, 0.0, -bx, cz, 0.0, -cx],
            [-ay, ax, 0.0, -by, bx, 0.0, -cy, cx, 0.0],
        ];
        self.normal.add_outers(&rows, 1.0);
        for (row, change) in rows.iter().zip(change.iter()) {
            self.right.iter_mut().zip(row).for_each(|(sum, element)| *sum += element * change);
        }
        self.square += change.norm_squared();
        self.stretches += 1.0;
    }

    /// Extends the range of the vector's direction.
    fn extend(&mut self, direction: &Vector3<f32>) {
        let is_first = self.stretches <= 1.0;
        let [least, largest] = &mut self.range;
        for ((least, largest), x) in least.iter_mut().zip(largest.iter_mut()).zip(direction.iter()) {
            if is_first || *x < *least {
                *least = *x;
            }
            if is_first || *x > *largest {
                *largest = *x;
            }
        }
    }

    #[inline(never)]
    fn columns(&self) -> [Option<[Option<f32>; 3]>; 3] {
        self.solved().unwrap_or([None; 3])
    }

    fn solved(&self) -> Option<[Option<[Option<f32>; 3]>; 3]> {
        if self.stretches < LEAST_STRETCHES {
            return None;
        }
        let mut normal = self.normal;
        let trace = (0..9).fold(0.0, |sum, i| sum + normal.get(i, i));
        (0..9).for_each(|i| normal.add(i, i, FINITE * trace / 9.0));
        let root = normal.cholesky()?;
        let factors = root.solve(&self.right);
        let explained = factors.iter().zip(&self.right).fold(0.0, |sum, (factor, right)| sum + factor * right);
        let left = self.square - explained;
        let left = if left > ROUNDING * self.square { left } else { ROUNDING * self.square };
        // A NaN is not explained.
        let is_explained = left < UNEXPLAINED * self.square;
        let variance = |i: usize| {
            let mut unit = [0.0; 9];
            unit.iter_mut().skip(i).take(1).for_each(|x| *x = 1.0);
            root.solve_lower(&unit).iter().fold(0.0, |sum, x| sum + x * x)
        };
        let mut known = factors.iter().enumerate().map(|(i, factor)| {
            let size = if libm::fabsf(*factor) > 1.0 { *factor } else { 1.0 };
            // All that is left may go along with this factor.
            (left * variance(i) < KNOWN * KNOWN * size * size).then_some(*factor)
        });
        let [least, largest] = &self.range;
        let range = largest - least;
        let columns = [0, 1, 2].map(|axis| {
            let column = [(); 3].map(|()| known.next().flatten());
            let is_known = column.get(axis).is_some_and(Option::is_some);
            let has_range = range.iter().enumerate().any(|(along, range)| along != axis && *range > LEAST_RANGE);
            (is_explained && is_known && has_range).then_some(column)
        });
        Some(columns)
    }
}

#[cfg(test)]
mod tests;
