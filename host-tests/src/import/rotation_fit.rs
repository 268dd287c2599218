//! Order of the gyro's axes against a vector sensor's: a vector `v` that stands still in the earth turns in
//! the body as `dv/dt = v x w`. Least squares over all signed orders of the axes, each with its scale, says
//! which of them makes the gyro turn the vector as it turns.

use super::median::median;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Length over which readings are averaged: short against a turn, long against vibration, seconds.
const BLOCK_S: f64 = 0.05;
/// Share of its median by which the vector's length may be off where it counts.
const UNDISTURBED: f64 = 0.05;
/// Share of the vector's turning that the best order must explain before it counts as evidence.
const EXPLAINED: f64 = 0.6;
/// The best order leaves at most this share of what the given one leaves, before that counts as wrong, where
/// the motion does not tell every axis.
const LEFT: f64 = 0.5;
/// The same share as [`EXPLAINED`], where every axis shows by itself.
const EXPLAINED_WHERE_ALL_IS_SEEN: f64 = 0.4;
/// Deviations of an element within which it has to be known: three, and noise has a memory of several blocks.
const KNOWN: f64 = 6.0;
/// Largest distance of an element from that of an order: half of the way to the next.
const NEAR: f64 = 0.5;

/// A signed order of axes: the body's axis i is `sign` times axis `from` of the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes(pub [(usize, i8); 3]);

impl Axes {
    /// As it is.
    pub const IDENTITY: Self = Self([(0, 1), (1, 1), (2, 1)]);

    /// All 48.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
        let sign = |bits: usize, axis: usize| if bits >> axis & 1 == 1 { -1 } else { 1 };
        let signed = |order: [usize; 3]| {
            (0..8).map(move |bits| Self(std::array::from_fn(|axis| (order[axis], sign(bits, axis)))))
        };
        orders.into_iter().flat_map(signed).collect()
    }

    /// As a matrix.
    #[must_use]
    pub fn matrix(self) -> Matrix3<f64> {
        let mut matrix = Matrix3::zeros();
        for (axis, (from, sign)) in self.0.into_iter().enumerate() {
            matrix[(axis, from)] = f64::from(sign);
        }
        matrix
    }

    /// The order of a matrix of zeros and ones.
    #[must_use]
    pub fn of(matrix: &Matrix3<f64>) -> Self {
        Self(std::array::from_fn(|axis| {
            let from = matrix.row(axis).iter().position(|x| x.abs() > 0.5).unwrap_or(axis);
            (from, if matrix[(axis, from)] < 0.0 { -1 } else { 1 })
        }))
    }

    /// Number of axes that are not as they were.
    #[must_use]
    pub fn changed(self) -> usize {
        self.0.iter().zip(Self::IDENTITY.0).filter(|(a, b)| **a != *b).count()
    }
}

/// Result of the fit of the gyro to one vector sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationFit {
    /// The order of the gyro's axes that fits best; the given one unless another leaves far less.
    pub axes: Axes,
    /// Factor by which the gyro's rates have to be multiplied.
    pub scale: f64,
    /// Share of the vector's turning that this explains.
    pub explained: f64,
}

/// Fits a gyro to a vector sensor; `None` where the motion does not tell. Times in microseconds.
#[must_use]
pub fn fit(t_us: &[i64], gyro: &[[f64; 4]], vector: &[[f64; 4]]) -> Option<RotationFit> {
    let mut blocks = blocks(t_us, gyro, vector);
    let typical = median(blocks.iter().map(|block| block.vector.norm()))?;
    // A vector of another length is not the earth's alone.
    blocks.retain(|block| (block.vector.norm() - typical).abs() < UNDISTURBED * typical);
    let mut normal = SMatrix::<f64, 12, 12>::zeros();
    let (mut right, mut square) = (SVector::<f64, 12>::zeros(), 0.0);
    for Step { step_s, change, v, w } in steps(&blocks) {
        let cross = v.cross_matrix() * step_s;
        for row in 0..3 {
            // Unknowns: the matrix row by row, then the bias.
            let coefficients = SVector::<f64, 12>::from_fn(|index, _| {
                if index < 9 { cross[(row, index / 3)] * w[index % 3] } else { cross[(row, index - 9)] }
            });
            normal += coefficients * coefficients.transpose();
            right += coefficients * change[row];
            square += change[row] * change[row];
        }
    }
    // The bias out of all: what it takes up, no order has to explain.
    let bias = normal.fixed_view::<3, 3>(9, 9).into_owned().try_inverse()?;
    let mixed = normal.fixed_view::<9, 3>(0, 9).into_owned();
    let reduced = normal.fixed_view::<9, 9>(0, 0) - mixed * bias * mixed.transpose();
    let right_bias = right.fixed_rows::<3>(9).into_owned();
    let right = right.fixed_rows::<9>(0) - mixed * bias * right_bias;
    let nothing = square - (right_bias.transpose() * bias * right_bias)[0];
    let of = |axes: Axes| {
        let matrix = axes.matrix();
        let m = SVector::<f64, 9>::from_fn(|index, _| matrix[(index / 3, index % 3)]);
        let (along, length) = (right.dot(&m), (m.transpose() * reduced * m)[0]);
        let scale = if length > 0.0 { (along / length).max(0.0) } else { 0.0 };
        (scale, nothing - 2.0 * scale * along + scale * scale * length)
    };
    let (scale, left) = of(Axes::IDENTITY);
    if let Some(axes) = of_matrix(&reduced, &right, nothing, 3.0 * blocks.len() as f64) {
        let (scale, left) = of(axes);
        let explained = 1.0 - left / nothing;
        return (explained > EXPLAINED_WHERE_ALL_IS_SEEN).then_some(RotationFit { axes, scale, explained });
    }
    let (best, (best_scale, best_left)) =
        Axes::all().into_iter().map(|axes| (axes, of(axes))).min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    let is_better = best_left < LEFT * left && {
        let [best, given] = [best, Axes::IDENTITY].map(|axes| left_beside_offset(&blocks, axes));
        best < LEFT * given
    };
    let (axes, scale, left) = if is_better { (best, best_scale, best_left) } else { (Axes::IDENTITY, scale, left) };
    let explained = 1.0 - left / nothing;
    (explained.is_finite() && explained > EXPLAINED).then_some(RotationFit { axes, scale, explained })
}

/// The order that the best matrix of all is nearest to; `None` where the motion does not tell each of its
/// elements. An order with one scale alone would be led by errors of the axis that turns fastest.
fn of_matrix(reduced: &SMatrix<f64, 9, 9>, right: &SVector<f64, 9>, nothing: f64, rows: f64) -> Option<Axes> {
    let inverse = reduced.cholesky()?.inverse();
    let any = inverse * right;
    let noise = (nothing - right.dot(&any)).max(0.0) / rows;
    let matrix = Matrix3::from_row_slice(any.as_slice());
    let scale = matrix.determinant().abs().cbrt();
    let is_told = inverse.diagonal().iter().all(|variance| KNOWN * (noise * variance).sqrt() < NEAR * scale);
    let mut axes = Axes::IDENTITY;
    for (axis, place) in axes.0.iter_mut().enumerate() {
        let from = matrix.row(axis).iamax_full().1;
        *place = (from, if matrix[(axis, from)] < 0.0 { -1 } else { 1 });
    }
    let far = (matrix / scale - axes.matrix()).amax();
    (is_told && scale > 0.0 && far < NEAR).then_some(axes)
}

/// What an order of axes leaves of the vector's turning beside an offset of the vector, such as a hard iron: with the
/// rate that an axis of the gyro reads of a faster one, that looks like turns about the slower axis.
fn left_beside_offset(blocks: &[Block], axes: Axes) -> f64 {
    let matrix = axes.matrix();
    // Unknowns: the scale, the offset times the scale, the bias.
    let mut normal = SMatrix::<f64, 7, 7>::zeros();
    let (mut right, mut square) = (SVector::<f64, 7>::zeros(), 0.0);
    for Step { step_s, change, v, w } in steps(blocks) {
        let turn = matrix * w * step_s;
        let mut rows = SMatrix::<f64, 3, 7>::zeros();
        rows.set_column(0, &v.cross(&turn));
        rows.fixed_columns_mut::<3>(1).copy_from(&turn.cross_matrix());
        rows.fixed_columns_mut::<3>(4).copy_from(&(v.cross_matrix() * step_s));
        normal += rows.transpose() * rows;
        right += rows.transpose() * change;
        square += change.norm_squared();
    }
    let solved = normal.cholesky().map(|root| root.solve(&right)).filter(|solved| solved[0] > 0.0);
    solved.map_or(square, |solved| square - solved.dot(&right))
}

/// From one block to the next: seconds, change of the vector, and the means of vector and rate.
struct Step {
    step_s: f64,
    change: Vector3<f64>,
    v: Vector3<f64>,
    w: Vector3<f64>,
}

fn steps(blocks: &[Block]) -> impl Iterator<Item = Step> + '_ {
    let step = |(before, after): (&Block, &Block)| Step {
        step_s: after.t_s - before.t_s,
        change: after.vector - before.vector,
        v: (before.vector + after.vector) / 2.0,
        w: (before.rate + after.rate) / 2.0,
    };
    blocks.iter().zip(blocks.iter().skip(1)).map(step).filter(|step| step.step_s <= 4.0 * BLOCK_S)
}

struct Block {
    t_s: f64,
    rate: Vector3<f64>,
    vector: Vector3<f64>,
}

/// Means over blocks; a block without a reading of either sensor is left out.
fn blocks(t_us: &[i64], gyro: &[[f64; 4]], vector: &[[f64; 4]]) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut from = 0;
    while from < t_us.len() {
        let end_us = t_us[from] + (BLOCK_S * 1e6) as i64;
        let to = from + t_us[from..].partition_point(|&t| t < end_us).max(1);
        let mean = |rows: &[[f64; 4]]| {
            let there = rows[from..to].iter().filter(|row| row[..3].iter().all(|x| x.is_finite()));
            let (sum, count) = there.fold((Vector3::zeros(), 0.0), |(sum, count), row| {
                (sum + Vector3::new(row[0], row[1], row[2]), count + 1.0)
            });
            (count > 0.0).then(|| sum / count)
        };
        if let (Some(rate), Some(vector)) = (mean(gyro), mean(vector)) {
            let t_s = t_us[from..to].iter().map(|&t| t as f64).sum::<f64>() * 1e-6 / (to - from) as f64;
            blocks.push(Block { t_s, rate, vector });
        }
        from = to;
    }
    blocks
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Rotation3;

    use super::*;

    /// A body that turns about all its axes, with the gyro's axes in the order `axes` and its rates over
    /// `scale`.
    fn motion(axes: Axes, scale: f64, only_z: bool) -> (Vec<i64>, Vec<[f64; 4]>, Vec<[f64; 4]>) {
        let (mut attitude, mut rows) = (Rotation3::identity(), (Vec::new(), Vec::new(), Vec::new()));
        for step in 0..4_000_i64 {
            let t = step as f64 * 0.01;
            let rate = Vector3::new((0.9 * t).sin(), 1.1 * (0.7 * t).cos(), 0.8 * (1.3 * t).sin());
            let rate = if only_z { Vector3::new(0.0, 0.0, rate.z) } else { rate };
            attitude *= Rotation3::new(rate * 0.01);
            let field = attitude.inverse() * Vector3::new(18.0, 2.0, 45.0);
            // The source's axes: the body's axis i is the source's axis axes[i].
            let read = axes.matrix().transpose() * rate / scale + Vector3::new(0.02, -0.01, 0.03) / scale;
            rows.0.push(step * 10_000);
            rows.1.push([read.x, read.y, read.z, 0.0]);
            rows.2.push([field.x, field.y, field.z, 0.0]);
        }
        rows
    }

    #[test]
    fn every_order_of_axes_and_every_unit_is_found() {
        for axes in Axes::all() {
            let (t_us, gyro, field) = motion(axes, 1.0_f64.to_radians(), false);
            let found = fit(&t_us, &gyro, &field).unwrap();
            assert_eq!(found.axes, axes);
            assert!((found.scale / 1.0_f64.to_radians() - 1.0).abs() < 0.01 && found.explained > 0.99, "{found:?}");
        }
    }

    /// In a vertical hole: the rate about z that the gyro's x reads looks like turns about x that go against the field's
    /// where a hard iron goes with them.
    #[test]
    fn hard_iron_beside_a_cross_axis_error_is_no_wrong_axis() {
        let (mut attitude, mut t_us, mut gyro, mut field) = (Rotation3::identity(), Vec::new(), Vec::new(), Vec::new());
        for step in 0..12_000_i64 {
            let t = step as f64 * 0.01;
            let rate = Vector3::new(0.03 * (1.9 * t).sin(), 0.03 * (1.3 * t).cos(), 3.1 + 3.0 * (1.5 * t).sin());
            attitude *= Rotation3::new(rate * 0.01);
            let read = attitude.inverse() * Vector3::new(21.0, 0.0, 45.0) + Vector3::new(3.0, 4.0, 0.0);
            t_us.push(step * 10_000);
            gyro.push([rate.x - 0.05 * rate.z, rate.y - 0.05 * rate.z, rate.z, 0.0]);
            field.push([read.x, read.y, read.z, 0.0]);
        }
        let found = fit(&t_us, &gyro, &field);
        assert!(found.is_none_or(|found| found.axes == Axes::IDENTITY), "{found:?}");
    }

    #[test]
    fn what_the_motion_does_not_tell_is_not_called_wrong() {
        // About z alone an order of x and y makes no difference.
        let (t_us, gyro, field) = motion(Axes([(1, 1), (0, 1), (2, 1)]), 1.0, true);
        assert!(fit(&t_us, &gyro, &field).is_none_or(|found| found.axes == Axes::IDENTITY));
        let still = vec![[0.0; 4]; t_us.len()];
        assert_eq!(fit(&t_us, &still, &vec![[1.0; 4]; t_us.len()]), None);
    }
}
