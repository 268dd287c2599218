//! Rows of the declared field of the earth.

use super::{Block, OLD};
use crate::estimator::{
    columns::FIELD,
    real::{Real, V3, norm},
};

/// The earth's field as a survey's reference has it, in units of the estimator's field.
#[derive(Clone, Copy)]
pub(in crate::estimator) struct Declared<T> {
    /// Norm and its deviation, which includes the magnetometer's scale.
    pub norm: [T; 2],
    /// Sine of the dip below the horizontal, and its deviation.
    pub dip_sine: [T; 2],
}

/// Slopes by the field, earth frame, of norm and dip over their deviations.
pub(in crate::estimator) fn slopes<T: Real>(field: &V3<T>, declared: &Declared<T>) -> [V3<T>; 2] {
    let length = norm(field);
    let along = field / length;
    let down = (along * along.z - V3::z()) / length;
    [along / declared.norm[1], down / declared.dip_sine[1]]
}

/// Writes the rows that the node's field has the declared norm and the declared dip.
pub(in crate::estimator) fn reference<T: Real>(mut block: Block<T>, field: &V3<T>, declared: &Declared<T>) {
    let length = norm(field);
    let [of_norm, of_dip] = slopes(field, declared);
    let zero = V3::new(T::ZERO, T::ZERO, T::ZERO);
    block.states(OLD + FIELD, &nalgebra::Matrix3::from_rows(&[of_norm, of_dip, zero].map(|row| row.transpose())));
    let norm = (length - declared.norm[0]) / declared.norm[1];
    let dip = (dip_sine(field) - declared.dip_sine[0]) / declared.dip_sine[1];
    block.constant(&V3::new(norm, dip, T::ZERO));
}

/// Sine of the dip of a field.
pub(in crate::estimator) fn dip_sine<T: Real>(field: &V3<T>) -> T {
    -field.z / norm(field)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{
        columns::{GLOBALS, NODE},
        rows::{CONSTANT, WIDTH},
    };

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
}
