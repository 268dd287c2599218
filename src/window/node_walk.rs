#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{BodyMeans, Grid, Increment, Node, VectorEffects, motion_sum::MotionSum};
use crate::{
    objective::fit_for_use,
    rotation::{exp_quaternion, matrix, middle_to_middle, renormalised, times},
};
use core::hint::black_box;
use nalgebra::{Matrix3, Quaternion, Vector3};

/// Share of the increments that have to be read for a mean to stand.
const LEAST_SHARE: f32 = 0.7;

/// Specific force under a third of gravity has no usable direction of gravity (free fall), m/s^2.
const LEAST_GRAVITY_M_S2: f32 = 3.3;

/// A field under a tenth of the weakest on earth (22 microtesla) is no field.
const LEAST_FIELD_UT: f32 = 2.2;

/// Walks through a window's increments with one gyro model and makes its nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeWalk {
    /// Takes a vector at the last increment into the frame of the beginning.
    attitude: Quaternion<f32>,
    /// Of the last two increments.
    rates: Option<[Vector3<f32>; 2]>,
    sensitivity: [[f32; 12]; 3],
    broken: bool,
    /// Norm of the last node's field.
    field_norm_ut: Option<f32>,
}

impl NodeWalk {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self { attitude: Quaternion::from_vector(nalgebra::Vector4::new(0.0, 0.0, 0.0, 0.0)), ..Self::start() }
    }

    pub const fn start() -> Self {
        Self {
            attitude: crate::rotation::IDENTITY,
            rates: None,
            sensitivity: [[0.0; 12]; 3],
            broken: false,
            field_norm_ut: None,
        }
    }

    /// The node of the increments from `from` on, with w = P w_raw - c.
    #[inline(never)]
    pub fn node(
        &mut self,
        (increments, grid, from): (impl Fn(u32) -> Increment, Grid, u32),
        (p, c): (&Matrix3<f32>, &Vector3<f32>),
        effects: &VectorEffects,
    ) -> Node {
        // There is one of it in a program, and with its address known each access to a field would compute the field's own from scratch.
        let walk = black_box(self);
        let mut means = [Mean::zero(); 2];
        let mut latest = MotionSum::zero();
        let mut sensitivity = walk.sensitivity;
        let mut square_rate = 0.0;
        let (mut raw_sum, mut gravity_sum, mut square_gravity) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        let mut suspect = false;
        let length = Node::length(grid);
        let dt = grid.interval_s();
        for position in 0..length {
            if position == length / 2 {
                walk.grow(&latest, dt);
                latest = MotionSum::zero();
                sensitivity = walk.sensitivity;
            }
            let increment = increments(from + position as u32);
            let (Some(raw), Some((rotation, rate))) = (increment.rate, walk.advance(&increment, dt, (p, c))) else {
                suspect = true;
                continue;
            };
            latest.add(&rotation, &raw);
            square_rate += rate.norm_squared();
            raw_sum += raw;
            let gravity = increment.gravity.unwrap_or_default();
            gravity_sum += gravity;
            square_gravity += gravity.norm_squared();
            add_vectors(&mut means, &increment, &rotation, &rate, effects);
        }
        walk.grow(&latest, dt);
        let broken = walk.broken;
        walk.broken = suspect;
        let least = LEAST_SHARE * length as f32;
        let [gravity, field] = means;
        let mut vectors = [None; 2];
        if !suspect {
            let field = field.direction(least, LEAST_FIELD_UT);
            // Eq 8 as a flag of the data: a field whose norm jumps by half is none.
            let before = walk.field_norm_ut;
            walk.field_norm_ut = field.map(|(_, norm)| norm);
            let field = field.filter(|(_, norm)| before.is_none_or(|before| fit_for_use(before, *norm)));
            vectors = [gravity.direction(least, LEAST_GRAVITY_M_S2), field];
        }
        let count = length as f32;
        let [gravity, _] = &vectors;
        let body = gravity.map(|(_, norm)| {
            // Of the three axes' scatter about the de-rotated mean, two thirds are across it.
            let scatter = square_gravity / count - norm * norm;
            let sigma_rad = libm::sqrtf(if scatter > 0.0 { scatter / (3.0 * count) } else { 0.0 }) / norm;
            BodyMeans { raw_rad_s: raw_sum / count, gravity_m_s2: gravity_sum / count, sigma_rad }
        });
        Node { vectors, sensitivity, square_rate: square_rate / count, body, broken }
    }

    /// Turns to the next increment. `None` when its rate is suspect.
    fn advance(
        &mut self,
        increment: &Increment,
        dt: f32,
        (p, c): (&Matrix3<f32>, &Vector3<f32>),
    ) -> Option<(Matrix3<f32>, Vector3<f32>)> {
        let Some(raw) = increment.rate else {
            self.rates = None;
            return None;
        };
        let rate = times(p, &raw) - c;
        // After a missing rate the rotation is anyone's guess, and the node that comes is marked so.
        let [earlier, before] = self.rates.unwrap_or([rate; 2]);
        let turn = middle_to_middle([&earlier, &before, &rate], dt);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&turn)));
        self.rates = Some([before, rate]);
        Some((matrix(&self.attitude), rate))
    }

    /// The sensitivity grows by some increments.
    #[inline(never)]
    fn grow(&mut self, latest: &MotionSum, dt: f32) {
        let (rotation, raw) = latest.factors();
        let angles = raw * dt;
        for (i, row) in self.sensitivity.iter_mut().enumerate() {
            for j in 0..3 {
                let r = rotation[(i, j)];
                row[3 * j] += r * angles.x;
                row[3 * j + 1] += r * angles.y;
                row[3 * j + 2] += r * angles.z;
                row[9 + j] -= r * dt;
            }
        }
    }
}

/// Sum of a vector.
#[derive(Clone, Copy)]
struct Mean {
    sum: Vector3<f32>,
    count: f32,
}

impl Mean {
    const fn zero() -> Self {
        Self { sum: Vector3::new(0.0, 0.0, 0.0), count: 0.0 }
    }

    fn add(&mut self, v: Vector3<f32>) {
        self.sum += v;
        self.count += 1.0;
    }

    /// The mean's unit vector and norm.
    fn direction(&self, least_count: f32, least_norm: f32) -> Option<(Vector3<f32>, f32)> {
        let norm = self.sum.norm();
        (self.count >= least_count && norm > least_norm * self.count).then(|| (self.sum / norm, norm / self.count))
    }
}

fn add_vectors(
    [gravity_mean, field_mean]: &mut [Mean; 2],
    increment: &Increment,
    rotation: &Matrix3<f32>,
    rate: &Vector3<f32>,
    effects: &VectorEffects,
) {
    if let Some(gravity) = increment.gravity {
        gravity_mean.add(times(rotation, &gravity));
    }
    if let Some(field) = increment.field {
        // Measured v(t - tau) + iron. The field at t is that of t - tau turned back by the body's rotation since: first order in
        // tau w, 0.5 % of the field at 10 ms and 600 deg/s.
        let clean = field - effects.hard_iron_ut;
        field_mean.add(times(rotation, &(clean - rate.cross(&clean) * effects.mag_lag_s)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::{IncrementRing, Scales};

    const NO_EFFECTS: VectorEffects = VectorEffects { mag_lag_s: 0.0, hard_iron_ut: Vector3::new(0.0, 0.0, 0.0) };

    /// A steadily spinning body: every de-rotated sample is the same vector, so each node's is the one at the beginning.
    #[test]
    fn the_mean_of_a_spinning_body_is_the_vector_at_the_beginning() {
        let grid = Grid::new(20_000);
        let mut ring = IncrementRing::<128>::zero();
        ring.start(Scales::new(40.0, 160.0, 1000.0));
        let rate = Vector3::new(0.4, -0.2, 2.6);
        let effects = VectorEffects { mag_lag_s: 0.011, hard_iron_ut: Vector3::new(4.0, -9.0, 2.0) };
        let body = |t: f32, v: Vector3<f32>| nalgebra::Rotation3::from_scaled_axis(-rate * t) * v;
        for k in 0..100 {
            let t = k as f32 * 0.02;
            let field = body(t - effects.mag_lag_s, Vector3::new(20.0, 3.0, 44.0)) + effects.hard_iron_ut;
            ring.push(&Increment {
                rate: Some(rate),
                gravity: Some(body(t, Vector3::new(0.0, 9.81, 0.0))),
                field: Some(field),
            });
        }
        // The walk's first step turns to the first increment, by one interval.
        let beginning = |v: Vector3<f32>| body(-0.02, v).normalize();
        let mut walk = NodeWalk::start();
        for number in 0..10 {
            let model = (&Matrix3::identity(), &Vector3::zeros());
            let node = walk.node((|index| ring.get(index), grid, 10 * number), model, &effects);
            let [gravity, field] = node.vectors.map(Option::unwrap);
            assert!((gravity.0 - beginning(Vector3::y())).norm() < 2e-4 && (gravity.1 - 9.81).abs() < 0.01);
            // The lag is taken off to first order: (tau w)^2 / 2 = 4e-4.
            assert!((field.0 - beginning(Vector3::new(20.0, 3.0, 44.0))).norm() < 6e-4);
            assert!((node.square_rate - rate.norm_squared()).abs() < 0.01 && !node.broken);
        }
    }

    fn ring() -> IncrementRing<128> {
        let mut ring = IncrementRing::zero();
        ring.start(Scales::new(10.0, 160.0, 1000.0));
        for k in 0..120 {
            let t = k as f32 * 0.02;
            let rate = Vector3::new(libm::sinf(2.0 * t), 1.5 * libm::cosf(3.0 * t), 2.0 + libm::sinf(5.0 * t));
            let gravity = Vector3::new(libm::cosf(t), 8.0, libm::sinf(t));
            let field = Some(Vector3::new(0.0, 50.0, 1.0) * if k < 60 { 1.0 } else { 0.4 });
            ring.push(&Increment { rate: Some(rate), gravity: Some(gravity), field });
        }
        ring
    }

    fn nodes(ring: &IncrementRing<128>, delta: &[f32; 12]) -> [Node; 12] {
        let p = Matrix3::from_fn(|i, j| delta[3 * i + j] + if i == j { 1.0 } else { 0.0 });
        let c = Vector3::new(delta[9], delta[10], delta[11]);
        let mut walk = NodeWalk::start();
        core::array::from_fn(|number| {
            walk.node((|index| ring.get(index), Grid::new(20_000), 10 * number as u32), (&p, &c), &NO_EFFECTS)
        })
    }

    #[test]
    fn the_sensitivity_turns_the_vector_as_the_changed_model_does() {
        let ring = ring();
        let nominal = nodes(&ring, &[0.0; 12])[11];
        for parameter in 0..12 {
            let mut delta = [0.0; 12];
            delta[parameter] = 2e-3;
            let moved = nodes(&ring, &delta)[11].vectors[0].unwrap().0;
            let still = nominal.vectors[0].unwrap().0;
            let turn = Vector3::from(nominal.sensitivity.map(|row| row[parameter] * 2e-3));
            let change = (moved - still).norm();
            // The sensitivity is that of the node's middle.
            let missed = (moved - still - turn.cross(&still)).norm();
            assert!(missed < 0.05 * change + 2e-5, "{parameter}: {missed} of {change}");
        }
    }

    #[test]
    fn a_missing_rate_leaves_no_vectors_and_breaks_the_walk() {
        let mut ring = ring();
        ring.push(&Increment { rate: None, gravity: None, field: None });
        let mut walk = NodeWalk::start();
        let mut node = |from| {
            let model = (&Matrix3::identity(), &Vector3::zeros());
            walk.node((|index| ring.get(index), Grid::new(20_000), from), model, &NO_EFFECTS)
        };
        assert!(!node(0).broken);
        assert_eq!(node(115).vectors, [None; 2]);
        assert!(node(60).broken, "the one after");
    }

    #[test]
    fn a_field_that_loses_more_than_half_is_left_out_once() {
        let seen = nodes(&ring(), &[0.0; 12]).map(|node| node.vectors[1].is_some());
        assert_eq!(seen, core::array::from_fn(|number| number != 6));
    }
}
