//! Chi-square of an innovation, against the joint covariance.

use super::*;
use nalgebra::{Matrix3, SMatrix, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn chi_square_is_that_of_the_joint_covariance() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
    let (mut node, mut globals) = (Node::<f64>::zero(), Globals::<f64>::zero());
    let mut root = SMatrix::<f64, 49, 49>::zeros();
    for i in 0..49 {
        for j in i..49 {
            root[(i, j)] = uniform() + if i == j { 2.0 } else { 0.0 };
            if i < NODE {
                node.root[i][j] = root[(i, j)];
            } else {
                globals.root[i - NODE][j - NODE] = root[(i, j)];
            }
        }
    }
    let mut rows = [[0.0; WIDTH]; 3];
    rows.as_flattened_mut().iter_mut().for_each(|x| *x = uniform());
    let h = SMatrix::<f64, 3, 49>::from_fn(|i, j| rows[i][if j < NODE { j } else { GLOBAL + j - NODE }]);
    let states = h * (root.transpose() * root).try_inverse().unwrap() * h.transpose();
    let innovation = Innovation::new(&rows, &node, &globals);
    assert!((innovation.covariance - states).amax() < 1e-12 * states.amax());
    let value = Vector3::from_fn(|i, _| rows[i][CONSTANT]);
    for noise in [0.5, 1.0, 3.0] {
        let covariance = states + Matrix3::identity() * noise;
        let chi_square = value.dot(&(covariance.try_inverse().unwrap() * value));
        // Innovations just below and just above the chi-square limit.
        for (factor, expected) in [(0.999, false), (1.001, true)] {
            let scale = factor * (f64::from(CONTRADICTED) / chi_square).sqrt();
            let scaled = Innovation { value: value * scale, ..innovation };
            assert!(may_contradict(&(scaled.value / noise.sqrt())) || !scaled.is_contradicted(noise));
            assert_eq!(scaled.is_contradicted(noise), expected);
        }
    }
    let along = Vector3::new(0.3, -1.0, 0.4).normalize();
    for noise in [1.0, 20.0] {
        let sigma = (along.dot(&(states * along)) + noise).sqrt();
        for (factor, expected) in [(0.999, false), (1.001, true), (-1.001, true)] {
            let size = factor * f64::from(CONTRADICTED_ALONG).sqrt() * sigma;
            assert_eq!(innovation.is_contradicted_along(&along, size, noise), expected);
        }
    }
}

/// Chances that the limits state, by the tails of chi-square of three degrees of freedom and of one.
#[test]
fn limits_are_exceeded_as_often_by_chance_as_they_say() {
    let [three, one] = [CONTRADICTED, CONTRADICTED_ALONG].map(f64::from);
    let tail = |x: f64| libm::erfc(libm::sqrt(0.5 * x));
    let of_three = tail(three) + libm::sqrt(2.0 * three / core::f64::consts::PI) * libm::exp(-0.5 * three);
    assert!((of_three / 1e-4 - 1.0).abs() < 0.02, "{of_three}");
    assert!((tail(one) / 1e-3 - 1.0).abs() < 0.02, "{}", tail(one));
}
