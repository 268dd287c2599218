//! Rows of the declared field: their slopes, and their misfit.

use super::*;
use crate::estimator::{
    columns::NODE,
    parameters::Parameters,
    real::{identity, zero3},
    rows::{CONSTANT, WIDTH},
};
use nalgebra::Rotation3;

const DECLARED: Declared<f64> = Declared { norm: [1.02, 0.01], dip_sine: [0.7, 0.005] };

fn rows(field: &V3<f64>) -> [[f64; WIDTH]; 3] {
    let mut rows = [[0.0; WIDTH]; 3];
    reference(Block { rows: &mut rows, weight: 1.0, sigma: &[1.0; GLOBALS] }, field, &DECLARED);
    rows
}

#[test]
fn the_declared_field_leaves_nothing_in_any_heading() {
    for heading in [0.0, 1.0, 4.0_f64] {
        let across = (1.0 - 0.7_f64 * 0.7).sqrt();
        let field = V3::new(across * heading.cos(), across * heading.sin(), -0.7) * 1.02;
        assert!(rows(&field).iter().all(|row| row[CONSTANT].abs() < 1e-12));
        assert!((dip_sine(&field) - 0.7).abs() < 1e-12);
    }
}

#[test]
fn coefficients_are_the_slopes_of_the_constants() {
    let field = V3::new(0.5, -0.3, -0.9);
    let at = rows(&field);
    for axis in 0..3 {
        let mut moved = field;
        moved[axis] += 1e-6;
        for (row, before) in rows(&moved).iter().zip(&at) {
            let slope = (row[CONSTANT] - before[CONSTANT]) / 1e-6;
            assert!((slope - before[OLD + FIELD + axis]).abs() < 1e-3, "{axis}: {slope}");
            // Only the columns of the node's field are not zero.
            let others = before.iter().enumerate().take(CONSTANT);
            assert!(others.filter(|(c, _)| !(FIELD..NODE).contains(c)).all(|(_, x)| *x == 0.0));
        }
    }
}

#[test]
fn the_row_of_a_column_is_the_misfit_of_a_field_that_is_read_with_it() {
    let (field, attitude) = (V3::new(0.5, -0.3, -0.9), *Rotation3::new(V3::new(0.4, -1.1, 2.0)).matrix());
    let sigma: [f64; GLOBALS] = core::array::from_fn(|c| 0.01 + 0.002 * c as f64);
    let corrected: [f64; GLOBALS] = core::array::from_fn(|c| 0.3 - 0.1 * c as f64);
    let rows = reference_rows(&field, &attitude, &DECLARED, (0.5, &corrected, &sigma));
    for column in 0..OF_MAGNETOMETER {
        let mut x = [0.0; GLOBALS];
        x[column] = 1e-5 * sigma[column];
        let with = Parameters::new(&x, &zero3(), identity::<f64>());
        let read = attitude * (with.mag_matrix * (attitude.transpose() * field) + with.hard_iron);
        for (row, misfit) in misfits(&read, &DECLARED).iter().enumerate() {
            let removed: f64 = rows.by[row].iter().zip(&corrected).map(|(by, x)| by * x).sum();
            let slope = (misfit * 0.5 - removed - rows.constants[row]) / 1e-5;
            assert!((slope - rows.by[row][column]).abs() < 1e-3, "{column}: {slope} {}", rows.by[row][column]);
        }
    }
}
