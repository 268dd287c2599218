//! A node: the states at one instant, with what is known of them, at a start and after an unknown turn.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    alignment::AFTER_GAP_S,
    columns::{FIELD, GLOBALS, NODE, POSITION, VELOCITY},
    field_norm::FieldNorm,
    real::{M3, Real, V3, norm, rotation, square, zero3, zero33},
    settings::Noise,
};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Deviation of the attitude at a start, rad: from force and field of a moving probe.
const START_TILT_RAD: f32 = 0.35;
/// First value of `Node::curved`, 10 s: then P is known to a percent or two whatever the motion, and a linear model
/// holds.
const MOST_CURVED: u8 = 20;
/// Deviation of the first heading, rad: it is fixed, because it is a gauge as long as the field's direction is free.
const START_HEADING_RAD: f32 = 1e-3;
/// Deviation of the first field, of the norm.
const START_FIELD: f32 = 0.5;

/// States of a node, and what is known of them together with the globals.
#[derive(Clone, Copy)]
pub(super) struct Node<T> {
    /// Body to earth (z up, heading as it happened to be at the start).
    pub attitude: M3<T>,
    /// Attitude at which rows are made linear: all through a rest that of its first node. With a new point in each
    /// node, readings that stay the same would seem to tell of directions that a rest says nothing of.
    pub linear_at: M3<T>,
    /// True from a rest until the probe has turned.
    is_held: bool,
    /// Angle turned since the rest, rad.
    turned: T,
    pub velocity: V3<T>,
    pub position: V3<T>,
    /// Earth field, of the norm.
    pub field: V3<T>,
    pub has_field: bool,
    /// Nodes with a field that are still to come before the attitude is known so closely that a linear model of its
    /// errors holds; 0: it holds.
    pub curved: u8,
    pub norms: FieldNorm<T>,
    /// Nodes in which the declared field has been read.
    pub referred: u8,
    /// Rows of the root: the states, then the globals.
    pub root: [[T; NODE + GLOBALS]; NODE],
}

/// Most that an update turns an attitude, rad: a linear correction is worth nothing beyond.
const MOST_TURN_RAD: f32 = 0.5;

/// Turn by which a rest is over, rad: a degree. A node that is taken for motion by chance turns by less.
const HELD_RAD: f32 = 0.017;

/// Kind of a node's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Moving,
    Rest,
}

impl<T: Real> Node<T> {
    pub const fn zero() -> Self {
        Self {
            attitude: zero33(),
            linear_at: zero33(),
            is_held: false,
            turned: T::ZERO,
            velocity: zero3(),
            position: zero3(),
            field: zero3(),
            has_field: false,
            curved: 0,
            norms: FieldNorm::zero(),
            referred: 0,
            root: [[T::ZERO; NODE + GLOBALS]; NODE],
        }
    }

    /// Aligns the attitude with specific force at an instant; the heading is arbitrary, the field unknown.
    pub fn start(&mut self, force: &V3<T>, noise: &Noise) {
        self.clear();
        let up = force / norm(force);
        // East is across gravity and the body axis that is farthest from it.
        let axis = if up.x * up.x < T::of(0.5) { V3::x() } else { V3::y() };
        let east = axis - up * axis.dot(&up);
        let east = east / norm(&east);
        self.attitude = from_rows(&east, &up.cross(&east), &up);
        self.forget([START_TILT_RAD; 3], noise);
        self.curved = MOST_CURVED;
        self.root[2][2] = T::of(1.0 / START_HEADING_RAD);
        for i in 0..3 {
            self.root[9 + i][9 + i] = T::of(1.0 / START_FIELD);
        }
    }

    /// Resets the node to [`Node::zero`], except `referred`: the globals keep what was read of the declared field. In
    /// place: a returned value would stand on the stack twice, under the deepest calls of a piece of work.
    fn clear(&mut self) {
        let Self { attitude, linear_at, velocity, position, field, norms, root, .. } = self;
        (*attitude, *linear_at) = (zero33(), zero33());
        (*velocity, *position, *field) = (zero3(), zero3(), zero3());
        *norms = FieldNorm::zero();
        root.as_flattened_mut().fill(T::ZERO);
        (self.is_held, self.has_field, self.turned, self.curved) = (false, false, T::ZERO, 0);
    }

    /// Chooses the point at which the rows of a node of this kind, in which the probe turned by so much, are made
    /// linear.
    pub fn choose_point(&mut self, kind: Kind, angle: T) {
        self.turned = if kind == Kind::Rest { T::ZERO } else { self.turned + angle };
        if self.turned > T::of(HELD_RAD) {
            self.is_held = false;
        }
        if !self.is_held {
            self.linear_at = self.attitude;
        }
        self.is_held |= kind == Kind::Rest;
    }

    /// Point at which the next rows will most likely be made linear.
    pub const fn point(&self) -> &M3<T> {
        if self.is_held { &self.linear_at } else { &self.attitude }
    }

    /// Moves the states to their optimum, after the globals moved by `change` and all else added `constants` to the
    /// rows' constants.
    pub fn shift(&mut self, change: &[T; GLOBALS], constants: &[T; NODE]) {
        let mut by = [T::ZERO; NODE];
        for j in (0..NODE).rev() {
            let row = &self.root[j];
            let mut sum = -constants[j];
            for c in 0..GLOBALS {
                sum -= row[NODE + c] * change[c];
            }
            for c in j + 1..NODE {
                sum -= row[c] * by[c];
            }
            by[j] = sum / row[j];
        }
        self.move_by(&by);
    }

    /// Moves the states, but not their heading; limits the turn of the attitude. The heading at the start is a gauge,
    /// and the node's hangs on it by all turns since: P's smallest change would turn attitude and field by much. Each
    /// such turn would be another point to make rows linear at, and these would then seem to tell of the heading, and
    /// through it of P. So the earth frame is turned instead.
    pub fn move_by(&mut self, by: &[T; NODE]) {
        let three = |from: usize| V3::new(by[from], by[from + 1], by[from + 2]);
        let turn = three(0);
        let angle = norm(&turn);
        let most = T::of(MOST_TURN_RAD);
        let turn = if angle > most { turn * (most / angle) } else { turn };
        self.attitude = rotation(&turn) * self.attitude;
        self.velocity += three(VELOCITY);
        self.position += three(POSITION);
        self.field += three(FIELD);
        // Tangent of half of the heading's change, to its third power.
        let tangent = turn.z * T::of(0.5);
        let scale = T::ONE / (T::ONE + tangent * tangent);
        let (cosine, sine) = ((T::ONE - tangent * tangent) * scale, (tangent + tangent) * scale);
        let [a, b, c] = self.attitude.as_mut().each_mut();
        for [x, y, _] in [a, b, c, self.velocity.as_mut(), self.position.as_mut(), self.field.as_mut()] {
            (*x, *y) = (cosine * *x + sine * *y, cosine * *y - sine * *x);
        }
    }

    /// Resets the attitude to these deviations, rad, velocity and position as at a start; keeps the earth field, but
    /// for its walk.
    fn forget(&mut self, [x, y, z]: [f32; 3], noise: &Noise) {
        let (velocity, position) = (noise.velocity_m_s, noise.position_m);
        let sigma = [x, y, z, velocity, velocity, velocity, position, position, position];
        for (i, row) in self.root.iter_mut().take(9).enumerate() {
            *row = [T::ZERO; NODE + GLOBALS];
            row[i] = T::of(1.0 / sigma[i]);
        }
        (self.velocity, self.position) = (zero3(), zero3());
    }

    /// Aligns the attitude with gravity and field after an unknown turn. What is known of earth field and globals
    /// stays. If no field was read or none is known, the heading is a new gauge. Returns the factor of the field's
    /// rows; `None`: nothing of them is kept.
    pub fn realign(&mut self, force: &V3<T>, field: &V3<T>, gap_s: T, noise: &Noise) -> Option<T> {
        let up = force / norm(force);
        let (body, earth) = (field.cross(&up), self.field.cross(&V3::z()));
        // Within 6 deg of gravity a field has no heading.
        let is_seen = self.has_field && square(&body) > T::of(0.01) * square(field);
        let pair = is_seen.then(|| (body / norm(&body), earth / norm(&earth)));
        let Some((body, earth)) = pair else {
            let (norms, curved) = (self.norms, self.curved);
            self.start(force, noise);
            (self.norms, self.curved) = (norms, curved);
            return None;
        };
        let body = from_rows(&body, &up.cross(&body), &up);
        let earth = from_rows(&earth, &V3::z().cross(&earth), &V3::z());
        self.attitude = earth.transpose() * body;
        self.is_held = false;
        let tilt = after_gap_rad(noise);
        // The field's direction in the body is as uncertain as its calibration.
        self.forget([tilt, tilt, START_TILT_RAD], noise);
        if noise.field_is_even {
            // As at a start: what the linear model leaves out would be taken for iron.
            self.curved = MOST_CURVED;
        }
        // The rows below those of attitude, velocity and position are the field's margin. As f walks by w, R f = n
        // becomes R f = n + R w, and R R' is at most as large as the sum of R's squares.
        let walk = T::of(noise.field_walk_rts * noise.field_walk_rts) * gap_s;
        let rows = self.root.iter().skip(FIELD);
        let known = rows.flat_map(|row| row.iter().skip(FIELD).take(3)).fold(T::ZERO, |sum, x| sum + *x * *x);
        let kept = T::ONE / (T::ONE + walk * known).root();
        self.root.iter_mut().skip(FIELD).flatten().for_each(|x| *x *= kept);
        Some(kept)
    }
}

/// Attitude error after a gap, rad: that of the mean force over [`AFTER_GAP_S`], at whose ends the velocity is within
/// its bound, and whose white acceleration has Student's t.
fn after_gap_rad(noise: &Noise) -> f32 {
    let ends = noise.velocity_m_s / AFTER_GAP_S;
    let tails = if noise.acceleration_freedom > 2.0 {
        noise.acceleration_freedom / (noise.acceleration_freedom - 2.0)
    } else {
        1.0
    };
    let white = noise.acceleration_m_s_rts * noise.acceleration_m_s_rts / AFTER_GAP_S * tails;
    libm::sqrtf(2.0 * ends * ends + white) / STANDARD_GRAVITY_M_S2
}

fn from_rows<T: Real>(a: &V3<T>, b: &V3<T>, c: &V3<T>) -> M3<T> {
    M3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)
}

#[cfg(test)]
mod tests;
