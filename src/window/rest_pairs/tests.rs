use super::*;
use crate::{
    rotation::rotate_back,
    window::{Equations, TestEquations},
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const IDENTITY_MODEL: [f32; GYRO] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
const DT_S: f32 = 0.02;

/// A tool that is turned by hand between rests of three seconds.
struct Played {
    pairs: RestPairs,
    truth: Quaternion<f32>,
    generator: Xoshiro128PlusPlus,
    inverse: Matrix3<f32>,
    bias: Vector3<f32>,
    t_us: u64,
}

impl Played {
    fn new(p: Matrix3<f32>, bias: Vector3<f32>) -> Self {
        let mut pairs = RestPairs::zero();
        pairs.start(&IDENTITY_MODEL);
        let generator = Xoshiro128PlusPlus::seed_from_u64(5);
        Self { pairs, truth: IDENTITY, generator, inverse: p.try_inverse().unwrap(), bias, t_us: 0 }
    }

    fn deviate(&mut self) -> f32 {
        self.generator.next_u32() as f32 / (u32::MAX / 2) as f32 - 1.0
    }

    fn second(&mut self, rate: impl Fn(f32) -> Vector3<f32>, at_rest: bool) {
        for k in 0..50_u16 {
            let rate = rate(f32::from(k) * DT_S + 0.5 * DT_S);
            self.pairs.push(Some(&(self.inverse * rate + self.bias)), DT_S);
            self.truth = renormalised(&(self.truth * exp_quaternion(&(rate * DT_S))));
        }
        self.t_us += 1_000_000;
        let rest = Rest {
            rate: self.bias,
            variance: 1e-6,
            samples: 100,
            force_m_s2: Some(rotate_back(&self.truth, &Vector3::new(0.0, 0.0, -9.81))),
            force_variance: 1e-6,
        };
        self.pairs.second(self.t_us, at_rest.then_some(&rest));
    }

    fn turns(&mut self, count: u32) {
        for _ in 0..count {
            (0..3).for_each(|_| self.second(|_| Vector3::zeros(), true));
            for _ in 0..3 {
                let rate = Vector3::new(self.deviate(), self.deviate(), self.deviate()) * 1.5;
                self.second(|t_s| rate * libm::sinf(core::f32::consts::PI * t_s), false);
            }
        }
    }

    fn solved(&self) -> [f32; GYRO] {
        let mut sum = Equations::zero();
        for pair in self.pairs.until(self.pairs.count()) {
            let test = TestEquations { gravity: pair.rows, ..TestEquations::zero() };
            sum.add(&test, &IDENTITY_MODEL, [1.0; 2]);
        }
        let mut normal = sum.gravity.normal;
        (0..GYRO).for_each(|i| normal.add(i, i, 1e-3));
        normal.cholesky().unwrap().solve(&sum.gravity.rhs)
    }
}

#[test]
fn percents_of_scale_and_coupling_and_a_bias_are_found_from_twelve_turns() {
    let p = Matrix3::new(1.02, -0.005, 0.01, 0.007, 0.985, 0.012, -0.01, 0.004, 1.01);
    let bias = Vector3::new(0.1, -0.2, 0.05);
    let mut played = Played::new(p, bias);
    played.turns(14);
    assert_eq!((played.pairs.count(), played.pairs.until(played.pairs.count()).count()), (13, PAIRS));
    let x = played.solved();
    let c = p * bias;
    for i in 0..3 {
        for j in 0..3 {
            let truth = p[(i, j)] - if i == j { 1.0 } else { 0.0 };
            // of second order in 2 % of three radians
            assert!((x[3 * i + j] - truth).abs() < 2e-3, "P{i}{j} {} {truth}", x[3 * i + j]);
        }
        assert!((x[9 + i] - c[i]).abs() < 1e-3, "c{i} {} {}", x[9 + i], c[i]);
    }
}

#[test]
fn a_turn_that_is_too_long_or_has_no_rate_makes_no_pair_and_another_model_one() {
    let still = |_: f32| Vector3::zeros();
    let turning = |_: f32| Vector3::new(0.3, 0.2, 0.1);
    let pairs_after = |between: &dyn Fn(&mut Played)| {
        let mut played = Played::new(Matrix3::identity(), Vector3::zeros());
        played.second(still, true);
        played.second(turning, false);
        between(&mut played);
        played.second(still, true);
        played.second(turning, false);
        played.pairs.count()
    };
    assert_eq!(pairs_after(&|_| {}), 1);
    assert_eq!(pairs_after(&|played| (1..LONGEST_S).for_each(|_| played.second(turning, false))), 1);
    assert_eq!(pairs_after(&|played| (0..LONGEST_S).for_each(|_| played.second(turning, false))), 0);
    assert_eq!(pairs_after(&|played| played.pairs.push(None, DT_S)), 0);
    assert_eq!(pairs_after(&|played| played.pairs.change_model(&[0.5; GYRO])), 1);
}

#[test]
fn a_long_rest_is_one_rest_and_pairs_that_were_overwritten_are_not_used() {
    let mut played = Played::new(Matrix3::identity(), Vector3::zeros());
    played.turns(2);
    (0..20).for_each(|_| played.second(|_| Vector3::zeros(), true));
    assert_eq!(played.pairs.count(), 2);
    played.turns(13);
    let count = played.pairs.count();
    assert_eq!(played.pairs.until(count - 2).count(), PAIRS);
    assert_eq!(played.pairs.until(count - 3).count(), 0);
}
