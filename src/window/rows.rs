#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use crate::algebra::dot;

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

/// Their inverses, which are exact.
const INVERSE_UNITS: [f32; MAGNETIC] = {
    let mut inverse = UNITS;
    let mut j = 0;
    while j < MAGNETIC {
        inverse[j] = 1.0 / UNITS[j];
        j += 1;
    }
    inverse
};

/// The three equations that one sensor's vector gives over one test window: a x = y, x absolute.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<const D: usize> {
    coefficients: [[i16; D]; 3],
    /// One step of the coefficients, in their units; 0: the sensor gave none.
    step: f32,
    /// Right-hand sides.
    pub rhs: [f32; 3],
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
        let per_unit = 1.0 / step;
        let coefficients = scaled.map(|row| row.map(|x| rounded(x * per_unit) as i16));
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
        let steps: [f32; D] = core::array::from_fn(|j| self.step * INVERSE_UNITS[j]);
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

/// The nearest whole number to one of at most 2^22: a sum with 1.5 * 2^23 has no bits for more. `libm`'s takes ten times as many instructions.
fn rounded(x: f32) -> f32 {
    const NO_FRACTION: f32 = 12_582_912.0;
    x + NO_FRACTION - NO_FRACTION
}

/// The first 12 unknowns.
pub(crate) fn gyro_part<const D: usize>(x: &[f32; D]) -> [f32; GYRO] {
    core::array::from_fn(|i| x[i])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    pub const THETA: [f32; GYRO] = [1.05, 0.02, -0.03, 0.01, 0.96, 0.04, -0.02, 0.03, 1.02, 0.02, -0.01, 0.03];

    /// Uniform in -1 to 1.
    pub fn deviate(generator: &mut Xoshiro128PlusPlus) -> f32 {
        generator.next_u32() as f32 / (u32::MAX / 2) as f32 - 1.0
    }

    /// Coefficients about as large as those of the field: of P and c with the rate and the field's norm in them, of the lag, of
    /// a hard iron; and residuals at the nominal theta.
    pub fn drawn(generator: &mut Xoshiro128PlusPlus) -> ([[f32; MAGNETIC]; 3], [f32; 3]) {
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
    pub fn change(generator: &mut Xoshiro128PlusPlus) -> [f32; MAGNETIC] {
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
    }
}
