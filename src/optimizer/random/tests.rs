use super::*;
use rand_core::SeedableRng;

#[test]
fn normal_has_the_moments_of_a_normal() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
    let n = 100_000;
    let (mut m1, mut m2) = (0.0_f64, 0.0_f64);
    for _ in 0..n {
        let x = f64::from(normal(&mut generator));
        m1 += x;
        m2 += x * x;
    }
    // 4 standard errors: 0.0126 of the mean, 0.018 of the variance.
    assert!((m1 / f64::from(n)).abs() < 0.0127);
    assert!((m2 / f64::from(n) - 1.0).abs() < 0.018);
}

#[test]
fn cosine_is_within_its_bound() {
    for k in 0..1000 {
        let a = k as f32 / 1000.0;
        assert!((cosine_of_turn(a) - libm::cosf(2.0 * core::f32::consts::PI * a)).abs() < 0.0017, "{a}");
    }
}
