use super::*;

/// Unknowns and a centre off every axis.
fn given() -> ([f64; 9], M3<f64>) {
    let d = core::array::from_fn(|k| 0.07 * libm::sin(1.0 + 2.3 * k as f64));
    let centre = Matrix3::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.05 * libm::cos((4 * i + 3 * j) as f64));
    (d, centre)
}

#[test]
fn a_turn_of_any_size_leaves_the_scales_as_they_are() {
    let (_, centre) = given();
    let (x, y, z) = (0.3, -0.4, 0.2);
    let p = GyroMatrix::new(&[0.0, -z, y, z, 0.0, -x, -y, x, 0.0], &centre).p;
    assert!((p.transpose() * p - centre.transpose() * centre).norm() < 1e-8);
}

#[test]
fn to_first_order_p_is_the_centre_and_its_deviation() {
    let (d, centre) = given();
    let small = d.map(|d| 1e-3 * d);
    let p = GyroMatrix::new(&small, &centre).p;
    assert!((p - (identity::<f64>() + M3::from_row_slice(&small)) * centre).norm() < 1e-7);
}

#[test]
fn derivatives_by_the_unknowns_are_differences_of_p() {
    let (d, centre) = given();
    let matrix = GyroMatrix::new(&d, &centre);
    // f = sum of c_ij P_ij, for three sets of c at once.
    let c: [V3<f64>; 9] = core::array::from_fn(|k| {
        let k = k as f64;
        V3::new(0.3 + 0.7 * k, libm::sin(k), 1.0 - 0.05 * k * k)
    });
    let f = |p: &M3<f64>| (0..9).fold(V3::zeros(), |sum, k| sum + c[k] * p[(k / 3, k % 3)]);
    let mut by = c;
    matrix.by_unknowns(&centre, &mut by);
    for k in 0..9 {
        let at = |step: f64| {
            let mut d = d;
            d[k] += step;
            f(&GyroMatrix::new(&d, &centre).p)
        };
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((by[k] - difference).norm() < 1e-4, "{k}: {} {difference}", by[k]);
    }
}

#[test]
fn unknowns_are_found_from_p() {
    let (d, centre) = given();
    let found = unknowns(&GyroMatrix::new(&d, &centre).p.cast(), &centre.cast());
    for (found, d) in found.iter().zip(&d) {
        assert!((f64::from(*found) - d).abs() < 1e-6, "{found} {d}");
    }
}
