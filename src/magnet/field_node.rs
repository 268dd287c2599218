//! Node of the field filter: rotation and mean field of a fifth of a second, with derivatives.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use crate::{
    change::UNSEEN_RATE_RAD_S,
    magnet::increment::Increment,
    rotation::{IDENTITY, exp_quaternion, matrix, middle_to_middle, renormalised},
};
use nalgebra::{Matrix3, Quaternion, Vector3};

/// Number of the gyro's errors: P row by row, then c, in w = (P0 + dP) (raw - b0) - c.
pub(super) const GYRO: usize = 12;

/// Means over some increments in the frame that the nominal gyro carries along. In this frame an earth-fixed field
/// turns only by the gyro's error; a body-fixed one turns with the body.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldNode {
    /// Mean of R0 m, microtesla.
    pub field_ut: Vector3<f32>,
    /// Mean of R0, body to frame.
    pub rotation: Matrix3<f32>,
    /// Mean of R0 (w x m), microtesla per second: the change of the field by one second of lag.
    pub lag_ut_s: Vector3<f32>,
    /// Mean of R0 [w]x, radians per second: the part of that change per body-fixed offset, which does not lag.
    pub spin_rad_s: Matrix3<f32>,
    /// Integral of R0 times the rate's derivative by each of the gyro's errors: wrong angle of the frame per
    /// error.
    pub turn: [[f32; GYRO]; 3],
    /// Angle turned, radians: integral of the rate's norm.
    pub angle_rad: f32,
    /// Angle that may have been turned while no rate was read, radians.
    pub unseen_rad: f32,
    /// Length of the node, seconds.
    pub time_s: f32,
    /// Number of increments with a field.
    pub fields: u16,
    /// Number of increments, of about a fiftieth of a second, and of those without a rate.
    pub increments: u8,
    pub without_rate: u8,
}

impl FieldNode {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            field_ut: zero,
            rotation: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            lag_ut_s: zero,
            spin_rad_s: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            turn: [[0.0; GYRO]; 3],
            angle_rad: 0.0,
            unseen_rad: 0.0,
            time_s: 0.0,
            fields: 0,
            increments: 0,
            without_rate: 0,
        }
    }

    /// Returns true if the gyro was silent for more than half of the node: what turned with the body cannot be told.
    pub fn is_unseen(&self) -> bool {
        2 * self.without_rate > self.increments
    }
}

/// Builder of nodes from increments.
pub(super) struct FieldNodes {
    /// Nominal P, and the bias subtracted before it, rad/s.
    p: Matrix3<f32>,
    bias_rad_s: Vector3<f32>,
    attitude: Quaternion<f32>,
    /// Nominal rates of the last two increments.
    rates: [Vector3<f32>; 2],
    sum: FieldNode,
}

impl FieldNodes {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            p: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            bias_rad_s: zero,
            attitude: Quaternion::new(0.0, 0.0, 0.0, 0.0),
            rates: [zero; 2],
            sum: FieldNode::zero(),
        }
    }

    pub fn start(&mut self, p: Matrix3<f32>, bias_rad_s: Vector3<f32>) {
        *self = Self { p, bias_rad_s, attitude: IDENTITY, ..Self::zero() };
    }

    /// Sets the bias to subtract from now on. Returns the resulting change of c.
    pub fn set_bias(&mut self, bias_rad_s: Vector3<f32>) -> Vector3<f32> {
        let change = self.p * (bias_rad_s - self.bias_rad_s);
        self.bias_rad_s = bias_rad_s;
        change
    }

    /// Marks the frame as lost, after a gap in time: fields from before it have no part in a node after it.
    pub fn interrupt(&mut self) {
        self.sum = FieldNode { unseen_rad: core::f32::consts::PI, ..FieldNode::zero() };
    }

    /// Takes one increment of `interval_s` seconds. Returns the node that it completes, at least `node_s`
    /// long.
    pub fn push(&mut self, increment: &Increment, interval_s: f32, node_s: f32) -> Option<FieldNode> {
        let [earlier, before] = self.rates;
        let centred = increment.rate.map(|raw| raw - self.bias_rad_s);
        let rate = centred.map_or(before, |raw| self.p * raw);
        let turn = middle_to_middle([&earlier, &before, &rate], interval_s);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&turn)));
        self.rates = [before, rate];
        let rotation = matrix(&self.attitude);
        let speed = libm::sqrtf(rate.norm_squared());
        let sum = &mut self.sum;
        match centred {
            Some(raw) => {
                for (i, row) in sum.turn.iter_mut().enumerate() {
                    for j in 0..3 {
                        let gain = rotation[(i, j)] * interval_s;
                        row[3 * j] += gain * raw.x;
                        row[3 * j + 1] += gain * raw.y;
                        row[3 * j + 2] += gain * raw.z;
                        row[9 + j] -= gain;
                    }
                }
            }
            None => {
                sum.unseen_rad += (speed + UNSEEN_RATE_RAD_S) * interval_s;
                sum.without_rate += 1;
            }
        }
        if let Some(field) = increment.field {
            sum.field_ut += rotation * field;
            sum.rotation += rotation;
            let spin = rotation * rate.cross_matrix();
            sum.lag_ut_s += spin * field;
            sum.spin_rad_s += spin;
            sum.fields += 1;
        }
        sum.increments += 1;
        sum.angle_rad += speed * interval_s;
        sum.time_s += interval_s;
        if sum.time_s + 0.5 * interval_s < node_s {
            return None;
        }
        let mut node = core::mem::replace(sum, FieldNode::zero());
        if node.fields > 0 {
            let share = 1.0 / f32::from(node.fields);
            node.field_ut *= share;
            node.rotation *= share;
            node.lag_ut_s *= share;
            node.spin_rad_s *= share;
        }
        Some(node)
    }
}
