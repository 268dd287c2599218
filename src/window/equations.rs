use super::rows::{GYRO, MAGNETIC, Rows, gyro_part};
use crate::algebra::{Packed, add_scaled, dot};

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
            add_scaled(&mut self.rhs, row, weight * y);
            self.square += weight * y * y;
            self.rows += weight;
        }
    }

    /// Takes other sums out again.
    fn subtract(&mut self, other: &Self) {
        self.normal.add_scaled(&other.normal, -1.0);
        add_scaled(&mut self.rhs, &other.rhs, -1.0);
        self.square -= other.square;
        self.rows -= other.rows;
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

    /// Takes other equations out again.
    pub fn subtract(&mut self, other: &Self) {
        self.gravity.subtract(&other.gravity);
        self.magnetic.subtract(&other.magnetic);
    }

    /// Whether no row counts.
    pub fn is_empty(&self) -> bool {
        self.gravity.rows + self.magnetic.rows <= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::rows::tests::{THETA, change, drawn},
        *,
    };
    use rand_core::SeedableRng;
    use rand_xoshiro::Xoshiro128PlusPlus;

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
    fn a_test_window_that_says_nothing_adds_nothing() {
        let mut sum = Equations::zero();
        sum.add(&TestEquations::zero(), &THETA, [1.0; 2]);
        assert!(sum.is_empty() && TestEquations::zero().is_empty());
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
        let mut together = Equations::zero();
        tests[1..].iter().for_each(|test| together.add(test, &THETA, [0.3; 2]));
        tests[1..].iter().for_each(|test| churned.add(test, &THETA, [0.3; 2]));
        churned.subtract(&together);
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
        tests.iter().for_each(|test| twice.add(test, &THETA, [2.0; 2]));
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
