//! Correlation of innovations with conditions, by regression (redundancy analysis with Box's degrees of freedom), in
//! sums of fixed size.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::correlate::{Correlate, GoesWith};
use core::hint::black_box;
use nalgebra::Vector3;

/// Number of regressors of a node.
pub(super) const REGRESSORS: usize = 18;

/// Number of regressors in the widest group.
const WIDEST: usize = 4;

/// Groups of regressors that belong together, by their widths: time, temperature, rate and its square, specific
/// force, its square, once and twice per revolution, angular acceleration.
const GROUPS: [usize; 8] = [2, 1, 4, 3, 1, 2, 2, 3];

/// Number of products within the groups.
const PRODUCTS: usize = 33;

/// Frame in which a remainder is tested.
#[derive(Clone, Copy, PartialEq, Eq)]
enum View {
    /// As a turn about the axes of the body: what a bias of the gyro makes.
    Body,
    /// The field's innovation, in the frame of the earth.
    Earth,
}

impl View {
    /// Picks this view of a pair.
    const fn of<T>(self, [body, earth]: &[T; 2]) -> &T {
        match self {
            Self::Body => body,
            Self::Earth => earth,
        }
    }
}

/// Regressors of a group.
fn width_of(group: usize) -> usize {
    GROUPS.get(group).copied().unwrap_or(0)
}

/// The groups that are correlated with a view of the residual: what a gyro adds stays with the body; what is late
/// turns a vector about the angular acceleration, whatever the body's attitude.
static VIEWED: [(usize, View); 9] = [
    (0, View::Body),
    (0, View::Earth),
    (1, View::Body),
    (2, View::Body),
    (3, View::Body),
    (4, View::Body),
    (5, View::Body),
    (6, View::Body),
    (7, View::Earth),
];

/// Number of products of regressors and residuals: the widths of the groups of `VIEWED` together.
const CROSS: usize = 20;

/// Tests: the quantity, its index in `VIEWED`, and the range of the group's regressors that count; those before the
/// range are given. The model has P in it, which leaves nothing that goes with the rate: the rate's square has to show
/// beside the rate.
static TESTS: [(Correlate, usize, core::ops::Range<usize>); COUNT] = [
    (Correlate::Time, 0, 0..2),
    (Correlate::Time, 1, 0..2),
    (Correlate::Temperature, 2, 0..1),
    (Correlate::Rate, 3, 0..3),
    (Correlate::RateSquared, 3, 3..4),
    (Correlate::Acceleration, 4, 0..3),
    (Correlate::VibrationPower, 5, 0..1),
    (Correlate::OncePerRevolution, 6, 0..2),
    (Correlate::TwicePerRevolution, 7, 0..2),
    (Correlate::Lag, 8, 0..3),
];

/// Number of tests.
pub(super) const COUNT: usize = 10;

/// Least variation of a regressor, as a share of its mean: less is rounding.
const ROUNDING: f32 = 1e-5;

/// Least share of a regressor that is left beside those before it: with less it is one with them.
const COLLINEAR: f32 = 1e-4;

/// Fewest degrees of freedom of a residual's component: below it the approximation of F's distribution is poor.
const LEAST_FREEDOM: f32 = 3.0;

/// Running means and central products of regressors and residuals.
pub(super) struct Moments {
    count: f32,
    regressors: [f32; REGRESSORS],
    residuals: [Vector3<f32>; 2],
    squares: [f32; PRODUCTS],
    cross: [Vector3<f32>; CROSS],
    /// xx, yy, zz, xy, xz, yz in each view.
    scatter: [[f32; 6]; 2],
}

impl Moments {
    #[inline(always)]
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            count: 0.0,
            regressors: [0.0; REGRESSORS],
            residuals: [zero; 2],
            squares: [0.0; PRODUCTS],
            cross: [zero; CROSS],
            scatter: [[0.0; 6]; 2],
        }
    }

    /// Takes a node's regressors and its residual, in the body's frame and in the earth's.
    #[inline(never)]
    // Once a node: the boxes keep its loops from being unrolled, to twice as much code.
    pub fn add(&mut self, regressors: &[f32; REGRESSORS], residuals: &[Vector3<f32>; 2]) {
        self.count += 1.0;
        let share = 1.0 / self.count;
        let central = 1.0 - share;
        let mut x = [0.0; REGRESSORS];
        for ((x, mean), new) in x.iter_mut().zip(&mut self.regressors).zip(regressors) {
            *x = black_box(new) - *mean;
            *mean += *x * share;
        }
        let mut weighted = [Vector3::zeros(); 2];
        for v in 0..2 {
            let y = residuals[v] - self.residuals[v];
            self.residuals[v] += y * share;
            weighted[v] = y * central;
            let products = [y.x * y.x, y.y * y.y, y.z * y.z, y.x * y.y, y.x * y.z, y.y * y.z];
            self.scatter[v].iter_mut().zip(products).for_each(|(sum, product)| *sum += product * central);
        }
        let mut squares = self.squares.iter_mut();
        let mut rest = x.as_slice();
        for width in GROUPS {
            let Some((group, next)) = rest.split_at_checked(width) else { break };
            for (i, a) in group.iter().enumerate() {
                let scaled = black_box(a) * central;
                // The group first: zip takes from its left before it sees that the right has ended.
                for (b, sum) in group.iter().take(i + 1).zip(&mut squares) {
                    *sum += scaled * black_box(b);
                }
            }
            rest = next;
        }
        let mut cross = self.cross.iter_mut();
        for &(group, view) in &VIEWED {
            let first: usize = GROUPS.iter().take(group).sum();
            let residual = view.of(&weighted);
            for (x, sum) in x.iter().skip(first).take(width_of(group)).zip(&mut cross) {
                *sum += residual * *black_box(x);
            }
        }
    }

    /// Total variance of the residual in the body's frame, and how many components of equal variance would scatter as
    /// it does.
    pub fn scatter_in_body(&self) -> (f32, f32) {
        let (trace, components) = self.scatter_of(View::Body);
        (if self.count > 0.0 { trace / self.count } else { 0.0 }, components)
    }

    /// Mean of the residual in the body's frame.
    pub const fn mean_in_body(&self) -> Vector3<f32> {
        *View::Body.of(&self.residuals)
    }

    #[inline(never)]
    fn scatter_of(&self, view: View) -> (f32, f32) {
        let [xx, yy, zz, xy, xz, yz] = *view.of(&self.scatter);
        let trace = xx + yy + zz;
        let squares = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        (trace, if squares > 0.0 { trace * trace / squares } else { 0.0 })
    }

    /// Share and p-value of each quantity; `None` if it does not vary, or too few nodes were seen.
    pub fn tests(&self) -> [Option<GoesWith>; COUNT] {
        let mut found = [None; COUNT];
        for (found, (correlate, viewed, counted)) in found.iter_mut().zip(&TESTS) {
            *found = self.test(*viewed, counted.clone()).map(|(share, p_value)| GoesWith {
                correlate: *correlate,
                share,
                p_value,
            });
        }
        found
    }

    /// Share of the total variance that some regressors take beside those before them (redundancy analysis), and its
    /// p-value by the ratio of the variances, whose distribution is about that of F with its degrees of freedom times
    /// the number of components of equal variance (Box, Annals of Mathematical Statistics 25 (1954) 290).
    #[inline(never)]
    fn test(&self, viewed: usize, counted: core::ops::Range<usize>) -> Option<(f32, f32)> {
        let &(group, view) = VIEWED.get(viewed)?;
        let before = GROUPS.iter().take(group);
        let means = self.regressors.iter().skip(before.clone().sum());
        let mut products = self.squares.iter().skip(before.map(|width| width * (width + 1) / 2).sum());
        let cross = self.cross.iter().skip(VIEWED.iter().take(viewed).map(|(group, _)| width_of(*group)).sum());
        let (total, components) = self.scatter_of(view);
        // Explained variance, and the number of regressors: those that are given, and those that count.
        let mut explained = [0.0; 2];
        let mut ranks = [0.0; 2];
        let mut lower = [[0.0; WIDEST]; WIDEST];
        let mut z = [Vector3::zeros(); WIDEST];
        for (i, (cross, mean)) in (0..WIDEST).zip(cross.zip(means)).take(counted.end) {
            let mut row = [0.0; WIDEST];
            let mut own = 0.0;
            for j in 0..WIDEST {
                if j > i {
                    break;
                }
                own = products.next().copied().unwrap_or(0.0);
                let sum = (0..j).fold(own, |sum, k| sum - row[k] * lower[j][k]);
                row[j] = if j < i && lower[j][j] > 0.0 { sum / lower[j][j] } else { 0.0 };
            }
            let pivot = row.iter().fold(own, |sum, l| sum - l * l);
            let rounding = ROUNDING * mean;
            if pivot > COLLINEAR * own && pivot > self.count * rounding * rounding {
                let root = libm::sqrtf(pivot);
                z[i] = row.iter().zip(&z).fold(*cross, |sum, (l, z)| sum - z * *l) / root;
                row[i] = root;
                let counts = usize::from(counted.contains(&i));
                explained[counts] += z[i].norm_squared();
                ranks[counts] += 1.0;
            }
            lower[i] = row;
        }
        let ([given, own], [given_rank, rank]) = (explained, ranks);
        let freedom = self.count - given_rank - rank - 1.0;
        let left = total - given - own;
        if !(rank > 0.0 && left > 0.0 && freedom >= LEAST_FREEDOM) {
            return None;
        }
        let p_value = chance_of_ratio(own * freedom / (left * rank), rank * components, freedom * components);
        Some((own / total, p_value))
    }
}

/// Probability that F with these degrees of freedom is larger than `ratio` (Paulson, Annals of Mathematical Statistics
/// 13 (1942) 233: within a few hundredths of itself from 3 degrees of freedom on).
#[inline(never)]
fn chance_of_ratio(ratio: f32, freedom: f32, freedom_left: f32) -> f32 {
    let (a, b) = (2.0 / (9.0 * freedom), 2.0 / (9.0 * freedom_left));
    // The cube root, by functions that are there already.
    let root = if ratio > 0.0 { libm::expf(libm::logf(ratio) / 3.0) } else { 0.0 };
    let deviate = ((1.0 - b) * root - (1.0 - a)) / libm::sqrtf(b * root * root + a);
    0.5 * libm::erfcf(deviate * core::f32::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests;
