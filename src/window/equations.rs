#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use crate::algebra::{Packed, dot};

/// Unknowns of the gravity equations: P (row-major, 9) and c = P b (3).
pub(crate) const GYRO: usize = 12;
/// Unknowns of the field equations: those, the magnetometer's lag behind the gyro (s) and its hard iron (microtesla, 3).
pub(crate) const MAGNETIC: usize = 16;

/// What the stored coefficients of the unknowns are multiplied by, so that in a row of 16-bit integers none drowns: about the
/// unknowns' prior deviations, rounded to powers of two.
const UNITS: [f32; MAGNETIC] = {
    let (p, c, lag, iron) = (0.062_5, 0.015_625, 0.015_625, 32.0);
    [p, p, p, p, p, p, p, p, p, c, c, c, lag, iron, iron, iron]
};

/// The three equations that one sensor's vector gives over one test window: a x = y, x absolute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<const D: usize> {
    coefficients: [[i16; D]; 3],
    /// One step of the coefficients, in their units; 0: the sensor gave none.
    step: f32,
    /// Right-hand sides.
    rhs: [f32; 3],
}

impl<const D: usize> Rows<D> {
    pub const NONE: Self = Self { coefficients: [[0; D]; 3], step: 0.0, rhs: [0.0; 3] };

    /// From the coefficients and the right-hand sides about `theta`, the nominal P and c: the residual there is kept exactly.
    pub fn new(rows: &[[f32; D]; 3], about_theta: &[f32; 3], theta: &[f32; GYRO]) -> Self {
        let scaled = rows.map(|row| core::array::from_fn::<f32, D, _>(|j| row[j] * UNITS[j]));
        let larger = |most: f32, x: &f32| if libm::fabsf(*x) > most { libm::fabsf(*x) } else { most };
        // A NaN is in every sum of its row, and makes the step none.
        let largest = scaled.iter().flatten().fold(0.0, larger);
        let finite = scaled.iter().flatten().fold(0.0, |sum, x| sum + x).is_finite();
        if !(finite && largest > 0.0) {
            return Self::NONE;
        }
        let step = largest / f32::from(i16::MAX);
        let coefficients = scaled.map(|row| row.map(|x| libm::roundf(x / step) as i16));
        let mut kept = Self { coefficients, step, rhs: *about_theta };
        let rows = kept.rows();
        for (rhs, row) in kept.rhs.iter_mut().zip(&rows) {
            *rhs += dot(&gyro_part(row), theta);
        }
        kept
    }

    pub fn is_some(&self) -> bool {
        self.step > 0.0
    }

    /// The coefficients, equation by equation.
    pub fn rows(&self) -> [[f32; D]; 3] {
        let steps: [f32; D] = core::array::from_fn(|j| self.step / UNITS[j]);
        self.coefficients.map(|row| {
            let mut values = steps;
            for (value, stored) in values.iter_mut().zip(row) {
                *value *= f32::from(stored);
            }
            values
        })
    }

    /// Squared norms of y - a (theta + x), for each of some x.
    pub fn misfits<const M: usize>(&self, theta: &[f32; GYRO], xs: &[[f32; D]; M]) -> [f32; M] {
        let mut squares = [0.0; M];
        for (row, rhs) in self.rows().iter().zip(&self.rhs) {
            let y = rhs - dot(&gyro_part(row), theta);
            for (square, x) in squares.iter_mut().zip(xs) {
                let residual = y - dot(row, x);
                *square += residual * residual;
            }
        }
        squares
    }
}

/// The equations of one test window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TestEquations {
    pub gravity: Rows<GYRO>,
    pub field: Rows<MAGNETIC>,
    /// Variance of the white part of the field's noise in an increment, on one axis, microtesla^2.
    pub field_noise_ut2: f32,
    /// A rate was missing or clipped.
    pub spoilt: bool,
}

impl TestEquations {
    pub const fn zero() -> Self {
        Self { gravity: Rows::NONE, field: Rows::NONE, field_noise_ut2: 0.0, spoilt: false }
    }

    /// Whether it says nothing: the tool stood still, or readings were missing.
    pub fn is_empty(&self) -> bool {
        !(self.gravity.is_some() || self.field.is_some())
    }
}

/// Normal equations of one class of rows, about a nominal theta: N x = h, s the sum of squares of the right-hand sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sums<const D: usize, const T: usize> {
    pub normal: Packed<D, T>,
    pub rhs: [f32; D],
    pub square: f32,
    /// Sum of the weights of the rows.
    pub rows: f32,
}

impl<const D: usize, const T: usize> Sums<D, T> {
    const fn zero() -> Self {
        Self { normal: Packed::zero(), rhs: [0.0; D], square: 0.0, rows: 0.0 }
    }

    /// Adds equations with a weight, which may be negative to take them out again.
    fn add(&mut self, rows: &Rows<D>, theta: &[f32; GYRO], weight: f32) {
        if !rows.is_some() || weight == 0.0 {
            return;
        }
        let three = rows.rows();
        self.normal.add_outers(&three, weight);
        for (row, rhs) in three.iter().zip(&rows.rhs) {
            let y = rhs - dot(&gyro_part(row), theta);
            for (sum, a) in self.rhs.iter_mut().zip(row) {
                *sum += weight * y * a;
            }
            self.square += weight * y * y;
            self.rows += weight;
        }
    }

    fn add_scaled(&mut self, other: &Self, weight: f32) {
        self.normal.add_scaled(&other.normal, weight);
        for (sum, h) in self.rhs.iter_mut().zip(&other.rhs) {
            *sum += weight * h;
        }
        self.square += weight * other.square;
        self.rows += weight * other.rows;
    }

    /// Sum of squared residuals at `x`.
    pub fn misfit(&self, x: &[f32; D]) -> f32 {
        let misfit = self.square - 2.0 * dot(&self.rhs, x) + self.normal.quadratic(x);
        // Cancellation can leave a small negative number.
        if misfit > 0.0 { misfit } else { 0.0 }
    }
}

/// Normal equations of a set of test windows, about a nominal theta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equations {
    pub gravity: Sums<GYRO, 78>,
    pub magnetic: Sums<MAGNETIC, 136>,
}

impl Equations {
    pub const fn zero() -> Self {
        Self { gravity: Sums::zero(), magnetic: Sums::zero() }
    }

    /// Adds a test window's equations about `theta`; weights of its gravity and of its field.
    pub fn add(&mut self, test: &TestEquations, theta: &[f32; GYRO], [gravity, field]: [f32; 2]) {
        self.gravity.add(&test.gravity, theta, gravity);
        self.magnetic.add(&test.field, theta, field);
    }

    /// Adds `weight` times other equations about the same theta.
    pub fn add_scaled(&mut self, other: &Self, weight: f32) {
        self.gravity.add_scaled(&other.gravity, weight);
        self.magnetic.add_scaled(&other.magnetic, weight);
    }

    /// Whether no row counts.
    pub fn is_empty(&self) -> bool {
        self.gravity.rows + self.magnetic.rows <= 0.0
    }
}

/// The first 12 unknowns.
pub(crate) fn gyro_part<const D: usize>(x: &[f32; D]) -> [f32; GYRO] {
    core::array::from_fn(|i| x[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const THETA: [f32; GYRO] = [1.05, 0.02, -0.03, 0.01, 0.96, 0.04, -0.02, 0.03, 1.02, 0.02, -0.01, 0.03];

    /// Uniform in -1 to 1.
    fn deviate(generator: &mut Xoshiro128PlusPlus) -> f32 {
        generator.next_u32() as f32 / (u32::MAX / 2) as f32 - 1.0
    }

    /// Coefficients about as large as those of the field: of P and c with the rate and the field's norm in them, of the lag, of
    /// a hard iron; and residuals at the nominal theta.
    fn drawn(generator: &mut Xoshiro128PlusPlus) -> ([[f32; MAGNETIC]; 3], [f32; 3]) {
        let sizes: [f32; MAGNETIC] = core::array::from_fn(|j| match j {
            0..9 => 100.0,
            9..12 => 30.0,
            12 => 150.0,
            _ => 1.0,
        });
        let rows = [[0.0; MAGNETIC]; 3].map(|row| {
            let mut sizes = sizes.iter();
            row.map(|_: f32| sizes.next().unwrap() * deviate(generator))
        });
        (rows, [0.0; 3].map(|_: f32| deviate(generator)))
    }

    /// An x about as large as a window's changes.
    fn change(generator: &mut Xoshiro128PlusPlus) -> [f32; MAGNETIC] {
        UNITS.map(|unit| unit * deviate(generator))
    }

    #[test]
    fn sixteen_bits_keep_the_residual_at_the_nominal_theta_and_lose_half_a_step_of_each_coefficient_elsewhere() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
        for _ in 0..100 {
            let (rows, about_theta) = drawn(&mut generator);
            let kept = Rows::new(&rows, &about_theta, &THETA);
            assert!(kept.is_some());
            let square = about_theta.iter().map(|y| y * y).sum::<f32>();
            // To f32's rounding of right-hand sides of a few hundred.
            assert!((kept.misfits(&THETA, &[[0.0; MAGNETIC]])[0] - square).abs() < 2e-4, "{square}");

            let x = change(&mut generator);
            let scaled = rows.iter().flatten().zip(UNITS.iter().cycle()).map(|(a, unit)| (a * unit).abs());
            let step = scaled.max_by(f32::total_cmp).unwrap() / f32::from(i16::MAX);
            let most_lost = 0.5 * step * x.iter().zip(UNITS).map(|(x, unit)| (x / unit).abs()).sum::<f32>();
            for (i, row) in rows.iter().enumerate() {
                let lost = (dot(row, &x) - dot(&kept.rows()[i], &x)).abs();
                assert!(lost <= 1.01 * most_lost + 1e-5, "{lost} of at most {most_lost}");
                for ((stored, a), unit) in kept.rows()[i].iter().zip(row).zip(UNITS) {
                    assert!((stored - a).abs() <= 0.51 * step / unit, "{stored} {a}");
                }
            }
        }
    }

    #[test]
    fn rows_of_nothing_or_of_what_is_not_finite_are_none() {
        let residuals = [1.0; 3];
        assert!(!Rows::new(&[[0.0; MAGNETIC]; 3], &residuals, &THETA).is_some());
        for bad in [f32::INFINITY, f32::NEG_INFINITY, 1e38] {
            let mut rows = [[1.0; MAGNETIC]; 3];
            rows[1][14] = bad;
            assert!(!Rows::new(&rows, &residuals, &THETA).is_some(), "{bad}");
        }
        let mut sum = Equations::zero();
        sum.add(&TestEquations::zero(), &THETA, [1.0; 2]);
        assert!(sum.is_empty() && TestEquations::zero().is_empty());
    }

    fn test_window(generator: &mut Xoshiro128PlusPlus) -> TestEquations {
        let (rows, about_theta) = drawn(generator);
        let gravity = rows.map(|row| gyro_part(&row));
        TestEquations {
            gravity: Rows::new(&gravity, &about_theta, &THETA),
            field: Rows::new(&rows, &about_theta, &THETA),
            ..TestEquations::zero()
        }
    }

    #[test]
    fn what_is_taken_out_again_leaves_nothing_and_what_stays_is_as_it_was() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(2);
        let tests = [(); 20].map(|()| test_window(&mut generator));
        let (mut alone, mut churned) = (Equations::zero(), Equations::zero());
        alone.add(&tests[0], &THETA, [1.0; 2]);
        churned.add(&tests[0], &THETA, [1.0; 2]);
        let before = alone.magnetic.normal.get(0, 0);
        for weight in [1.0, 0.3, 0.04] {
            tests[1..].iter().for_each(|test| churned.add(test, &THETA, [weight, 0.5 * weight]));
        }
        let most = churned.magnetic.normal.get(0, 0);
        for weight in [1.0, 0.3, 0.04] {
            tests[1..].iter().for_each(|test| churned.add(test, &THETA, [-weight, -0.5 * weight]));
        }
        // What rounding leaves is a part in a million of what was in it.
        for i in 0..MAGNETIC {
            for j in 0..=i {
                let left = (churned.magnetic.normal.get(i, j) - alone.magnetic.normal.get(i, j)).abs();
                assert!(left <= 2e-6 * most, "({i}, {j}): {left} of {most} beside {before}");
            }
        }
        assert!((churned.magnetic.rows - 3.0).abs() < 1e-3 && (churned.gravity.rows - 3.0).abs() < 1e-3);
        let x = change(&mut generator);
        let misfits = [&alone, &churned].map(|sum| sum.magnetic.misfit(&x));
        assert!((misfits[1] / misfits[0] - 1.0).abs() < 1e-2, "{misfits:?}");
    }

    #[test]
    fn the_sums_misfit_is_the_sum_of_the_rows_misfits_and_solves_to_its_bottom() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        let tests = [(); 30].map(|()| test_window(&mut generator));
        let mut sum = Equations::zero();
        tests.iter().for_each(|test| sum.add(test, &THETA, [1.0; 2]));
        let mut twice = Equations::zero();
        twice.add_scaled(&sum, 2.0);
        for _ in 0..10 {
            let x = change(&mut generator);
            let expected: f32 = tests.iter().map(|test| test.field.misfits(&THETA, &[x])[0]).sum();
            assert!((sum.magnetic.misfit(&x) / expected - 1.0).abs() < 1e-3);
            assert!((twice.magnetic.misfit(&x) / expected - 2.0).abs() < 2e-3);
            let expected: f32 = tests.iter().map(|test| test.gravity.misfits(&THETA, &[gyro_part(&x)])[0]).sum();
            assert!((sum.gravity.misfit(&gyro_part(&x)) / expected - 1.0).abs() < 1e-3);
        }
        let bottom = sum.magnetic.normal.cholesky().unwrap().solve(&sum.magnetic.rhs);
        let least = sum.magnetic.misfit(&bottom);
        for _ in 0..10 {
            let mut beside = change(&mut generator);
            beside.iter_mut().zip(&bottom).for_each(|(x, b)| *x = b + 0.1 * *x);
            assert!(sum.magnetic.misfit(&beside) > least);
        }
    }
}
