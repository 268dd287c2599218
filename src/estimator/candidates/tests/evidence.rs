//! The evidence of candidates is that of the whole least-squares problem, and the right ones are chosen.

#![allow(clippy::single_range_in_vec_init)] // A list of one range of columns.

extern crate std;

use super::{
    super::{CandidateSet, Misfit, Rules, Units, Unturned, column_id::ColumnId, evidence::Evidence},
    BENDS, COLUMNS, Candidates, E, GLOBALS, Globals, LAGS, MADE, OF_BEND, OF_IRON, OF_LAG, OF_SHEAR, OF_STEP, OF_TWIST,
    Row, SCRATCH, SHEARS, STEPS_FROM, TWISTS, WIDTH, deviate,
    problem::{Problem, SOUND, columns_of},
    shake,
};
use crate::{
    compensation::{ActiveEffects, FoundEffect},
    estimator::columns::{HARD_IRON, NUISANCES},
};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{boxed::Box, vec::Vec};

/// No effect can be worth so much.
const NEVER: f32 = 1e30;

fn as_they_are(_: &mut Row, _: &mut Xoshiro128PlusPlus) {}

fn is_about(found: f32, expected: f64, what: &str) {
    assert!((f64::from(found) - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{what}: {found}, {expected}");
}

const SOME: [(usize, f64); 5] = [
    (GLOBALS + SHEARS, 0.6),
    (GLOBALS + LAGS, 0.5),
    (GLOBALS + STEPS_FROM, -0.4),
    (HARD_IRON.from + 1, 0.3),
    (GLOBALS + BENDS + 1, 1.2),
];

#[test]
fn what_each_effect_is_worth_is_the_ratio_of_the_marginal_likelihoods() {
    for seed in 0..4 {
        let mut problem = Problem::new(seed, &SOME, as_they_are);
        problem.weigh(&Rules { least: NEVER, with_nuisances: false });
        let without = problem.likelihood(&[]);
        for effect in [OF_SHEAR, OF_LAG, OF_IRON, OF_BEND, OF_TWIST] {
            let mut expected = problem.likelihood(&[columns_of(effect)]) - without;
            // A lag cannot be negative.
            if effect == OF_LAG && problem.posterior(&[columns_of(OF_LAG)]).0[GLOBALS + LAGS] < 0.0 {
                expected = 0.0;
            }
            is_about(problem.evidence.choice.tried[effect], expected, "alone");
        }
        assert!(problem.evidence.account.claims.is_empty() && problem.known.candidates.root.x == [0.0; E]);
        // No shock, no step; what the library has no name for competes, too: the rest of the table is none.
        let (further, others) = problem.evidence.choice.tried[6..].split_at(2 + 6);
        assert!(problem.evidence.choice.tried[OF_STEP] == 0.0 && further[..2] == [0.0; 2]);
        assert!(others.iter().all(|tried| *tried == 0.0));

        problem.weigh_again(&Rules { least: NEVER, with_nuisances: true });
        let without = problem.likelihood(&[0..NUISANCES]);
        for effect in [OF_SHEAR, OF_BEND, OF_TWIST] {
            let expected = problem.likelihood(&[0..NUISANCES, columns_of(effect)]) - without;
            is_about(problem.evidence.choice.tried[effect], expected, "with all nuisances");
        }
        assert_eq!(problem.evidence.choice.tried[OF_IRON], 0.0);
    }
}

#[test]
fn a_negative_lag_is_none() {
    let mut problem = Problem::new(9, &[(GLOBALS + LAGS, -4.0)], as_they_are);
    problem.weigh(&Rules { least: NEVER, with_nuisances: false });
    assert_eq!(problem.evidence.choice.tried[OF_LAG], 0.0);
    let mut problem = Problem::new(9, &[(GLOBALS + LAGS, 4.0)], as_they_are);
    problem.weigh(&Rules { least: NEVER, with_nuisances: false });
    assert!(problem.evidence.choice.tried[OF_LAG] > 10.0, "{}", problem.evidence.choice.tried[OF_LAG]);
}

#[test]
fn what_is_there_is_claimed_as_the_posterior_says_and_what_is_not_is_not() {
    let truth = [(GLOBALS + SHEARS, 3.0), (GLOBALS + SHEARS + 1, -2.0), (HARD_IRON.from + 2, 2.5)];
    for seed in 20..30 {
        let mut problem = Problem::new(seed, &truth, as_they_are);
        problem.weigh(&Rules { least: 5.0, with_nuisances: false });
        assert_eq!(problem.claimed(), [OF_SHEAR, OF_IRON], "{seed}: {:?}", problem.evidence.choice.tried);
        let both = [columns_of(OF_SHEAR), columns_of(OF_IRON)];
        let ((_, joint), all) = (problem.posterior(&both), problem.likelihood(&both));
        for claim in &problem.evidence.account.claims {
            let effect = usize::from(claim.effect);
            let columns = columns_of(effect);
            let (mean, covariance) = problem.averaged(&both, &columns);
            let others: Vec<_> = both.iter().filter(|other| **other != columns).cloned().collect();
            is_about(claim.evidence, all - problem.likelihood(&others), "the evidence beside all others");
            let (mut square, mut square_sigma) = (0.0, 0.0);
            for (k, column) in columns.clone().enumerate() {
                let usual = MADE[effect].parameters()[k].usual;
                let unit = if effect == OF_IRON { problem.sigma[column] } else { f64::from(usual) };
                let (value, sigma) = (mean[column] * unit, libm::sqrt(covariance[(column, column)]) * unit);
                is_about(claim.parameters[k], value, "size");
                is_about(claim.sigma[k], sigma, "deviation");
                // Sizes that one unit of a parameter adds: 1, 2, 3 and so on.
                let before: usize = MADE[..effect].iter().map(|effect| effect.parameters().len()).sum();
                let shown = (1 + before + k) as f64;
                square += value * value * shown * shown;
                square_sigma += sigma * sigma * shown * shown;
            }
            is_about(claim.size, libm::sqrt(square), "what it adds");
            is_about(claim.size_sigma, libm::sqrt(square_sigma), "what its deviations add");
            assert!(claim.is_taken_out && claim.rivals == CandidateSet::EMPTY, "{claim:?}");
        }
        // The mean of the shear is taken out.
        let (found, evidence) = (problem.known.candidates.root.x, &problem.evidence);
        let (mean, _) = problem.averaged(&both, &columns_of(OF_SHEAR));
        assert_eq!(evidence.account.taken.as_slice(), [0, 1].map(ColumnId::of_effect));
        for (e, x) in found.iter().enumerate() {
            let expected = if e < 2 { mean[GLOBALS + e] } else { 0.0 };
            assert!((x - expected).abs() < 1e-9, "{e}: {x}, {expected}");
        }
        for (k, (i, j)) in [(0, 0), (1, 0), (1, 1)].into_iter().enumerate() {
            assert!((evidence.account.covariance[k] - joint[(GLOBALS + i, GLOBALS + j)]).abs() < 1e-12);
        }
        // Weighed again about what is taken out, the same comes out.
        let claims = problem.evidence.account.claims.clone();
        problem.weigh_again(&Rules { least: 5.0, with_nuisances: false });
        for (again, before) in problem.evidence.account.claims.iter().zip(&claims) {
            is_about(again.evidence, f64::from(before.evidence), "again");
            is_about(again.parameters[0], f64::from(before.parameters[0]), "again");
        }
        assert_eq!(problem.evidence.account.claims.len(), claims.len());
    }
}

#[test]
fn what_is_taken_out_is_as_uncertain_as_the_data_vary_but_no_more_than_its_prior() {
    let truth = [(GLOBALS + SHEARS, 3.0), (GLOBALS + SHEARS + 1, -2.0)];
    for seed in 20..24 {
        let mut problem = Problem::new(seed, &truth, as_they_are);
        let rules = Rules { least: 5.0, with_nuisances: false };
        problem.weigh(&rules);
        let sound: Vec<_> = problem.evidence.account.covariance[..3].to_vec();
        problem.weigh_as(&rules, Misfit { dispersion: 4.0, is_unexplained: false }, Unturned::NONE);
        assert_eq!(problem.claimed(), [OF_SHEAR]);
        let varied = &problem.evidence.account.covariance;
        for k in [0, 2] {
            let expected = (4.0 * sound[k]).min(1.0);
            assert!((varied[k] - expected).abs() < 1e-9, "{seed}: {} {expected}", varied[k]);
        }
        let together = sound[1] * libm::sqrt(varied[0] / sound[0]) * libm::sqrt(varied[2] / sound[2]);
        assert!((varied[1] - together).abs() < 1e-9);
    }
}

#[test]
fn without_any_effect_none_is_claimed() {
    let mut problems: Vec<_> = (100..140).map(|seed| Problem::new(seed, &[], as_they_are)).collect();
    problems.iter_mut().for_each(|problem| problem.weigh(&Rules { least: 5.0, with_nuisances: false }));
    let claims: usize = problems.iter().map(|problem| problem.evidence.account.claims.len()).sum();
    assert_eq!(claims, 0);
    let residual: f64 = problems.iter().map(|problem| problem.evidence.residual[0]).sum();
    assert!(problems.iter().all(|problem| problem.evidence.residual[0] >= problem.evidence.residual[1]));
    assert!(residual > 0.0);
}

#[test]
fn two_effects_that_read_the_same_are_rivals() {
    let mut problem = Problem::new(50, &[(GLOBALS + BENDS, 2.0)], |row, generator| {
        row.effects[TWISTS] = row.effects[BENDS] + 0.05 * deviate(generator);
        row.effects[BENDS + 1] = 0.0;
    });
    problem.weigh(&Rules { least: 5.0, with_nuisances: false });
    let [claim] = problem.evidence.account.claims.as_slice() else { panic!("{:?}", problem.evidence.account.claims) };
    let other = if usize::from(claim.effect) == OF_BEND { OF_TWIST } else { OF_BEND };
    assert_eq!(claim.rivals.bits(), 1 << other);
}

/// An effect that reads like two others together explains the most at first, and nothing once they are in.
#[test]
fn what_the_others_explain_as_well_is_let_go() {
    let truth = [(GLOBALS + TWISTS, 0.75), (GLOBALS + SHEARS, 1.0), (GLOBALS + SHEARS + 1, 1.0)];
    let mut let_go = 0;
    for seed in 60..80 {
        let mut problem = Problem::new(seed, &truth, |row, generator| {
            row.effects.iter_mut().for_each(|x| *x *= 6.0);
            let [shear, twist] = [row.effects[SHEARS] + row.effects[SHEARS + 1], row.effects[TWISTS]];
            row.effects[LAGS] = shear + twist + 1.5 * deviate(generator);
        });
        problem.weigh(&Rules { least: NEVER, with_nuisances: false });
        let tried = &problem.evidence.choice.tried;
        let is_first = tried.iter().all(|other| *other <= tried[OF_LAG]);
        let_go += usize::from(is_first);
        problem.weigh_again(&Rules { least: 5.0, with_nuisances: false });
        assert_eq!(problem.claimed(), [OF_SHEAR, OF_TWIST], "{seed}");
    }
    assert!(let_go > 15, "{let_go}");
}

#[test]
fn a_step_is_looked_for_after_its_shock_and_has_as_many_chances_as_there_were_shocks() {
    let truth = [(GLOBALS + STEPS_FROM + 3, 2.0), (GLOBALS + STEPS_FROM + 5, -1.0)];
    let mut problem = Problem::new(70, &truth, as_they_are);
    let mut now_us = 0;
    let shocks = &mut problem.known.candidates.shocks;
    for _ in 0..2 {
        shake(shocks, &mut now_us, 10, || 9.81);
        shake(shocks, &mut now_us, 1, || 200.0);
        shocks.begin_step(now_us, 200.0);
    }
    assert_eq!(shocks.seen, 2);
    let second_us = shocks.at_us(1).unwrap();
    problem.weigh(&Rules { least: NEVER, with_nuisances: false });
    let (without, second) = (problem.likelihood(&[]), GLOBALS + STEPS_FROM + 3..GLOBALS + STEPS_FROM + 6);
    let chances = libm::log(2.0);
    is_about(
        problem.evidence.choice.tried[OF_STEP],
        problem.likelihood(&[columns_of(OF_STEP)]) - without - chances,
        "first",
    );
    is_about(problem.evidence.choice.tried[6], problem.likelihood(&[second]) - without - chances, "second");
    // No third shock.
    assert_eq!(problem.evidence.choice.tried[7], 0.0);

    problem.weigh_again(&Rules { least: 5.0, with_nuisances: false });
    let [claim] = problem.evidence.account.claims.as_slice() else { panic!("{:?}", problem.evidence.account.claims) };
    assert_eq!((claim.effect, claim.step, claim.step_us), (OF_STEP as u8, 1, second_us));
    assert!((problem.known.candidates.stepped().x - 0.4).abs() < 0.1);
    // The first shows nothing and makes room for another; the second is claimed and stays.
    let Problem { known, evidence, .. } = &mut problem;
    known.candidates.note_steps(&evidence.account.claims, &evidence.choice.tried);
    for _ in 0..2 {
        now_us += 100_000_000;
        known.candidates.begin_step(now_us, 200.0);
    }
    assert_eq!((known.candidates.shocks.at_us(1), known.candidates.shocks.at_us(0)), (Some(second_us), Some(now_us)));
    assert!(known.candidates.old_step(&evidence.account.claims, second_us + 1_000_000).is_none());
    assert!(
        known
            .candidates
            .old_step(&evidence.account.claims, second_us + 1_000_000_000)
            .is_some_and(|claim| claim.step == 1)
    );
}

/// The chip's numbers: the root rounded to them, and weighed in them.
#[test]
fn in_f32_the_same_comes_out() {
    for (seed, scale) in [(80, 1.0), (81, 10.0), (82, 30.0)] {
        let mut problem = Problem::new(seed, &SOME, |row, generator| {
            row.effects.iter_mut().for_each(|x| *x *= scale);
            // The two parameters of an effect are hardly told apart.
            row.effects[BENDS + 1] = row.effects[BENDS] + 0.5 * deviate(generator);
        });
        let rules = Rules { least: 5.0, with_nuisances: false };
        problem.known.learn(&problem.rows);
        let (mut globals, mut candidates) = (Globals::<f32>::zero(), Box::new(Candidates::<f32, E>::zero()));
        let known = &problem.known;
        candidates.configure(&MADE);
        COLUMNS.iter().for_each(|(index, step)| {
            candidates.places.give_columns(*index, MADE[*index], *step).unwrap();
        });
        let narrowed = |x: f64| x as f32;
        globals.x = known.globals.x.map(narrowed);
        globals.root = known.globals.root.map(|row| row.map(narrowed));
        candidates.root.globals = known.candidates.root.globals.map(|row| row.map(narrowed));
        candidates.root.own = known.candidates.root.own.map(|row| row.map(narrowed));
        candidates.root.constants = known.candidates.root.constants.map(narrowed);
        (candidates.terms.increments, candidates.terms.squares) = (4, known.candidates.terms.squares.map(narrowed));
        let mut evidence = Box::new(Evidence::<f32>::zero());
        let (mut rows, mut further) = (Box::new([[0.0; WIDTH]; SCRATCH]), Box::new([[0.0; E]; SCRATCH]));
        let units = Units { sigma: &problem.sigma.map(narrowed), field_ut: 50.0 };
        evidence.start(&rules, SOUND, Unturned::NONE, &candidates);
        while evidence.step((&mut rows, &mut further), &globals, &candidates, &units) {}
        problem.weigh_again(&rules);
        assert_eq!(evidence.account.claims.len(), problem.evidence.account.claims.len());
        assert!(!evidence.account.claims.is_empty());
        for (found, expected) in evidence.account.claims.iter().zip(&problem.evidence.account.claims) {
            assert_eq!(found.effect, expected.effect);
            let off = (found.evidence - expected.evidence).abs();
            assert!(off < 0.1 + 1e-3 * expected.evidence, "{scale}: {found:?} {expected:?}");
            for ((a, b), sigma) in found.parameters.iter().zip(&expected.parameters).zip(&expected.sigma) {
                assert!((a - b).abs() <= 0.1 * sigma, "{scale}: {found:?} {expected:?}");
            }
        }
    }
}

/// Without a row of data a restored effect stays, and stays as large as it was.
#[test]
fn a_restored_effect_stays_as_it_is_until_data_speak() {
    for (x, dispersion) in [(0.3, 1.0), (0.02, 1.0), (0.3, 4.0), (2.5, 4.0)] {
        let mut problem = Problem::new(90, &[], as_they_are);
        let mut effects = ActiveEffects::none();
        let mut found = FoundEffect { index: OF_SHEAR as u8, ..Default::default() };
        for (k, parameter) in MADE[OF_SHEAR].parameters().iter().enumerate() {
            (found.parameters[k], found.sigma[k]) = (x * parameter.usual, 0.01 * parameter.usual);
        }
        assert!(effects.add(found));
        problem.known.candidates.restore(&effects);
        for least in [5.0, 10.0] {
            let misfit = Misfit { dispersion, is_unexplained: false };
            problem.weigh_as(&Rules { least, with_nuisances: least > 5.0 }, misfit, Unturned::NONE);
            assert_eq!(problem.claimed(), [OF_SHEAR], "{x} {dispersion}");
            let taken_out = &problem.known.candidates.root.x;
            assert!((0..2).all(|k| (taken_out[k] - f64::from(x)).abs() < 1e-6), "{x} {dispersion}: {taken_out:?}");
        }
        // Data that exclude it, and data that show it.
        for (truth, claimed) in [(0.0, &[][..]), (1.5, &[OF_SHEAR][..])] {
            let mut problem =
                Problem::new(91, &[(GLOBALS + SHEARS, truth), (GLOBALS + SHEARS + 1, truth)], |row, _| {
                    row.effects.iter_mut().for_each(|x| *x *= 8.0);
                });
            problem.known.candidates.restore(&effects);
            problem.weigh(&Rules { least: 5.0, with_nuisances: false });
            assert_eq!(problem.claimed(), claimed, "{x} {dispersion}");
        }
    }
}
