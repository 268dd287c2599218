//! A step of the bias after a shock, and a long gap: what the posterior, and the search about it, make of them.

extern crate std;

use super::{super::Claim, motion::Simulated, settings};
use crate::{
    compensation::{effect::MAX_PARAMETERS, effects::LIBRARY},
    estimator::{CandidateSet, Estimator},
    sample::Reading,
};
use nalgebra::Vector3;
use std::boxed::Box;

/// Raw rate that a blow of 6 g at second 45 adds to each axis, rad/s.
const STEP_RAD_S: f32 = 0.0175;

/// An estimator after a blow that has changed the bias, its window searched.
fn struck(seed: u64, seconds: f64) -> Box<Estimator<f64>> {
    let mut estimator = Box::new(Estimator::zero());
    estimator.configure(&settings(), &LIBRARY);
    for (t_us, [rate, force, field]) in Simulated::new(seed, seconds).samples {
        let rate = match rate {
            Reading::Usable(rate) if t_us > 45_000_000 => Reading::Usable(rate.add_scalar(STEP_RAD_S)),
            other => other,
        };
        let force = if t_us == 45_000_000 { Reading::Usable(Vector3::new(0.0, 0.0, 60.0)) } else { force };
        estimator.push(t_us, [rate, force, field], None);
        while estimator.step() > 0 {}
    }
    estimator.close(true);
    while estimator.step() > 0 {}
    estimator
}

#[test]
fn a_step_of_the_bias_is_the_same_raw_rate_for_the_posterior_for_bias_only_and_for_the_search() {
    for seed in 3..6 {
        let estimator = struck(seed, 90.0);
        assert!(estimator.claims().iter().any(|claim| claim.step_us > 0), "{seed}: {:?}", estimator.claims());
        let posterior = estimator.posterior().unwrap();
        let cost = estimator.window_cost().unwrap();
        for model in [cost.model(&[0.0; 12]), posterior.bias_only] {
            let off = Vector3::from(model.b_rad_s) - Vector3::from(posterior.gyro.b_rad_s);
            assert!(off.norm() < 1e-6, "{seed}: {off:?}");
        }
        let there = cost.coordinates(&cost.model(&[0.5; 12]));
        assert!(there.iter().all(|y| (y - 0.5).abs() < 1e-3), "{seed}: {there:?}");
    }
}

#[test]
fn a_step_that_settles_is_no_measured_bias() {
    let mut estimator = Box::new(Estimator::<f64>::zero());
    estimator.configure(&settings(), &[]);
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[0] = 0.01;
    estimator.filter.settle(&Claim {
        effect: 0,
        step: 0,
        step_us: 1,
        evidence: 20.0,
        parameters,
        sigma: [0.0; MAX_PARAMETERS],
        size: 0.0,
        size_sigma: 0.0,
        rivals: CandidateSet::EMPTY,
        is_taken_out: true,
    });
    assert!(!estimator.filter.has_measured_bias && (estimator.filter.bias.x - 0.01).abs() < 1e-6);
}

/// An hour of the bias's walk, 2e-4 deg/s/s^0.5 and more.
#[test]
fn bias_and_p_walk_through_a_gap() {
    let deviation = |gap_us: u64, until_us: u64| {
        let mut estimator = super::estimator::<f64>();
        for (t_us, [rate, force, field]) in Simulated::new(5, 34.0).samples {
            if t_us > until_us {
                break;
            }
            let t_us = if t_us > 30_000_000 { t_us + gap_us } else { t_us };
            estimator.push(t_us, [rate, force, field], None);
            while estimator.step() > 0 {}
        }
        estimator.close(false);
        while estimator.step() > 0 {}
        estimator.posterior().unwrap().sigma
    };
    // The second time the posterior is asked for before the attitude is aligned anew.
    for until_us in [34_000_000, 30_300_000] {
        let (short, long) = (deviation(2_000_000, until_us), deviation(3_600_000_000, until_us));
        let grown = |k: usize| long[k] / short[k];
        assert!((9..12).all(|k| long[k] > 1e-3 && grown(k) > 2.0), "{until_us}: {short:?} {long:?}");
        assert!((0..9).all(|k| grown(k) > 0.95), "{until_us}: {short:?} {long:?}");
    }
}
