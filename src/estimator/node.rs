//! A node: the states at one instant, and the update that brings them to the next.

#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    columns::{GLOBALS, NODE, POSITION, VELOCITY},
    field_norm::FieldNorm,
    parameters::Parameters,
    preintegration::Preintegration,
    real::{M3, Real, V3, norm, rotation, square, zero3, zero33},
    rows::{self, Block, CONSTANT, FieldReading, GLOBAL, NEW, PathNoise, ROWS, WIDTH},
    settings::{Noise, Settings},
    square_root::{reflect, reflect_first},
};

/// Attitude error that a start allows, rad: gravity and field of one instant of motion.
const START_TILT_RAD: f32 = 0.35;
/// The first heading is fixed: it is a gauge, as the field's direction is free.
const START_HEADING_RAD: f32 = 1e-3;
/// The first field, of the norm.
const START_FIELD: f32 = 0.5;
/// Zero rate of a rest beyond the gyro's own noise: 0.05 deg/s, the least that a second's reading of the vectors can rule out.
const REST_RATE_RAD_S: f32 = 8.7e-4;
/// Speed at rest, m/s.
const REST_SPEED_M_S: f32 = 0.01;

/// The states, and what is known of them and of the globals together.
#[derive(Clone, Copy)]
pub(super) struct Node<T> {
    /// Body to earth (z up, heading as it happened to be at the start).
    pub attitude: M3<T>,
    pub velocity: V3<T>,
    pub position: V3<T>,
    /// Earth field, of the norm.
    pub field: V3<T>,
    pub has_field: bool,
    pub norms: FieldNorm<T>,
    /// Rows of the root: the states, then the globals.
    pub root: [[T; NODE + GLOBALS]; NODE],
}

/// What a node's time was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Moving,
    Rest,
}

impl<T: Real> Node<T> {
    pub const fn zero() -> Self {
        Self {
            attitude: zero33(),
            velocity: zero3(),
            position: zero3(),
            field: zero3(),
            has_field: false,
            norms: FieldNorm::zero(),
            root: [[T::ZERO; NODE + GLOBALS]; NODE],
        }
    }

    /// Begins with specific force at an instant; the heading is arbitrary, the field unknown.
    pub fn start(&mut self, force: &V3<T>, noise: &Noise) {
        *self = Self::zero();
        let up = force / norm(force);
        // East is across gravity and the body axis that is farthest from it.
        let axis = if up.x * up.x < T::of(0.5) { V3::x() } else { V3::y() };
        let east = axis - up * axis.dot(&up);
        let east = east / norm(&east);
        self.attitude = from_rows(&east, &up.cross(&east), &up);
        self.forget(noise);
        self.root[2][2] = T::of(1.0 / START_HEADING_RAD);
        for i in 0..3 {
            self.root[9 + i][9 + i] = T::of(1.0 / START_FIELD);
        }
    }

    /// Attitude, velocity and position are as unknown as at a start; the earth field stays, but for its walk.
    fn forget(&mut self, noise: &Noise) {
        let sigma = [START_TILT_RAD, noise.velocity_m_s, noise.position_m];
        for (i, row) in self.root.iter_mut().take(9).enumerate() {
            *row = [T::ZERO; NODE + GLOBALS];
            row[i] = T::of(1.0 / sigma[i / 3]);
        }
        (self.velocity, self.position) = (zero3(), zero3());
    }

    /// After an unknown turn: gravity and field align the attitude anew. What is known of earth field and globals stays. Without a field
    /// in either the heading is a new gauge.
    pub fn realign(&mut self, force: &V3<T>, field: &V3<T>, gap_s: T, noise: &Noise) {
        let up = force / norm(force);
        let (body, earth) = (field.cross(&up), self.field.cross(&V3::z()));
        // Within 6 deg of gravity a field has no heading.
        let is_seen = self.has_field && square(&body) > T::of(0.01) * square(field);
        let pair = is_seen.then(|| (body / norm(&body), earth / norm(&earth)));
        let Some((body, earth)) = pair else {
            let norms = self.norms;
            self.start(force, noise);
            self.norms = norms;
            return;
        };
        let body = from_rows(&body, &up.cross(&body), &up);
        let earth = from_rows(&earth, &V3::z().cross(&earth), &V3::z());
        self.attitude = earth.transpose() * body;
        self.forget(noise);
        // The rows below those of attitude, velocity and position are the field's margin.
        let walk = T::of(noise.field_walk_rts * noise.field_walk_rts) * gap_s;
        let spread = T::ONE / (T::ONE + walk / T::of(noise.field_share * noise.field_share)).root();
        self.root.iter_mut().skip(9).flatten().for_each(|x| *x *= spread);
    }
}

fn from_rows<T: Real>(a: &V3<T>, b: &V3<T>, c: &V3<T>) -> M3<T> {
    M3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)
}

/// Rows of an update, 36; what the average needs takes two more.
const SCRATCH: usize = NODE + ROWS + 2;

/// An update in progress, column by column.
#[derive(Clone, Copy)]
pub(super) struct Update<T> {
    /// Rows of the old root, then the new ones; before and after an update scratch memory.
    pub rows: [[T; WIDTH]; SCRATCH],
    next: usize,
    predicted: Node3<T>,
}

/// Predicted states.
#[derive(Clone, Copy)]
struct Node3<T> {
    attitude: M3<T>,
    velocity: V3<T>,
    position: V3<T>,
}

impl<T: Real> Update<T> {
    pub const fn zero() -> Self {
        Self {
            rows: [[T::ZERO; WIDTH]; SCRATCH],
            next: 0,
            predicted: Node3 { attitude: zero33(), velocity: zero3(), position: zero3() },
        }
    }

    /// Writes the rows of a node. `unknown`: variance of its rotation by what is not known of bias and P, rad^2.
    #[allow(clippy::too_many_lines)]
    pub fn assemble(
        &mut self,
        node: &mut Node<T>,
        pre: &Preintegration<T>,
        parameters: &Parameters<T>,
        (settings, sigma, unknown): (&Settings, &[T; GLOBALS], T),
        kind: Kind,
    ) {
        let noise = &settings.noise;
        let of = |x: f32| T::of(x);
        self.rows = [[T::ZERO; WIDTH]; SCRATCH];
        self.next = 0;
        for (row, root) in self.rows.iter_mut().zip(&node.root) {
            row[..NODE].copy_from_slice(&root[..NODE]);
            row[GLOBAL..CONSTANT].copy_from_slice(&root[NODE..]);
        }
        let seconds = pre.seconds;
        let gravity = V3::new(T::ZERO, T::ZERO, of(-settings.gravity_m_s2));
        let (velocity, position) = (node.attitude * pre.velocity.value, node.attitude * pre.position.value);
        let has_force = pre.forces == pre.increments;
        let half = of(0.5);
        self.predicted = Node3 { attitude: node.attitude * pre.rotation, ..self.predicted };
        (self.predicted.velocity, self.predicted.position) = if has_force {
            (
                node.velocity + velocity + gravity * seconds,
                node.position + node.velocity * seconds + position + gravity * (seconds * seconds * half),
            )
        } else {
            (zero3(), zero3())
        };

        let (_, new) = self.rows.split_at_mut(NODE);
        let (blocks, _) = new.as_chunks_mut::<3>();
        let [rotated, seen, walked, first, second, slow, near, still, ..] = blocks else { return };
        let weight = |variance: T| T::ONE / variance.root();
        // Student's t: of a residual of zero.
        let peak = of((noise.freedom + 3.0) / noise.freedom);

        let angle = of(noise.rotation_share) * pre.angle;
        // Of a Gaussian error x the linear model leaves x^2 / 2, of mean square 3 / 4 of the squared variance.
        let curvature = of(0.75) * unknown * unknown;
        let variance = of(noise.rotation_rad_rts * noise.rotation_rad_rts) * seconds + angle * angle + curvature;
        let block = Block { rows: rotated, weight: weight(variance / peak), sigma };
        rows::rotation(block, &node.attitude, &pre.by_gyro);

        if 2 * pre.fields >= pre.increments && pre.fields > 0 {
            let share = T::ONE / of(f32::from(pre.fields));
            let mean = node.attitude * pre.field * share;
            if !node.has_field {
                (node.field, node.has_field) = (mean, true);
            }
            let length = pre.field_norms * share;
            node.norms.add(pre, share);
            let usual = if noise.norms_of_their_time { node.norms.of_their_time } else { node.norms.at(parameters) };
            let deviation = length / usual - T::ONE;
            let scatter = pre.field_variance();
            // What the readings' own scatter does not explain is the field's.
            let disturbed = deviation * deviation - scatter;
            let disturbed = if disturbed > T::ZERO { disturbed } else { T::ZERO };
            let own = of(noise.field_share * if kind == Kind::Rest { noise.field_at_rest } else { 1.0 });
            let variance = own * own + disturbed + scatter;
            let innovation = mean - node.field;
            let freedom = of(noise.freedom);
            let weight = weight(variance * (freedom + square(&innovation) / variance) / (freedom + of(3.0)));
            let reading = FieldReading { attitude: &node.attitude, pre, share, mean, innovation };
            rows::field(Block { rows: seen, weight, sigma }, &reading);
        }
        let walk = if kind == Kind::Rest { 0.0 } else { noise.field_walk_rts * noise.field_walk_rts };
        rows::field_walk(Block { rows: walked, weight: weight(of(walk + 1e-8) * seconds / peak), sigma });

        let (vibration, dt) = (pre.mean_vibration(), of(settings.sample_period_s));
        let least = of(noise.velocity_increment_m_s);
        // Samples of vibration alias like white noise of their own rate.
        let aliased = (least * least + vibration * dt * seconds).root();
        let speed = of(if kind == Kind::Rest { REST_SPEED_M_S } else { noise.velocity_m_s });
        if has_force {
            let white = noise.acceleration_m_s_rts;
            let path_noise = if white > 0.0 && kind == Kind::Moving {
                let freedom = of(noise.acceleration_freedom);
                let variance = of(white * white) * seconds + speed * speed;
                let square = square(&self.predicted.velocity) / variance;
                PathNoise::white(of(white) * ((freedom + square) / (freedom + of(3.0))).root(), seconds)
            } else {
                PathNoise::independent(aliased, aliased * seconds * half)
            };
            let mut pair = [[T::ZERO; WIDTH]; 6];
            rows::path(&mut pair, sigma, &node.attitude, pre, &path_noise);
            for (slot, row) in first.iter_mut().chain(second).zip(&pair) {
                *slot = *row;
            }
        }
        let block = Block { rows: slow, weight: T::ONE / speed, sigma };
        rows::bounds(block, VELOCITY, &self.predicted.velocity);
        let block = Block { rows: near, weight: of(1.0 / noise.position_m), sigma };
        rows::bounds(block, POSITION, &self.predicted.position);
        if kind == Kind::Rest {
            let (_, rate) = pre.rate_statistics();
            let block = Block { rows: still, weight: of(1.0 / REST_RATE_RAD_S), sigma };
            rows::rest(block, &(rate - parameters.bias));
        }
    }

    /// Eliminates the next column; `false` when all states are done. The rows from [`Update::left_over`] then say what the node says of
    /// the globals.
    pub fn eliminate(&mut self) -> bool {
        let column = self.next;
        if column >= 2 * NODE {
            return false;
        }
        let (old, new) = self.rows.split_at_mut(NODE);
        if column < NODE {
            if let Some(pivot) = old.get_mut(column) {
                reflect(pivot, new, column);
            }
        } else if let Some(rows) = new.get_mut(column - NEW..) {
            reflect_first(rows, column);
        }
        self.next += 1;
        true
    }

    /// Rows that hold the globals alone.
    pub fn left_over(&mut self) -> &mut [[T; WIDTH]] {
        self.rows.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default()
    }

    /// Sum of the squared innovations, once the globals have all their columns: chi-square of the rows less the states.
    pub fn innovation(&self) -> T {
        let left = self.rows.get(2 * NODE..NODE + ROWS).unwrap_or_default();
        left.iter().fold(T::ZERO, |sum, row| sum + row[CONSTANT] * row[CONSTANT])
    }

    /// Moves the states, given the change of the globals.
    pub fn finish(&self, node: &mut Node<T>, change: &[T; GLOBALS]) {
        let rows = &self.rows[NODE..2 * NODE];
        let mut by = [T::ZERO; NODE];
        for j in (0..NODE).rev() {
            let row = &rows[j];
            let mut sum = -row[CONSTANT];
            for c in 0..GLOBALS {
                sum -= row[GLOBAL + c] * change[c];
            }
            for c in j + 1..NODE {
                sum -= row[NEW + c] * by[c];
            }
            by[j] = sum / row[NEW + j];
        }
        for (root, row) in node.root.iter_mut().zip(rows) {
            root[..NODE].copy_from_slice(&row[NEW..NEW + NODE]);
            root[NODE..].copy_from_slice(&row[GLOBAL..CONSTANT]);
        }
        let three = |from: usize| V3::new(by[from], by[from + 1], by[from + 2]);
        let turn = three(0);
        let angle = norm(&turn);
        let most = T::of(0.5);
        let turn = if angle > most { turn * (most / angle) } else { turn };
        node.attitude = rotation(&turn) * self.predicted.attitude;
        node.velocity = self.predicted.velocity + three(VELOCITY);
        node.position = self.predicted.position + three(POSITION);
        node.field += three(9);
    }
}
