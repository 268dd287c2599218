#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    super::{
        equations::TestEquations,
        rows::{GYRO, MAGNETIC, Rows},
    },
    TestFunction,
    quarter::Quarter,
    test_function::QuarterWeights,
};
use crate::algebra::dot;
use nalgebra::Vector3;

/// The equations of the test window that these quarters make, about `theta`; none when the tool stood still or readings were missing.
#[inline(never)]
pub(super) fn equations(
    quarters: &[&Quarter],
    function: &TestFunction,
    moving_rate_rad_s: f32,
    theta: &[f32; GYRO],
) -> TestEquations {
    let length = (function.hop() * quarters.len()) as f32;
    let mut equations = TestEquations::zero();
    let (mut square_rate, mut square_roughness, mut missing) = (0.0, 0.0, [false; 2]);
    for quarter in quarters {
        equations.spoilt |= quarter.spoilt;
        square_rate += quarter.square_rate;
        square_roughness += quarter.square_roughness;
        missing[0] |= quarter.missing[0];
        missing[1] |= quarter.missing[1];
    }
    if equations.spoilt || square_rate <= moving_rate_rad_s * moving_rate_rad_s * length {
        return equations;
    }
    let (mut gravity_rows, mut field_rows) = ([[0.0; GYRO]; 3], [[0.0; MAGNETIC]; 3]);
    let mut rhs = [Vector3::zeros(); 2];
    let mut motion = [[0.0; GYRO]; 3];
    for (number, quarter) in quarters.iter().enumerate() {
        let QuarterWeights { weight, slope, turning } = function.of_quarter(quarters.len(), number);
        let [gravity, gravity_turning] = quarter.standing_and_turning(0);
        let [field, field_turning] = quarter.standing_and_turning(1);
        for (weights, gravity, field) in [(weight, gravity, field), (turning, gravity_turning, field_turning)] {
            quarter.motion(weights, &mut motion);
            add_turned(&gravity, &motion, gravity_rows.each_mut().map(|row| row.as_mut_slice()));
            add_turned(&field, &motion, field_rows.each_mut().map(|row| row.as_mut_slice()));
        }
        for (sensor, rhs) in rhs.iter_mut().enumerate() {
            *rhs += quarter.vector(sensor, slope);
        }
        // R0 (w x v) = (R0 w) x u, and w = P w_raw - c.
        quarter.motion(slope, &mut motion);
        let lag = Vector3::from(motion.each_ref().map(|row| dot(row, theta))).cross(&field);
        for ((row, motion), lag) in field_rows.iter_mut().zip(&motion).zip(lag.iter()) {
            row[GYRO] += lag;
            for j in 0..3 {
                row[GYRO + 1 + j] -= motion[9 + j];
            }
        }
    }
    let [gravity_rhs, field_rhs] = rhs.map(Into::into);
    if !missing[0] {
        equations.gravity = Rows::new(&gravity_rows, &gravity_rhs, theta);
    }
    if !missing[1] {
        // Three components, and 1 + 4 + 1 variances in a second difference.
        equations.field_noise_ut2 = square_roughness / (18.0 * length);
        equations.field = Rows::new(&field_rows, &field_rhs, theta);
    }
    equations
}

/// Adds [u]x R0 (x) (w_raw, -1).
#[inline(never)]
fn add_turned(u: &Vector3<f32>, motion: &[[f32; GYRO]; 3], rows: [&mut [f32]; 3]) {
    for (i, row) in rows.into_iter().enumerate() {
        let (b, c) = ((i + 1) % 3, (i + 2) % 3);
        let (up, down) = (u[b], u[c]);
        for ((sum, x), y) in row.iter_mut().zip(&motion[c]).zip(&motion[b]) {
            *sum += up * x - down * y;
        }
    }
}
