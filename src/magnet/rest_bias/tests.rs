use super::*;

#[test]
fn rests_average_and_age() {
    let rest = |x: f32| Rest { rate: Vector3::repeat(x), variance: 1e-6, samples: 100 };
    let first = RestBias::from_rest(&rest(0.01));
    let both = first.updated(&rest(0.02));
    assert!((both.rate.x - 0.015).abs() < 1e-6);
    assert!((both.variance / first.variance - 0.5).abs() < 1e-3);
    assert!(both.predicted(100.0, 2e-5).variance > both.variance);
}
