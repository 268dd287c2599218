use super::*;

#[test]
fn derivatives_with_respect_to_columns_are_those_of_the_matrices() {
    let (bias, p) = (zero3::<f64>(), identity::<f64>());
    // f = sum of c_ij M_ij is linear, so its derivative is what a unit of a column changes it by.
    let c: [f64; 9] = core::array::from_fn(|k| 0.3 + 0.7 * k as f64 - 0.05 * (k * k) as f64);
    let f = |m: &M3<f64>| (0..9).map(|k| c[k] * (m - identity::<f64>())[(k / 3, k % 3)]).sum::<f64>();
    for column in 0..GLOBALS {
        let mut x = [0.0; GLOBALS];
        x[column] = 1.0;
        let parameters = Parameters::new(&x, &bias, p);
        let mag = column.checked_sub(MAG_MATRIX.from).and_then(|k| mag_columns(&c).get(k).copied()).unwrap_or(0.0);
        let accel =
            column.checked_sub(ACCEL_MATRIX.from).and_then(|k| accel_columns(&c).get(k).copied()).unwrap_or(0.0);
        assert!((f(&parameters.mag_matrix) - mag).abs() < 1e-6, "{column}");
        assert!((f(&parameters.accel_matrix) - accel).abs() < 1e-6, "{column}");
    }
}

#[test]
fn the_magnetometer_matrix_has_no_trace_and_its_columns_are_orthonormal() {
    for column in MAG_MATRIX.columns() {
        let mut x = [0.0; GLOBALS];
        x[column] = 1.0;
        let m = Parameters::new(&x, &zero3(), identity::<f64>()).mag_matrix - identity::<f64>();
        assert!(m.trace().abs() < 1e-7 && (m.norm() - 1.0).abs() < 1e-7);
    }
}
