//! Increments from one node to the next, composed with the present parameters: rotation, field, velocity and
//! position, each with its derivatives. All vectors are in the frame of the body at the first node.
//!
//! The paper's eq 7 for the field and eq 15 for the specific force, with the exact rotation in the place of its first
//! order, and with the sign that an earth-fixed vector needs.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    columns::{GLOBALS, NUISANCES},
    globals::Globals,
    gyro_matrix::GyroMatrix,
    increment::Increment,
    parameters::Parameters,
    real::{M3, Real, V3, cross_matrix, identity, norm, rotation, square, zero3, zero33},
    taken_out::TakenOut,
};

/// Number of elements of bias and P.
pub(super) const GYRO: usize = 12;

/// A quantity's derivatives with respect to bias and P: a vector each.
pub(super) type ByGyro<T> = [V3<T>; GYRO];

/// Velocity or position, and its derivatives.
#[derive(Clone, Copy)]
pub(super) struct Path<T> {
    pub value: V3<T>,
    pub by_lag: V3<T>,
    /// Elements of the accelerometer matrix, row-major.
    pub by_matrix: [V3<T>; 9],
    /// Accelerometer bias: the matrix that multiplies it.
    pub by_bias: M3<T>,
    pub by_gyro: ByGyro<T>,
}

impl<T: Real> Path<T> {
    const fn zero() -> Self {
        Self { value: zero3(), by_lag: zero3(), by_matrix: [zero3(); 9], by_bias: zero33(), by_gyro: [zero3(); GYRO] }
    }

    /// Goes on by a step of force through `dt` seconds: `position` by `velocity` and half of the step, `velocity` by
    /// the step. One pass, in which each sum is loaded and stored once.
    fn go_on(position: &mut Self, velocity: &mut Self, step: &Self, dt: T) {
        let half = dt * dt * T::of(0.5);
        let add = |p: &mut V3<T>, v: &mut V3<T>, step: &V3<T>| {
            for ((p, v), step) in p.iter_mut().zip(v.iter_mut()).zip(step.iter()) {
                *p = *p + *v * dt + *step * half;
                *v += *step * dt;
            }
        };
        add(&mut position.value, &mut velocity.value, &step.value);
        add(&mut position.by_lag, &mut velocity.by_lag, &step.by_lag);
        let biases = position.by_bias.iter_mut().zip(velocity.by_bias.iter_mut()).zip(step.by_bias.iter());
        for ((p, v), step) in biases {
            *p = *p + *v * dt + *step * half;
            *v += *step * dt;
        }
        for ((p, v), step) in position.by_matrix.iter_mut().zip(&mut velocity.by_matrix).zip(&step.by_matrix) {
            add(p, v, step);
        }
        for ((p, v), step) in position.by_gyro.iter_mut().zip(&mut velocity.by_gyro).zip(&step.by_gyro) {
            add(p, v, step);
        }
    }
}

/// An increment as it was turned to the first node: the frame of its middle, its length, and the corrected vectors.
pub(super) struct Turned<T> {
    pub middle: M3<T>,
    pub seconds: T,
    pub field: Option<V3<T>>,
    pub force: Option<V3<T>>,
}

/// Sums over the increments from one node to the next.
#[derive(Clone, Copy)]
pub(super) struct Preintegration<T> {
    /// Last sample, microseconds.
    pub end_us: u64,
    pub seconds: T,
    pub rotation: M3<T>,
    /// Derivatives of the rotation error, in the frame of the first node, by bias and P.
    pub by_gyro: ByGyro<T>,
    /// Sum of the fields, and of its derivatives: elements of the magnetometer matrix, hard iron, lag, bias and P.
    pub field: V3<T>,
    pub field_by_matrix: [V3<T>; 9],
    pub field_by_iron: M3<T>,
    pub field_by_lag: V3<T>,
    pub field_by_gyro: ByGyro<T>,
    pub fields: u16,
    /// Sum of the norms of the corrected fields.
    pub field_norms: T,
    /// First of the corrected fields, turned, and the sum of the others' squared distances from it.
    first_field: V3<T>,
    field_distances: T,
    pub velocity: Path<T>,
    pub position: Path<T>,
    pub forces: u16,
    pub increments: u16,
    /// Angle turned, rad: the sum, not the vector.
    pub angle: T,
    /// Sum of the variances of specific force.
    pub vibration: T,
    /// Variances, of each axis, by lost samples: of the turn, rad^2, and of the velocity gained, (m/s)^2.
    pub unread_turn: T,
    pub unread_velocity: T,
    /// Sums of raw mean rates, of variances within increments, and of squares of the means about the first.
    pub rates: V3<T>,
    pub variances: V3<T>,
    pub squares: V3<T>,
    first_rate: V3<T>,
    /// Sum of what is taken out of the rates, rad/s.
    taken_out: V3<T>,
    /// Sums of the vectors as read, for a rest.
    pub forces_read: V3<T>,
    pub fields_read: V3<T>,
}

impl<T: Real> Preintegration<T> {
    pub const fn zero() -> Self {
        Self {
            end_us: 0,
            seconds: T::ZERO,
            rotation: zero33(),
            by_gyro: [zero3(); GYRO],
            field: zero3(),
            field_by_matrix: [zero3(); 9],
            field_by_iron: zero33(),
            field_by_lag: zero3(),
            field_by_gyro: [zero3(); GYRO],
            fields: 0,
            field_norms: T::ZERO,
            first_field: zero3(),
            field_distances: T::ZERO,
            velocity: Path::zero(),
            position: Path::zero(),
            forces: 0,
            increments: 0,
            angle: T::ZERO,
            vibration: T::ZERO,
            unread_turn: T::ZERO,
            unread_velocity: T::ZERO,
            rates: zero3(),
            variances: zero3(),
            squares: zero3(),
            first_rate: zero3(),
            taken_out: zero3(),
            forces_read: zero3(),
            fields_read: zero3(),
        }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
        self.rotation = identity();
    }

    /// Adds an increment less what the effects add to it. `force_rate`: derivative of specific force, m/s^3.
    /// `gravity`: specific force at rest as predicted at the first node, where that multiplies the accelerometer's
    /// errors in the place of what was read.
    pub fn add(
        &mut self,
        increment: &Increment<T>,
        force_rate: &V3<T>,
        gravity: Option<&V3<T>>,
        with: &Parameters<T>,
        out: &TakenOut<T>,
    ) -> Turned<T> {
        let dt = increment.seconds;
        let raw = increment.rate - with.bias;
        let rate = with.p * raw - out.rate;
        let half = rotation(&(rate * (dt * T::of(0.5))));
        // Derivatives are taken at the middle of the increment: at its beginning the filter converges to a wrong point.
        let middle = self.rotation * half;
        let middle_p = middle * with.p;
        let mut at_middle = self.by_gyro;
        for j in 0..3 {
            let by_bias = middle_p.column(j) * (-dt);
            at_middle[j] += by_bias * T::of(0.5);
            self.by_gyro[j] += by_bias;
            for i in 0..3 {
                let by_p = middle.column(i) * (dt * raw[j]);
                at_middle[3 + 3 * i + j] += by_p * T::of(0.5);
                self.by_gyro[3 + 3 * i + j] += by_p;
            }
        }
        let mut turned = Turned { middle, seconds: dt, field: None, force: None };
        if let Some(field) = &increment.field {
            turned.field = Some(self.add_field(&(field - out.field), &rate, dt, &middle, &at_middle, with));
        }
        if let Some(force) = &increment.force {
            let force = force - out.force;
            turned.force = Some(self.add_force(&force, force_rate, gravity, &rate, dt, &middle, &at_middle, with));
        }
        self.rotation = middle * half;
        self.end_us = increment.end_us;
        self.seconds += dt;
        self.angle += norm(&rate) * dt;
        self.vibration += increment.vibration;
        self.unread_turn += increment.unread_turn;
        self.unread_velocity += increment.unread_velocity;
        if self.increments == 0 {
            self.first_rate = increment.mean_rate;
        }
        let centred = increment.mean_rate - self.first_rate;
        self.rates += centred;
        self.squares += centred.component_mul(&centred);
        self.variances += increment.rate_variance;
        self.taken_out += out.rate;
        self.increments += 1;
        turned
    }

    fn add_field(
        &mut self,
        read: &V3<T>,
        rate: &V3<T>,
        dt: T,
        middle: &M3<T>,
        at_middle: &ByGyro<T>,
        with: &Parameters<T>,
    ) -> V3<T> {
        let corrected = with.mag_matrix * read + with.hard_iron;
        // A field that is late by tau is tau w x h further on.
        let change = corrected.cross(rate);
        self.field_norms += norm(&corrected);
        // To the second order: at 150 rpm the first one alone makes a field that is 12 ms late 2 % longer across the
        // axis.
        let half = with.mag_lag * T::of(0.5);
        let turned = middle * (corrected + (change + change.cross(rate) * half) * with.mag_lag);
        if self.fields == 0 {
            self.first_field = turned;
        }
        self.field += turned;
        self.field_distances += square(&(turned - self.first_field));
        self.field_by_lag += middle * (change + change.cross(rate) * with.mag_lag);
        let cross = cross_matrix(rate) * with.mag_lag;
        let late = middle - middle * (cross - cross * cross * T::of(0.5));
        self.field_by_iron += late;
        for i in 0..3 {
            let column = late.column(i);
            for j in 0..3 {
                self.field_by_matrix[3 * i + j] += column * read[j];
            }
        }
        // The gyro's errors turn the field within the lag, too: by twice what they turn it from the middle of the
        // increment to its end, over its length. Without this term a common turn of gyro and magnetometer, which
        // nothing shows, would be told from none.
        let within = middle * (corrected + change * half) * (T::of(2.0) * with.mag_lag / dt);
        for ((sum, by), end) in self.field_by_gyro.iter_mut().zip(at_middle).zip(&self.by_gyro) {
            *sum += by.cross(&turned) + within.cross(&(end - by));
        }
        self.fields_read += read;
        self.fields += 1;
        turned
    }

    #[allow(clippy::too_many_arguments)]
    fn add_force(
        &mut self,
        read: &V3<T>,
        force_rate: &V3<T>,
        gravity: Option<&V3<T>>,
        rate: &V3<T>,
        dt: T,
        middle: &M3<T>,
        at_middle: &ByGyro<T>,
        with: &Parameters<T>,
    ) -> V3<T> {
        // Change of the force now, and in the middle of the lag; of a read change the second order is not known.
        let (multiplied, change, later) = match gravity {
            None => (read + force_rate * with.accel_lag, *force_rate, *force_rate),
            Some(at_node) => {
                let here = middle.transpose() * at_node;
                let change = here.cross(rate);
                (here, change, change - change.cross(rate) * (with.accel_lag * T::of(0.5)))
            }
        };
        let corrected = read + later * with.accel_lag + (with.accel_matrix * multiplied - multiplied) + with.accel_bias;
        let force = middle * corrected;
        let by_lag = middle * (later * T::of(2.0) - change);
        let mut step = Path { value: force, by_lag, by_bias: *middle, ..Path::zero() };
        for i in 0..3 {
            let column = middle.column(i);
            for j in 0..3 {
                step.by_matrix[3 * i + j] = column * multiplied[j];
            }
        }
        for (sum, by) in step.by_gyro.iter_mut().zip(at_middle) {
            *sum = by.cross(&force);
        }
        Path::go_on(&mut self.position, &mut self.velocity, &step, dt);
        self.forces_read += read;
        self.forces += 1;
        force
    }

    /// Makes the derivatives by the elements of P those by its unknowns, once, at the node's end.
    pub fn by_unknowns(&mut self, matrix: &GyroMatrix<T>, centre: &M3<T>) {
        let Self { by_gyro, field_by_gyro, velocity, position, .. } = self;
        for by in [by_gyro, field_by_gyro, &mut velocity.by_gyro, &mut position.by_gyro] {
            let [_, _, _, by @ ..] = by;
            matrix.by_unknowns(centre, by);
        }
    }

    /// Variance of the rotation by the uncertainty of bias and P, rad^2, with the widths of the priors. Before the
    /// node's end an element of P stands for its unknown, which it is to first order.
    pub fn rotation_variance(&self, globals: &Globals<T>, sigma: &[T; GLOBALS]) -> T {
        let mut by = [[T::ZERO; GYRO]; 3];
        for ((k, of), sigma) in self.by_gyro.iter().enumerate().zip(&sigma[NUISANCES..]) {
            for (by, of) in by.iter_mut().zip(of.iter()) {
                by[k] = *of * *sigma;
            }
        }
        by.iter().fold(T::ZERO, |sum, by| sum + globals.variance(by))
    }

    /// Variance of the raw rate on each axis over the node, (rad/s)^2, and its mean, rad/s.
    pub fn rate_statistics(&self) -> (V3<T>, V3<T>) {
        let n = T::of(f32::from(self.increments));
        let mean = self.rates / n;
        (self.variances / n + self.squares / n - mean.component_mul(&mean), mean + self.first_rate)
    }

    /// Variance of the mean raw rate on each axis, by how much the increments' means scatter, (rad/s)^2.
    pub fn rate_variance_of_mean(&self) -> V3<T> {
        if self.increments < 2 {
            return zero3();
        }
        let n = T::of(f32::from(self.increments));
        let mean = self.rates / n;
        (self.squares / n - mean.component_mul(&mean)) / (n - T::ONE)
    }

    /// Notes that a part of what is taken out of the rate, rad/s, is part of the bias from now on.
    pub fn settle(&mut self, step: &V3<T>) {
        self.taken_out -= step * T::of(f32::from(self.increments));
    }

    /// Mean of what is taken out of the rate, rad/s.
    pub fn mean_taken_out(&self) -> V3<T> {
        let n = if self.increments > 0 { self.increments } else { 1 };
        self.taken_out / T::of(f32::from(n))
    }

    /// Variance of the mean field, of each axis, by how much the turned fields scatter.
    pub fn field_variance(&self) -> T {
        if self.fields < 2 {
            return T::ZERO;
        }
        let n = T::of(f32::from(self.fields));
        let scatter = (self.field_distances - square(&(self.field - self.first_field * n)) / n) / (n - T::ONE);
        if scatter > T::ZERO { scatter / (T::of(3.0) * n) } else { T::ZERO }
    }

    /// Mean variance of specific force within its increments, (m/s^2)^2.
    pub fn mean_vibration(&self) -> T {
        if self.increments > 0 { self.vibration / T::of(f32::from(self.increments)) } else { T::ZERO }
    }
}

/// Largest component of a vector of squares, for limits on axes.
pub(super) fn largest<T: Real>(v: &V3<T>) -> T {
    let pair = if v.x > v.y { v.x } else { v.y };
    if pair > v.z { pair } else { v.z }
}

/// Squared angle between two vectors, rad^2, where it is small.
pub(super) fn squared_angle<T: Real>(a: &V3<T>, b: &V3<T>) -> T {
    square(&(a / norm(a) - b / norm(b)))
}

#[cfg(test)]
mod tests;
