use super::motions::{bias, close};
use meerkat_mwd::compensation::GyroModel;
use testbed::score;

#[test]
fn systematic_rate_error_is_the_algebra_of_the_two_models() {
    let rates = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -2.0]];
    let error =
        |truth: &GyroModel, estimate: &GyroModel| score::systematic_rate_error_rad_s(truth, estimate, &rates).unwrap();
    let truth = testbed::simulate::known_error::draw(1);
    assert!(error(&truth, &truth) < 1e-7);
    // A bias on one axis of three.
    assert!((error(&bias(3.0), &GyroModel::IDENTITY) - 3_f64.to_radians() / 3_f64.sqrt()).abs() < 1e-7);
    // Half of every rate is read: P = 2 I. Rms of the rates over 9 values is 1.
    let half = GyroModel { p: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], b_rad_s: [0.0; 3] };
    assert!((error(&half, &GyroModel::IDENTITY) - 0.5).abs() < 1e-12);
    assert_eq!(score::systematic_rate_error_rad_s(&truth, &truth, &[]), None);
    close(score::rate_error_rad_s(&[[1.0, 0.0, 0.0]], &[[0.0, 0.0, 0.0]]), 1.0 / 3_f64.sqrt(), 1e-12);
}
