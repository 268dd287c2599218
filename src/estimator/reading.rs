//! Readings of a node: the predicted states, and the rows of rotation, field and path with their noise.

use super::{
    columns::{GLOBALS, HARD_IRON, MAG_MATRIX},
    gate::{Innovation, attitude_variance, may_contradict},
    globals::Globals,
    node::{Kind, Node},
    parameters::Parameters,
    preintegration::Preintegration,
    real::{M3, Real, V3, norm, square},
    rows::{self, Block, CONSTANT, FieldReading, PathNoise, ReferenceRows, WIDTH},
    settings::{Noise, Settings},
};

/// Predicted states.
#[derive(Clone, Copy)]
pub(super) struct Predicted<T> {
    pub attitude: M3<T>,
    pub velocity: V3<T>,
    pub position: V3<T>,
}

/// Inputs of a node's rows.
pub(super) struct Taken<'a, T> {
    pub pre: &'a Preintegration<T>,
    pub parameters: &'a Parameters<T>,
    pub globals: &'a Globals<T>,
    pub settings: &'a Settings,
    /// Unit of the field, microtesla.
    pub field_unit: T,
    /// Widths of the priors.
    pub sigma: &'a [T; GLOBALS],
    /// Variance of the node's rotation by the uncertainty of bias and P, rad^2.
    pub unknown: T,
    pub kind: Kind,
}

/// Fate of a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Readings {
    /// None, or too few.
    Missing,
    Used,
    /// They contradict what is known and were left out.
    Contradicted,
}

/// Fate of a node's readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agreement<T> {
    pub field: Readings,
    pub force: Readings,
    /// True if the field differs by nothing but a turn: then the gyro is wrong, and not the field.
    pub is_turned: bool,
    /// The field's innovation in units of its deviations, earth frame.
    pub innovation: Option<V3<T>>,
}

pub(super) fn weight<T: Real>(variance: T) -> T {
    T::ONE / variance.root()
}

/// Student's t: weight of a residual of zero over that of a Gaussian.
pub(super) fn peak<T: Real>(noise: &Noise) -> T {
    T::of((noise.freedom + 3.0) / noise.freedom)
}

pub(super) fn predict<T: Real>(node: &Node<T>, taken: &Taken<T>) -> Predicted<T> {
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

/// Writes the rows of the rotation: the gyro links the attitudes of the old and the new node.
pub(super) fn rotate<T: Real>(rows: &mut [[T; WIDTH]], node: &Node<T>, taken: &Taken<T>) {
    let Taken { pre, settings, sigma, unknown, .. } = *taken;
    let noise = &settings.noise;
    let angle = T::of(noise.rotation_share) * pre.angle;
    // A Gaussian error x leaves x^2 / 2 in the linear model, of mean square 3 / 4 of the squared variance.
    let unknown = unknown + pre.unread_turn;
    let curvature = T::of(0.75) * unknown * unknown;
    let noise = T::of(noise.rotation_rad_rts * noise.rotation_rad_rts) * pre.seconds + angle * angle;
    let variance = noise + pre.unread_turn + curvature;
    rows::rotation(
        Block { rows, weight: weight(variance / peak(&settings.noise)), sigma },
        &node.linear_at,
        &pre.by_gyro,
    );
}

/// Nodes over which the declared field is read, 20 s of motion: each takes so small a part of its information that by
/// the last the field's own errors are known, and a linear model holds.
pub(super) const REFERRED: u8 = 40;

/// Declared field with its deviations, in units of the estimator's field; `None` without one, or before the unit is
/// known.
fn declared<T: Real>(settings: &Settings, field_unit: T) -> Option<rows::Declared<T>> {
    let reference = settings.reference.filter(|_| field_unit > T::ZERO)?;
    let matrix = settings.sigma.get(MAG_MATRIX.from).copied().unwrap_or(0.0);
    // The estimator's matrix has no scale of the field: the reading's own is an error of the norm.
    let norm = T::of(reference.norm_ut) / field_unit;
    let of_norm = T::of(reference.norm_sigma_ut) / field_unit;
    let of_norm = of_norm * of_norm + T::of(matrix * matrix) * norm * norm;
    Some(rows::Declared {
        norm: [norm, of_norm.root()],
        dip_sine: [T::of(reference.dip_sine), T::of(reference.dip_sine_sigma)],
    })
}

/// Rows of the declared field, as far as it has been read, for the magnetometer's errors `x`, of these widths; `None`
/// if none of it has been read, or the field that is estimated is not to be relied on.
pub(super) fn reference_rows<T: Real>(
    node: &Node<T>,
    (settings, field_unit): (&Settings, T),
    (x, widths): (&[T; GLOBALS], &[T; GLOBALS]),
) -> Option<ReferenceRows<T>> {
    let declared = declared(settings, field_unit).filter(|_| node.referred > 0 && is_at_declared(node, settings))?;
    let weight = (T::of(f32::from(node.referred)) / T::of(f32::from(REFERRED))).root();
    Some(rows::reference_rows(&node.field, &node.attitude, &declared, (weight, x, widths)))
}

/// Returns true if a linear model of the attitude's errors holds, and the dip may be the declared one.
fn is_at_declared<T: Real>(node: &Node<T>, settings: &Settings) -> bool {
    let Some(reference) = settings.reference.filter(|_| node.has_field && node.curved == 0) else { return false };
    let [iron, matrix] = [HARD_IRON, MAG_MATRIX].map(|group| settings.sigma.get(group.from).copied().unwrap_or(0.0));
    let of_iron = iron * iron + matrix * matrix;
    let of_dip = reference.dip_sine_sigma * reference.dip_sine_sigma;
    let far = rows::dip_sine(&node.field) - T::of(reference.dip_sine);
    far * far <= T::of(rows::ANOTHER_FIELD * rows::ANOTHER_FIELD * (of_iron + of_dip))
}

/// Writes the rows that the earth field of the node is the declared one.
pub(super) fn refer<T: Real>(rows: &mut [[T; WIDTH]], node: &mut Node<T>, taken: &Taken<T>) {
    let Some(declared) = declared(taken.settings, taken.field_unit) else { return };
    if node.referred >= REFERRED || !is_at_declared(node, taken.settings) {
        return;
    }
    node.referred += 1;
    let shares = T::of(f32::from(REFERRED)).root();
    let part = |[value, deviation]: [T; 2]| [value, deviation * shares];
    let declared = rows::Declared { norm: part(declared.norm), dip_sine: part(declared.dip_sine) };
    rows::reference(Block { rows, weight: T::ONE, sigma: taken.sigma }, &node.field, &declared);
}

/// Fate of the field that was read.
pub(super) struct Seen<T> {
    pub readings: Readings,
    pub is_turned: bool,
    /// Innovation in units of its deviations, earth frame.
    pub innovation: Option<V3<T>>,
}

/// Writes the rows of the field that was read.
pub(super) fn see<T: Real>(rows: &mut [[T; WIDTH]], node: &mut Node<T>, taken: &Taken<T>) -> Seen<T> {
    let Taken { pre, settings, sigma, .. } = *taken;
    let noise = &settings.noise;
    if pre.fields == 0 || node.norms.has_too_few(pre) {
        return Seen { readings: Readings::Missing, is_turned: false, innovation: None };
    }
    let share = T::ONE / T::of(f32::from(pre.fields));
    let mean = node.attitude * pre.field * share;
    if !node.has_field {
        (node.field, node.has_field) = (mean, true);
    }
    let length = pre.field_norms * share;
    let innovation = mean - node.field;
    let reading =
        FieldReading { attitude: &node.linear_at, pre, share, mean: node.linear_at * pre.field * share, innovation };
    let at_rest = if taken.kind == Kind::Rest { noise.field_at_rest } else { 1.0 };
    let own = T::of(noise.field_share * at_rest);
    // A reading is a mean over some time between none and a sample period: across the axis it is shorter by up to
    // angle^2 / 24.
    let turn = pre.angle / pre.seconds * T::of(settings.sample_period_s);
    let shorter = turn * turn / T::of(24.0);
    // The turn in lost samples lies between the field's readings.
    let own = own * own + shorter * shorter + pre.unread_turn;
    let scatter = pre.field_variance();
    rows::field(Block { rows: &mut *rows, weight: weight(own), sigma }, &reading);
    let expected = Innovation::new(rows, node, taken.globals);
    // The gate takes the usual scatter: that of a field which comes or goes within the node is large.
    let noise_of_own = (own + node.norms.scatter().unwrap_or(scatter)) / own;
    if expected.is_contradicted(noise_of_own) {
        rows.as_flattened_mut().fill(T::ZERO);
        let size = norm(&node.field);
        let longer = (length - size) * weight(own);
        let is_turned =
            noise.field_is_even && !expected.is_contradicted_along(&(node.field / size), longer, noise_of_own);
        return Seen { readings: Readings::Contradicted, is_turned, innovation: None };
    }
    node.norms.add(pre, share);
    let usual = if noise.field_is_even { norm(&node.field) } else { node.norms.of_their_time() };
    let deviation = length / usual - T::ONE;
    // A deviation of the norm beyond the readings' scatter is a disturbance of the field.
    let disturbed = deviation * deviation - scatter;
    let disturbed = if disturbed > T::ZERO { disturbed } else { T::ZERO };
    let mut variance = own + disturbed + scatter;
    if node.curved > 0 {
        // An error x leaves x^2 / 2 in the linear model, of mean square half the squared sum of the variances. This
        // goes with the rotation, and would be taken for iron.
        let turned = attitude_variance(node, taken.globals);
        let curvature = T::of(0.5) * turned * turned;
        node.curved = if curvature < own { 0 } else { node.curved - 1 };
        variance += curvature;
    }
    let in_deviations = expected.in_deviations(variance / own);
    let freedom = T::of(noise.freedom);
    let variance = variance * (freedom + square(&innovation) / variance) / (freedom + T::of(3.0));
    rows::field(Block { rows, weight: weight(variance), sigma }, &reading);
    Seen { readings: Readings::Used, is_turned: false, innovation: Some(in_deviations) }
}

/// Noise of the velocity's increment by samples of vibration, which alias like white noise of their own rate.
fn aliased_variance<T: Real>(taken: &Taken<T>) -> T {
    let least = T::of(taken.settings.noise.velocity_increment_m_s);
    let vibration = taken.pre.mean_vibration() * T::of(taken.settings.sample_period_s) * taken.pre.seconds;
    least * least + vibration + unread_variance(taken)
}

/// Noise of the velocity's increment by lost samples: their force, and the turn that tilts gravity from then on.
fn unread_variance<T: Real>(taken: &Taken<T>) -> T {
    let fallen = T::of(taken.settings.gravity_m_s2) * taken.pre.seconds;
    taken.pre.unread_velocity + taken.pre.unread_turn * fallen * fallen
}

/// Returns true if the velocity from the readings of force contradicts its bound. `path` is scratch room for rows, zero
/// before and after.
pub(super) fn is_path_contradicted<T: Real>(
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
    if !may_contradict(&(velocity * weight)) {
        return false;
    }
    let only_velocity = PathNoise { velocity: weight, position_by_velocity: T::ZERO, position: T::ONE };
    rows::path(path, sigma, &node.linear_at, pre, &only_velocity);
    for (row, velocity) in path.iter_mut().zip(velocity.iter()) {
        row[CONSTANT] = *velocity * weight;
    }
    let is_contradicted = Innovation::new(&path[..3], node, globals).is_contradicted(T::ONE);
    *path = [[T::ZERO; WIDTH]; 6];
    is_contradicted
}

pub(super) fn path_noise<T: Real>(taken: &Taken<T>, velocity: &V3<T>, speed: T) -> PathNoise<T> {
    let noise = &taken.settings.noise;
    let seconds = taken.pre.seconds;
    if noise.acceleration_m_s_rts > 0.0 && taken.kind == Kind::Moving {
        let white = T::of(noise.acceleration_m_s_rts);
        let freedom = T::of(noise.acceleration_freedom);
        let square = square(velocity) / (white * white * seconds + speed * speed);
        let density = white * white * ((freedom + square) / (freedom + T::of(3.0))) + unread_variance(taken) / seconds;
        return PathNoise::white(density.root(), seconds);
    }
    let aliased = aliased_variance(taken).root();
    PathNoise::independent(aliased, aliased * seconds * T::of(0.5))
}
