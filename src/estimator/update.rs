//! The update that brings the states of a node to the next: its rows, and the elimination of the states.

#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    columns::{GLOBALS, NODE, POSITION, VELOCITY},
    gate::Innovation,
    globals::Globals,
    node::{Kind, Node},
    parameters::Parameters,
    preintegration::Preintegration,
    real::{M3, Real, V3, norm, rotation, square, zero3, zero33},
    rows::{self, Block, CONSTANT, FieldReading, GLOBAL, NEW, PathNoise, ROWS, WIDTH},
    settings::{Noise, Settings},
    square_root::{reflect, reflect_first},
};

/// Zero rate of a rest beyond the gyro's own noise: 0.05 deg/s, the least that a second's reading of the vectors can rule out.
const REST_RATE_RAD_S: f32 = 8.7e-4;
/// Speed at rest, m/s.
const REST_SPEED_M_S: f32 = 0.01;
/// Rows of an update, 36; what the average needs takes two more.
pub(super) const SCRATCH: usize = NODE + ROWS + 2;

/// Blocks of three new rows that have a constant.
#[cfg(feature = "explanation")]
pub(super) const FIELD_READ: usize = 1;
#[cfg(feature = "explanation")]
pub(super) const VELOCITY_BOUND: usize = 5;
#[cfg(feature = "explanation")]
pub(super) const POSITION_BOUND: usize = 6;
#[cfg(feature = "explanation")]
pub(super) const BY_REST: usize = 7;

/// An update in progress, column by column.
#[derive(Clone, Copy)]
pub(super) struct Update<T> {
    /// Rows of the old root, then the new ones; before and after an update scratch memory.
    pub rows: [[T; WIDTH]; SCRATCH],
    next: usize,
    predicted: Predicted<T>,
}

/// Predicted states.
#[derive(Clone, Copy)]
struct Predicted<T> {
    attitude: M3<T>,
    velocity: V3<T>,
    position: V3<T>,
}

/// What a node is made from.
pub(super) struct Taken<'a, T> {
    pub pre: &'a Preintegration<T>,
    pub parameters: &'a Parameters<T>,
    pub globals: &'a Globals<T>,
    pub settings: &'a Settings,
    /// Widths of the priors.
    pub sigma: &'a [T; GLOBALS],
    /// Variance of its rotation by what is not known of bias and P, rad^2.
    pub unknown: T,
    pub kind: Kind,
}

/// What came of a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Readings {
    /// None, or too few.
    Missing,
    Used,
    /// They contradict what is known and were left out.
    Contradicted,
}

/// What came of a node's readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agreement {
    pub field: Readings,
    pub force: Readings,
    /// The field is another by nothing but a turn: not it, the gyro is wrong.
    pub is_turned: bool,
}

fn weight<T: Real>(variance: T) -> T {
    T::ONE / variance.root()
}

impl<T: Real> Update<T> {
    pub const fn zero() -> Self {
        Self {
            rows: [[T::ZERO; WIDTH]; SCRATCH],
            next: 0,
            predicted: Predicted { attitude: zero33(), velocity: zero3(), position: zero3() },
        }
    }

    /// Writes the rows of a node.
    pub fn assemble(&mut self, node: &mut Node<T>, taken: &Taken<T>) -> Agreement {
        self.rows = [[T::ZERO; WIDTH]; SCRATCH];
        self.next = 0;
        for (row, root) in self.rows.iter_mut().zip(&node.root) {
            row[..NODE].copy_from_slice(&root[..NODE]);
            row[GLOBAL..CONSTANT].copy_from_slice(&root[NODE..]);
        }
        self.predicted = predict(node, taken);
        let (_, new) = self.rows.split_at_mut(NODE);
        let (blocks, _) = new.as_chunks_mut::<3>();
        let [rotated, seen, walked, first, second, slow, near, still, ..] = blocks else {
            return Agreement { field: Readings::Missing, force: Readings::Missing, is_turned: false };
        };
        let Taken { pre, settings, sigma, .. } = *taken;
        let noise = &settings.noise;

        rotate(rotated, node, taken);
        let (field, is_turned) = see(seen, node, taken);
        let walk = if taken.kind == Kind::Rest { 0.0 } else { noise.field_walk_rts * noise.field_walk_rts };
        let variance = T::of(walk + 1e-8) * pre.seconds;
        rows::field_walk(Block { rows: walked, weight: weight(variance / peak(noise)), sigma });

        let speed = T::of(if taken.kind == Kind::Rest { REST_SPEED_M_S } else { noise.velocity_m_s });
        let mut force = if pre.forces == pre.increments { Readings::Used } else { Readings::Missing };
        if force == Readings::Used {
            let mut path = [[T::ZERO; WIDTH]; 6];
            // By hand force is what keeps the attitude where a field is wrong for long, and must not be locked out.
            let is_bounded = noise.acceleration_m_s_rts > 0.0;
            if is_bounded && is_path_contradicted(&mut path, node, taken, &self.predicted.velocity, speed) {
                force = Readings::Contradicted;
            } else {
                let path_noise = path_noise(taken, &self.predicted.velocity, speed);
                rows::path(&mut path, sigma, &node.attitude, pre, &path_noise);
                for (slot, row) in first.iter_mut().chain(second).zip(&path) {
                    *slot = *row;
                }
            }
        }
        if force != Readings::Used {
            (self.predicted.velocity, self.predicted.position) = (zero3(), zero3());
        }
        rows::bounds(Block { rows: slow, weight: T::ONE / speed, sigma }, VELOCITY, &self.predicted.velocity);
        let block = Block { rows: near, weight: T::of(1.0 / noise.position_m), sigma };
        rows::bounds(block, POSITION, &self.predicted.position);
        if taken.kind == Kind::Rest {
            let (_, rate) = pre.rate_statistics();
            let block = Block { rows: still, weight: T::of(1.0 / REST_RATE_RAD_S), sigma };
            rows::rest(block, &(rate - taken.parameters.bias));
        }
        Agreement { field, force, is_turned }
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

    /// Whether the rows have been written and none of their states eliminated.
    #[cfg(feature = "explanation")]
    pub const fn is_fresh(&self) -> bool {
        self.next == 0
    }

    /// Sets all constants to zero but those of one block of three rows.
    #[cfg(feature = "explanation")]
    pub fn keep_constants(&mut self, block: usize) {
        let kept = NODE + 3 * block..NODE + 3 * block + 3;
        for (index, row) in self.rows.iter_mut().enumerate() {
            if !kept.contains(&index) {
                row[CONSTANT] = T::ZERO;
            }
        }
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

/// Student's t: what the weight of a residual of zero is above that of a Gaussian.
fn peak<T: Real>(noise: &Noise) -> T {
    T::of((noise.freedom + 3.0) / noise.freedom)
}

fn predict<T: Real>(node: &Node<T>, taken: &Taken<T>) -> Predicted<T> {
    let Taken { pre, settings, .. } = *taken;
    let seconds = pre.seconds;
    let gravity = V3::new(T::ZERO, T::ZERO, T::of(-settings.gravity_m_s2));
    let fallen = node.velocity * seconds + gravity * (seconds * seconds * T::of(0.5));
    Predicted {
        attitude: node.attitude * pre.rotation,
        velocity: node.velocity + node.attitude * pre.velocity.value + gravity * seconds,
        position: node.position + fallen + node.attitude * pre.position.value,
    }
}

/// The gyro's rotation links the attitudes.
fn rotate<T: Real>(rows: &mut [[T; WIDTH]], node: &Node<T>, taken: &Taken<T>) {
    let Taken { pre, settings, sigma, unknown, .. } = *taken;
    let noise = &settings.noise;
    let angle = T::of(noise.rotation_share) * pre.angle;
    // Of a Gaussian error x the linear model leaves x^2 / 2, of mean square 3 / 4 of the squared variance.
    let curvature = T::of(0.75) * unknown * unknown;
    let variance = T::of(noise.rotation_rad_rts * noise.rotation_rad_rts) * pre.seconds + angle * angle + curvature;
    rows::rotation(Block { rows, weight: weight(variance / peak(noise)), sigma }, &node.attitude, &pre.by_gyro);
}

/// The field that was read. Returns whether it was used, and whether it is turned.
fn see<T: Real>(rows: &mut [[T; WIDTH]], node: &mut Node<T>, taken: &Taken<T>) -> (Readings, bool) {
    let Taken { pre, settings, sigma, .. } = *taken;
    let noise = &settings.noise;
    if 2 * pre.fields < pre.increments || pre.fields == 0 {
        return (Readings::Missing, false);
    }
    let share = T::ONE / T::of(f32::from(pre.fields));
    let mean = node.attitude * pre.field * share;
    if !node.has_field {
        (node.field, node.has_field) = (mean, true);
    }
    let length = pre.field_norms * share;
    let innovation = mean - node.field;
    let reading = FieldReading { attitude: &node.attitude, pre, share, mean, innovation };
    let at_rest = if taken.kind == Kind::Rest { noise.field_at_rest } else { 1.0 };
    let own = T::of(noise.field_share * at_rest);
    let own = own * own;
    let scatter = pre.field_variance();
    rows::field(Block { rows: &mut *rows, weight: weight(own), sigma }, &reading);
    let expected = Innovation::new(rows, node, taken.globals);
    // By the usual scatter: that of a field which comes or goes within the node is large.
    if expected.is_contradicted((own + node.norms.scatter().unwrap_or(scatter)) / own) {
        rows.as_flattened_mut().fill(T::ZERO);
        let size = norm(&node.field);
        let longer = (length - size) * weight(own);
        let is_turned = noise.field_is_even && !expected.is_contradicted_along(&(node.field / size), longer);
        return (Readings::Contradicted, is_turned);
    }
    node.norms.add(pre, share);
    let usual = if noise.field_is_even { norm(&node.field) } else { node.norms.of_their_time() };
    let deviation = length / usual - T::ONE;
    // What the readings' own scatter does not explain is the field's.
    let disturbed = deviation * deviation - scatter;
    let disturbed = if disturbed > T::ZERO { disturbed } else { T::ZERO };
    let variance = own + disturbed + scatter;
    let freedom = T::of(noise.freedom);
    let variance = variance * (freedom + square(&innovation) / variance) / (freedom + T::of(3.0));
    rows::field(Block { rows, weight: weight(variance), sigma }, &reading);
    (Readings::Used, false)
}

/// Noise of the velocity's increment by samples of vibration, which alias like white noise of their own rate.
fn aliased_variance<T: Real>(taken: &Taken<T>) -> T {
    let least = T::of(taken.settings.noise.velocity_increment_m_s);
    least * least + taken.pre.mean_vibration() * T::of(taken.settings.sample_period_s) * taken.pre.seconds
}

/// Whether the velocity that the readings of force lead to contradicts its bound. Leaves rows behind that are to be written anew.
fn is_path_contradicted<T: Real>(
    path: &mut [[T; WIDTH]; 6],
    node: &Node<T>,
    taken: &Taken<T>,
    velocity: &V3<T>,
    speed: T,
) -> bool {
    let Taken { pre, settings, sigma, globals, .. } = *taken;
    let white = T::of(settings.noise.acceleration_m_s_rts);
    let variance = white * white * pre.seconds + speed * speed + aliased_variance(taken);
    let weight = weight(variance);
    let only_velocity = PathNoise { velocity: weight, position_by_velocity: T::ZERO, position: T::ONE };
    rows::path(path, sigma, &node.attitude, pre, &only_velocity);
    for (row, velocity) in path.iter_mut().zip(velocity.iter()) {
        row[CONSTANT] = *velocity * weight;
    }
    let is_contradicted = Innovation::new(&path[..3], node, globals).is_contradicted(T::ONE);
    *path = [[T::ZERO; WIDTH]; 6];
    is_contradicted
}

fn path_noise<T: Real>(taken: &Taken<T>, velocity: &V3<T>, speed: T) -> PathNoise<T> {
    let noise = &taken.settings.noise;
    let seconds = taken.pre.seconds;
    if noise.acceleration_m_s_rts > 0.0 && taken.kind == Kind::Moving {
        let white = T::of(noise.acceleration_m_s_rts);
        let freedom = T::of(noise.acceleration_freedom);
        let square = square(velocity) / (white * white * seconds + speed * speed);
        return PathNoise::white(white * ((freedom + square) / (freedom + T::of(3.0))).root(), seconds);
    }
    let aliased = aliased_variance(taken).root();
    PathNoise::independent(aliased, aliased * seconds * T::of(0.5))
}
