#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{super::rows::GYRO, test_function::ODD_SQUARE};
use nalgebra::{Matrix3, Vector3};

/// A quarter of a test window: what every test window that it is part of needs of it, whichever of their quarters it is, with the weights 1,
/// cosine and sine of the test function's angle.
///
/// R0 [v]x = [u]x R0, and u = R0 v stands still but for the sensor's noise and what the gyro's error makes of it in half a second, which is a
/// steady turn. So the coefficients of both sensors are made of the same sums of R0 (x) (w_raw, -1) and of u's mean over the quarter and its
/// part that goes with sin a - cos a, for with errors of P of 5 % u turns by 2 deg to either side at 180 deg/s, and without that part
/// a coefficient would lack up to a hundredth. The right-hand sides take u as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quarter {
    /// Of R0 (x) (w_raw, -1), the columns in theta's order, for each weight.
    motion: [[[f32; GYRO]; 3]; 3],
    /// Of u, gravity's and the field's, for each weight.
    vectors: [[Vector3<f32>; 3]; 2],
    /// Increments that had gravity and the field.
    read: [f32; 2],
    /// One had none.
    pub missing: [bool; 2],
    pub square_rate: f32,
    /// Sum of the squared second differences of the de-rotated field.
    pub square_roughness: f32,
    /// A rate was missing.
    pub spoilt: bool,
}

impl Quarter {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            motion: [[[0.0; GYRO]; 3]; 3],
            vectors: [[zero; 3]; 2],
            read: [0.0; 2],
            missing: [false; 2],
            square_rate: 0.0,
            square_roughness: 0.0,
            spoilt: false,
        }
    }

    /// Takes some increments' rotations and raw rates with the mean cosine and sine of their angles.
    #[inline(never)]
    pub fn add_motion(&mut self, (rotation, raw): (Matrix3<f32>, Vector3<f32>), [cosine, sine]: [f32; 2]) {
        let [plain, cosines, sines] = &mut self.motion;
        for (i, ((plain, cosines), sines)) in plain.iter_mut().zip(cosines).zip(sines).enumerate() {
            for j in 0..3 {
                let r = rotation[(i, j)];
                let mut add = |column: usize, value: f32| {
                    plain[column] += value;
                    cosines[column] += cosine * value;
                    sines[column] += sine * value;
                };
                add(3 * j, r * raw.x);
                add(3 * j + 1, r * raw.y);
                add(3 * j + 2, r * raw.z);
                add(9 + j, -r);
            }
        }
    }

    /// Takes the de-rotated gravity (`sensor` 0) or field (1) of an increment; `None` where it was not read.
    pub fn add_vector(&mut self, sensor: usize, u: Option<&Vector3<f32>>, [cosine, sine]: [f32; 2]) {
        let Some(u) = u else {
            self.missing[sensor] = true;
            return;
        };
        self.read[sensor] += 1.0;
        let [plain, cosines, sines] = &mut self.vectors[sensor];
        *plain += u;
        *cosines += u * cosine;
        *sines += u * sine;
    }

    /// Of R0 (x) (w_raw, -1), the sum with the given weights.
    #[inline(never)]
    pub fn motion(&self, [plain, cosine, sine]: [f32; 3], motion: &mut [[f32; GYRO]; 3]) {
        let [a, b, c] = self.motion.each_ref().map(|sums| sums.as_flattened());
        for (((sum, a), b), c) in motion.as_flattened_mut().iter_mut().zip(a).zip(b).zip(c) {
            *sum = plain * a + cosine * b + sine * c;
        }
    }

    /// The sum of u with the given weights.
    pub fn vector(&self, sensor: usize, [plain, cosine, sine]: [f32; 3]) -> Vector3<f32> {
        let Some([a, b, c]) = self.vectors.get(sensor) else { return Vector3::zeros() };
        a * plain + b * cosine + c * sine
    }

    /// The mean of u and what of it goes with sin a - cos a; zero where nothing was read.
    pub fn standing_and_turning(&self, sensor: usize) -> [Vector3<f32>; 2] {
        let read = self.read.get(sensor).copied().unwrap_or(0.0);
        let share = if read > 0.0 { 1.0 / read } else { 0.0 };
        [self.vector(sensor, [share, 0.0, 0.0]), self.vector(sensor, [0.0, -share / ODD_SQUARE, share / ODD_SQUARE])]
    }
}
