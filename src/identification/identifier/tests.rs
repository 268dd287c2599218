//! The bias of a rest beside effects that fly.

extern crate std;

use super::*;
use crate::{
    compensation::{FoundEffect, effects::LIBRARY},
    units::DEG_S_PER_G,
};
use nalgebra::{Matrix3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::boxed::Box;

/// An effect that flies and is in the raw rate is subtracted once, whether or not the estimator takes it out, too.
#[test]
fn at_a_rest_a_g_sensitivity_that_flies_is_subtracted_once() {
    let config = Config { sample_period_us: 10_000, ..Config::default() };
    let index = LIBRARY.iter().position(|effect| effect.name() == "g_sensitivity").unwrap();
    let felt = Matrix3::new(0.05, -0.02, 0.04, 0.03, 0.05, -0.05, 0.01, 0.02, 0.05) / DEG_S_PER_G;
    let mut effects = ActiveEffects::none();
    let mut found = FoundEffect { index: index as u8, sigma: [0.01 / DEG_S_PER_G; 9], ..Default::default() };
    found.parameters.iter_mut().zip(felt.transpose().iter()).for_each(|(to, x)| *to = *x);
    assert!(effects.add(found));
    let (force, field) = (Vector3::new(3.0, -4.0, 8.4), Vector3::new(20.0, 5.0, 40.0));
    let (bias, added) = (Vector3::new(0.004, -0.003, 0.002), felt * force);
    for is_taken_out in [true, false] {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut noisy = |v: Vector3<f32>, width: f32| {
            Reading::Usable(v.map(|x| x + width * (random.next_u32() as f32 / u32::MAX as f32 - 0.5)))
        };
        let mut identifier = Box::new(Identifier::<0, 44, 1>::zero());
        identifier.configure(&config, &LIBRARY);
        identifier.restore(&config, &config.gyro, &[0.01; 12], &effects);
        if !is_taken_out {
            identifier.estimator.configure(&Settings::new(&config), &LIBRARY);
        }
        identifier.start(0);
        for k in 0..1_200 {
            let t_us = k * 10_000;
            if identifier.is_due(t_us) {
                let _ = identifier.take_effect(t_us, &config);
            }
            identifier.push(t_us, [noisy(bias + added, 2e-3), noisy(force, 0.05), noisy(field, 0.5)], Some(0.0));
            while identifier.step(&config) > 0 {}
        }
        assert!(!identifier.effects().is_empty() && identifier.flown_since_us().is_some());
        let left = Vector3::from(identifier.flown().b_rad_s) - bias;
        assert!(left.norm().to_degrees() < 0.01, "{is_taken_out}: {left:?}");
    }
}
