//! The model that is flown is never worse than the factory's P with the bias alone, and better where P is wrong by
//! percents.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::needless_range_loop, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod played;
mod recordings;
mod study;

use meerkat_mwd::{config::OptimizerKind, identification::Decision};
use mwd::commands::main_job::recording;
use played::{play, play_against_reference};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::systematic_rate_error_rad_s,
    simulate::{Effects, Gyro, MagneticBursts, Scenario, known_error, simulate},
    trace::Trace,
};

use rig::handheld::{self, GyroError, KINDS};

const OPTIMIZERS: [OptimizerKind; 3] = [OptimizerKind::Imoa, OptimizerKind::Lm, OptimizerKind::Ls];

/// Largest error of an element of the flown P on the bundled recording: what errors of this unit's vector
/// sensors put into a fit of P (1 to 4 %).
const LARGEST_P_ERROR: f32 = 0.04;

#[test]
fn a_factory_calibrated_gyro_is_not_made_worse() {
    let trace = Trace::read(&recording()).unwrap();
    for optimizer in OPTIMIZERS {
        for hold_out in [0.3, 0.4, 0.5, 0.6, 0.7] {
            let played = play(&trace, hold_out, optimizer).unwrap();
            println!("{optimizer:?} {hold_out}: {:.3}", played.ratio());
            assert!(!played.harmful(), "{optimizer:?} {hold_out}: {:?}", played.scores);
        }
    }
}

/// At 10 % and at 2 %: the mean share of what there is to be had, which is down to the bias alone before the
/// error was multiplied in.
#[test]
fn a_known_error_is_found_and_taken_out() {
    let trace = Trace::read(&recording()).unwrap();
    for optimizer in OPTIMIZERS {
        let attainable = play(&trace, 0.5, optimizer).unwrap().scores.bias_only.unwrap();
        for (scale, least) in [(1.0, 0.8), (0.2, 0.35)] {
            let mut shares = Vec::new();
            for seed in 0..10 {
                let truth = known_error::scaled(&known_error::draw(seed), scale);
                let mut wrong = trace.clone();
                known_error::apply(&mut wrong, &truth);
                let played = play(&wrong, 0.5, optimizer).unwrap();
                assert!(!played.harmful(), "{optimizer:?} {scale} {seed}: {:?}", played.scores);
                assert!(played.accepted(), "{optimizer:?} {scale} {seed}: {:?}", played.reports);
                let [flown, bias_only] = [played.scores.with_effects, played.scores.bias_only].map(Option::unwrap);
                shares.push((bias_only - flown) / (bias_only - attainable));
                let flown = played.reports.last().unwrap().flown;
                for (found, known) in flown.p.iter().flatten().zip(truth.p.iter().flatten()) {
                    assert!((found - known).abs() < LARGEST_P_ERROR, "{optimizer:?} {seed}: {found} for {known}");
                }
            }
            let mean = shares.iter().sum::<f64>() / shares.len() as f64;
            println!("{optimizer:?} {scale}: {mean:.3} of {shares:.3?}");
            assert!(mean > least, "{optimizer:?} {scale}: {mean} of {shares:?}");
        }
    }
}

#[test]
fn no_p_flies_that_makes_motion_by_hand_worse() {
    for error in [GyroError::Factory, GyroError::Percent(0.01), GyroError::Percent(0.1)] {
        let mut ratios = Vec::new();
        for kind in KINDS {
            for fast in [false, true] {
                let (trace, _) = handheld::record(kind, fast, error, 110.0, 500 + kind as u64);
                let Some(played) = play(&trace, 0.5, OptimizerKind::Lm) else { continue };
                println!("{error:?} {kind:?} fast {fast}: {:.3}", played.ratio());
                assert!(!played.harmful(), "{error:?} {kind:?} fast {fast}: {:?}", played.scores);
                ratios.push(played.ratio());
            }
        }
        ratios.sort_by(f64::total_cmp);
        let median = ratios[ratios.len() / 2];
        assert!(error != GyroError::Percent(0.1) || median < 0.5, "{ratios:?}");
    }
}

/// Between bursts of the field: what they leave in their nodes, whatever the model, does not hide what P
/// explains in the others.
#[test]
fn a_p_off_by_percents_flies_though_the_field_bursts() {
    let mut good = 0;
    for seed in 200..220 {
        let magnetic_bursts = MagneticBursts { per_minute: 6.0, length_s: 2.5, peak_ut: 20.0 };
        let effects = Effects { magnetic_bursts, ..Effects::default() };
        let (trace, truth) = simulate(&Scenario { duration_s: 60.0, effects, ..Scenario::default() }, seed);
        let report = *fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap().reports.last().unwrap();
        let error = |model| systematic_rate_error_rad_s(&truth.gyro, model, trace.true_rate.as_ref().unwrap()).unwrap();
        let [flown, bias_only] = [&report.flown, &report.bias_only].map(error);
        println!("{seed}: {:.3} of the rate error with the bias alone, {:?}", flown / bias_only, report.decision);
        assert!(flown <= 1.05 * bias_only, "{seed}: {flown} of {bias_only}");
        good += u32::from(report.decision == Decision::Accepted && flown < 0.2 * bias_only);
    }
    // The other is better too, but less: 0.62 of the error with the bias alone is left.
    assert!(good >= 18, "{good} of 20");
}

/// A P within 0.7 % of the identity shows against a reference: 0.54 to 0.96 of the error with the bias alone
/// is left. The reference's vectors are taken to be as noisy as a magnetometer's and an accelerometer's, so
/// that more is not had.
#[test]
fn against_a_reference_some_of_a_factorys_small_error_is_taken_out() {
    let mut ratios = Vec::new();
    for kind in KINDS {
        for fast in [false, true] {
            let (trace, _) = handheld::record(kind, fast, GyroError::Factory, 110.0, 700 + kind as u64);
            let Some(played) = play_against_reference(&trace, 0.5) else { continue };
            ratios.push(played.ratio());
            println!("{kind:?} fast {fast}: {:.3}", played.ratio());
            assert!(
                played.accepted() && !played.harmful(),
                "{kind:?} fast {fast}: {:?} {:?}",
                played.scores,
                played.reports.last()
            );
        }
    }
    assert_eq!(ratios.len(), 2 * KINDS.len());
    assert!(ratios.iter().sum::<f64>() < 0.8 * ratios.len() as f64, "{ratios:?}");
}

/// Nothing tells the estimator of a gyro forty times as noisy as a data sheet's: a P that is right is then
/// bent, and 7 of 20 are harmed, the worst to 1.98 times the error with the bias alone. That is no bound to
/// be content with: none was, when a result had to explain the misfit.
#[test]
fn against_a_reference_a_noise_that_nobody_declared_harms_within_bounds() {
    let mut harmed = 0;
    for seed in 100..120 {
        let gyro = Gyro { diagonal_sigma: 0.0, off_diagonal_sigma: 0.0, noise_deg_s_rthz: 0.2, ..Gyro::default() };
        let (trace, _) = simulate(&Scenario { duration_s: 120.0, gyro, ..Scenario::default() }, seed);
        let played = play_against_reference(&trace, 0.5).unwrap();
        println!("{seed}: {:.3}", played.ratio());
        assert!(played.ratio() < 2.1, "{seed}: {:?}", played.reports);
        harmed += u32::from(played.harmful());
    }
    assert!(harmed <= 8, "{harmed} of 20");
}
