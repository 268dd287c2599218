use super::*;

#[test]
fn what_is_whitened_has_the_squared_length_of_the_inverse_covariance() {
    let s = Matrix3::new(4.0, 1.0, -0.5, 1.0, 3.0, 0.2, -0.5, 0.2, 2.0);
    let v = Vector3::new(1.0, -2.0, 0.7);
    let whitening = Whitening::new(&s).unwrap();
    let exact = v.dot(&(s.try_inverse().unwrap() * v));
    assert!((whitening.apply(&v).norm_squared() - exact).abs() < 1e-5);
    assert!((whitening.log_determinant() - libm::logf(s.determinant())).abs() < 1e-5);
    assert!(Whitening::new(&Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0))).is_none());
    assert!(Whitening::new(&(s * f32::NAN)).is_none());
}
