//! Order of the gyro's axes against a vector sensor's: a vector `v` that stands still in the earth turns in
//! the body as `dv/dt = v x w`. Least squares over all signed orders of the axes, each with its scale, an offset and a
//! delay of the vector, a bias, and errors of a data sheet's size, says which of them makes the gyro turn the vector as
//! it turns.

use super::median::median;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Length over which readings are averaged: short against a turn, long against vibration, seconds.
const BLOCK_S: f64 = 0.05;
/// Median turn of the vector from one block to the next above which blocks are shorter, rad: of a step of this size the
/// means and the differences of a turn are exact to a thousandth.
const TURN: f64 = 0.15;
/// Share of its median by which the vector's length may be off where it counts.
const UNDISTURBED: f64 = 0.05;
/// Share of the vector's turning that the best order must explain before it counts as evidence.
const EXPLAINED: f64 = 0.6;
/// Deviation of an element of the gyro's matrix from its order's, of its scale: twice the sensitivity tolerance and
/// five times the cross-axis sensitivity of data sheets.
const ELEMENT: f64 = 0.05;
/// Log-likelihood ratio by which another order has to be likelier than the given one, in twice the natural logarithm:
/// 48,000 to 1, for 48 orders; and neighbouring blocks err alike, which makes them worth a quarter.
const LIKELIER: f64 = 4.0 * 21.6;

/// Least number of rows: some six for each unknown of an order.
const LEAST_ROWS: f64 = 170.0;
/// Number of blocks that tell enough, a quarter of an hour: of a longer recording they are taken evenly.
const ENOUGH: usize = 20_000;

/// Unknowns of all orders together, by their first columns: the matrix's elements; those of its offset's cross product
/// with the matrix, which turns as the gyro says though the vector does not; the bias; and the lag, with each element.
const ELEMENTS: usize = 0;
const OFFSETS: usize = 9;
const BIAS: usize = 18;
const LAGS: usize = 21;
const ALL: usize = 30;
/// Unknowns of one order: its scale, offset, bias, lag, and the deviations of its matrix, which turn the vector and its
/// offset.
const OWN: usize = 26;
const OWN_OFFSET: usize = 1;
const OWN_BIAS: usize = 4;
const DEVIATIONS: usize = 8;
const OF_OFFSET: usize = 17;
/// Share of the vector that its offset may be: a magnetometer with more needs a calibration first.
const OFFSET: f64 = 0.5;

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
    /// The likeliest order of the gyro's axes; the given one unless another is far likelier.
    pub axes: Axes,
    /// Factor by which the gyro's rates have to be multiplied.
    pub scale: f64,
    /// Share of the vector's turning that this explains, with a bias and nothing else.
    pub explained: f64,
}

/// Fits a gyro to a vector sensor; `None` where the motion does not tell. Times in microseconds.
#[must_use]
pub fn fit(t_us: &[i64], gyro: &[[f64; 4]], vector: &[[f64; 4]]) -> Option<RotationFit> {
    let coarse = blocks(t_us, gyro, vector, BLOCK_S);
    let typical = median(coarse.iter().map(|block| block.vector.norm()))?;
    let turn = median(coarse.windows(2).map(|pair| (pair[1].vector - pair[0].vector).norm() / typical))?;
    let block_s = if turn > TURN { BLOCK_S * TURN / turn } else { BLOCK_S };
    let mut blocks = blocks(t_us, gyro, vector, block_s);
    // Over a gap the rate is not known.
    let spacing_s = median(blocks.windows(2).map(|pair| pair[1].t_s - pair[0].t_s))?;
    blocks.iter_mut().for_each(|block| block.vector /= typical);
    // A vector of another length is not the earth's alone.
    blocks.retain(|block| (block.vector.norm() - 1.0).abs() < UNDISTURBED);
    let plain = Sums::of(&blocks, 3.0 * spacing_s, 0.0);
    if plain.rows < LEAST_ROWS {
        return None;
    }
    let scales = Axes::all().into_iter().filter_map(|axes| plain.scale(axes));
    let (in_rad_s, _) = scales.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let sums = Sums::of(&blocks, 3.0 * spacing_s, in_rad_s);
    let nothing = sums.left_by_bias_alone()?;
    // The least that is left with whatever matrix; the floor is by how much means and differences of steps err where
    // the rate changes, as a sixth of the turn's square: in the test with hard iron, without noise, half of it is left.
    let floor = (TURN * TURN / 6.0).powi(2) * nothing;
    let noise = sums.left(Axes::IDENTITY, 0.0)?.max(floor) / sums.rows;
    let fits = Axes::all().into_iter().filter_map(|axes| {
        let (scale, plainly_left) = sums.scale(axes)?;
        let left = sums.left(axes, noise / (ELEMENT * ELEMENT * scale * scale))?;
        Some((RotationFit { axes, scale, explained: 1.0 - plainly_left / nothing }, left))
    });
    let fits: Vec<_> = fits.collect();
    let (best, least) = fits.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let given = fits.iter().find(|(fit, _)| fit.axes == Axes::IDENTITY);
    // A residual that the likeliest order does not explain either, such as a soft iron's, may be what makes it
    // likelier; and so may that a turn is taken in steps.
    let unexplained = (least - noise * sums.rows).max(floor);
    let is_likelier = given.is_none_or(|(_, left)| left - least > LIKELIER * noise + unexplained);
    let fit = if is_likelier { best } else { &given?.0 };
    (fit.explained > EXPLAINED).then_some(*fit)
}

/// Normal equations of all unknowns.
struct Sums {
    normal: Box<SMatrix<f64, ALL, ALL>>,
    right: SVector<f64, ALL>,
    square: f64,
    rows: f64,
}

impl Sums {
    /// From one block to the next the vector `v` changes by `(v + offset) x (M w + bias)`, M and rate as the lag
    /// before. Rates times `in_rad_s` are in rad/s; 0 where that is not known yet.
    fn of(blocks: &[Block], longest_s: f64, in_rad_s: f64) -> Self {
        let (mut normal, mut right, mut square, mut rows) = (Box::new(SMatrix::zeros()), SVector::zeros(), 0.0, 0.0);
        let apart = 1 + blocks.len() / ENOUGH;
        let threes = blocks.windows(3).step_by(apart).filter_map(|blocks| <&[Block; 3]>::try_from(blocks).ok());
        for [before, at, after] in threes {
            let step_s = at.t_s - before.t_s;
            let span_s = after.t_s - before.t_s;
            if span_s > longest_s {
                continue;
            }
            let change = at.vector - before.vector;
            let turn = (at.rate + before.rate) / 2.0 * step_s;
            // A vector that turns by an angle changes by twice its half's tangent, of the mean of both.
            let half = turn.norm() * in_rad_s / 2.0;
            let turn = if (1e-6..1.0).contains(&half) { turn * (half.tan() / half) } else { turn };
            let cross = ((at.vector + before.vector) / 2.0).cross_matrix();
            // Turn of the vector within the step by the rate's change in a second.
            let later = (after.rate - before.rate) / span_s * step_s;
            let mut columns = SMatrix::<f64, 3, ALL>::zeros();
            for (i, j) in (0..9).map(|element| (element / 3, element % 3)) {
                columns.set_column(ELEMENTS + 3 * i + j, &(cross.column(i) * turn[j]));
                columns.set_column(LAGS + 3 * i + j, &(cross.column(i) * later[j]));
                columns[(i, OFFSETS + 3 * i + j)] = turn[j];
            }
            columns.fixed_columns_mut::<3>(BIAS).copy_from(&(cross * step_s));
            *normal += columns.transpose() * columns;
            right += columns.transpose() * change;
            square += change.norm_squared();
            rows += 3.0;
        }
        Self { normal, right, square, rows }
    }

    /// Residual that a bias alone leaves; no order has to explain what it takes up.
    fn left_by_bias_alone(&self) -> Option<f64> {
        let right = self.right.fixed_rows::<3>(BIAS).into_owned();
        let solved = self.normal.fixed_view::<3, 3>(BIAS, BIAS).into_owned().cholesky()?.solve(&right);
        Some(self.square - solved.dot(&right))
    }

    /// The unknowns of an order, each in all unknowns; the scale comes with every element.
    fn own(axes: Axes) -> SMatrix<f64, ALL, OWN> {
        let mut own = SMatrix::zeros();
        for (element, part) in axes.matrix().transpose().iter().enumerate() {
            own[(ELEMENTS + element, 0)] = *part;
            own[(LAGS + element, OWN_BIAS + 3)] = *part;
            own[(ELEMENTS + element, DEVIATIONS + element)] = 1.0;
            own[(OFFSETS + element, OF_OFFSET + element)] = 1.0;
        }
        for axis in 0..3 {
            let turned = Vector3::ith(axis, 1.0).cross_matrix() * axes.matrix();
            for (element, part) in turned.transpose().iter().enumerate() {
                own[(OFFSETS + element, OWN_OFFSET + axis)] = *part;
            }
        }
        (0..3).for_each(|axis| own[(BIAS + axis, OWN_BIAS + axis)] = 1.0);
        own
    }

    /// The scale of an order beside a bias, and what is left; `None` if the scale is not positive.
    fn scale(&self, axes: Axes) -> Option<(f64, f64)> {
        let own = Self::own(axes);
        let mut columns = SMatrix::<f64, ALL, 4>::zeros();
        columns.set_column(0, &own.column(0));
        columns.fixed_columns_mut::<3>(1).copy_from(&own.fixed_columns::<3>(OWN_BIAS));
        let normal = columns.transpose() * *self.normal * columns;
        let right = columns.transpose() * self.right;
        let solved = normal.cholesky()?.solve(&right);
        (solved[0] > 0.0).then_some((solved[0], self.square - solved.dot(&right)))
    }

    /// Residual that an order leaves with all its unknowns. Each deviation of its matrix has this weight, and what it
    /// makes of an offset accordingly.
    fn left(&self, axes: Axes, weight: f64) -> Option<f64> {
        let own = Self::own(axes);
        let mut normal = own.transpose() * *self.normal * own;
        // An unknown that nothing shows stays at zero.
        let least = 1e-12 * normal.diagonal().max();
        for k in 0..OWN {
            normal[(k, k)] += least
                + match k {
                    OWN_OFFSET..OWN_BIAS => weight * (ELEMENT / OFFSET).powi(2),
                    DEVIATIONS..OF_OFFSET => weight,
                    OF_OFFSET.. => weight / (OFFSET * OFFSET),
                    _ => 0.0,
                };
        }
        let right = own.transpose() * self.right;
        Some(self.square - normal.cholesky()?.solve(&right).dot(&right))
    }
}

struct Block {
    t_s: f64,
    rate: Vector3<f64>,
    vector: Vector3<f64>,
}

/// Means over blocks; a block without a reading of either sensor is left out.
fn blocks(t_us: &[i64], gyro: &[[f64; 4]], vector: &[[f64; 4]], block_s: f64) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut from = 0;
    while from < t_us.len() {
        let end_us = t_us[from] + (block_s * 1e6) as i64;
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

    /// In a vertical hole: the rate about z that the gyro's x reads looks like turns about x that go against the
    /// field's where a hard iron goes with them.
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
