//! The evidence of candidates is that of the whole least-squares problem, and the right ones are chosen.

#![allow(clippy::single_range_in_vec_init)] // A list of one range of columns.

extern crate std;

use super::{
    super::{CandidateSet, Rules, Units, column_id::ColumnId, evidence::Evidence},
    BENDS, COLUMNS, Candidates, E, GLOBALS, Globals, Known, LAGS, MADE, OF_BEND, OF_IRON, OF_LAG, OF_SHEAR, OF_STEP,
    OF_TWIST, Row, SCRATCH, SHEARS, STEPS_FROM, TWISTS, WIDTH, deviate, shake,
};
use crate::estimator::{
    columns::{BIAS, HARD_IRON, NUISANCES},
    node::Node,
};
use core::ops::Range;
use nalgebra::{SMatrix, SVector};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{boxed::Box, vec::Vec};

/// Readings of a problem.
const ROWS: usize = 96;
const BOTH: usize = GLOBALS + E;
/// No effect can be worth so much.
const NEVER: f32 = 1e30;

/// Rows of a linear model, and what the filter makes of them.
struct Problem {
    rows: Vec<Row>,
    known: Box<Known>,
    evidence: Box<Evidence<f64>>,
    sigma: [f64; GLOBALS],
}

impl Problem {
    /// Random rows, their coefficients changed by `shape`. The gyro is random; `truth` gives the other unknowns.
    fn new(seed: u64, truth: &[(usize, f64)], shape: impl Fn(&mut Row, &mut Xoshiro128PlusPlus)) -> Self {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut x: [f64; BOTH] = core::array::from_fn(|c| if is_of_gyro(c) { deviate(&mut generator) } else { 0.0 });
        truth.iter().for_each(|(column, value)| x[*column] = *value);
        let mut rows: Vec<Row> = (0..ROWS).map(|_| Row::random(&mut generator)).collect();
        for row in &mut rows {
            row.effects.iter_mut().for_each(|x| *x *= 0.5);
            shape(row, &mut generator);
            row.constant = deviate(&mut generator) - (0..BOTH).map(|c| row.coefficient(c) * x[c]).sum::<f64>();
        }
        let mut known = Box::new(Known::new());
        known.candidates.increments = 4;
        known.candidates.squares = core::array::from_fn(|k| 4.0 * (1 + k) as f64 * (1 + k) as f64);
        let sigma = core::array::from_fn(|c| 0.1 + 0.01 * c as f64);
        Self { rows, known, evidence: Box::new(Evidence::zero()), sigma }
    }

    /// As the filter weighs, every half minute or so.
    fn weigh(&mut self, rules: &Rules) {
        self.known.learn(&self.rows);
        self.weigh_again(rules);
    }

    fn weigh_again(&mut self, rules: &Rules) {
        let known = &mut *self.known;
        let Known { globals, candidates, rows, further } = known;
        let units = Units { sigma: &self.sigma, field_ut: 50.0 };
        self.evidence.start(rules, 1.0, false);
        while self.evidence.step((rows, further), globals, candidates, &units) {}
        let mut x = [0.0; E];
        for (column, mean) in self.evidence.account.taken.iter().zip(&self.evidence.account.mean) {
            x[column.place().unwrap()] = *mean;
        }
        candidates.take_out(&x, globals, &mut Node::zero());
    }

    /// Log marginal likelihood of the readings: gyro and these columns are N(0, 1), all others are zero.
    fn likelihood(&self, unknown: &[Range<usize>]) -> f64 {
        let design = self.design(unknown);
        let covariance = SMatrix::<f64, ROWS, ROWS>::identity() + design * design.transpose();
        let factor = Box::new(covariance.cholesky().unwrap());
        let y = SVector::<f64, ROWS>::from_fn(|i, _| self.rows[i].constant);
        let log_determinant = (0..ROWS).map(|i| 2.0 * libm::log(factor.l_dirty()[(i, i)])).sum::<f64>();
        -0.5 * (y.dot(&factor.solve(&y)) + log_determinant)
    }

    /// Mean and covariance of all unknowns after the readings, in units of the priors.
    fn posterior(&self, unknown: &[Range<usize>]) -> (SVector<f64, BOTH>, SMatrix<f64, BOTH, BOTH>) {
        let design = self.design(unknown);
        let y = SVector::<f64, ROWS>::from_fn(|i, _| -self.rows[i].constant);
        let covariance = (SMatrix::identity() + design.transpose() * design).try_inverse().unwrap();
        (covariance * design.transpose() * y, covariance)
    }

    fn design(&self, unknown: &[Range<usize>]) -> SMatrix<f64, ROWS, BOTH> {
        // The made library has a name for one error of the vector sensors, the hard iron: the others are always in.
        let is_nameless = |c: usize| c < NUISANCES && !HARD_IRON.columns().contains(&c);
        let is_in = |c: usize| is_of_gyro(c) || is_nameless(c) || unknown.iter().any(|columns| columns.contains(&c));
        SMatrix::from_fn(|i, c| if is_in(c) { self.rows[i].coefficient(c) } else { 0.0 })
    }

    /// Mean and covariance of the unknowns, weighed over priors of these columns that are 1, 1/2, ... 1/128 as wide.
    fn averaged(&self, unknown: &[Range<usize>], of: &Range<usize>) -> (SVector<f64, BOTH>, SMatrix<f64, BOTH, BOTH>) {
        let widths: [f64; 8] = core::array::from_fn(|k| libm::exp2(-(k as f64)));
        let y = SVector::<f64, ROWS>::from_fn(|i, _| self.rows[i].constant);
        let each = widths.map(|width| {
            let unit = |c: usize| if of.contains(&c) { width } else { 1.0 };
            let design = self.design(unknown);
            let design = SMatrix::<f64, ROWS, BOTH>::from_fn(|i, c| design[(i, c)] * unit(c));
            let factor =
                Box::new((SMatrix::<f64, ROWS, ROWS>::identity() + design * design.transpose()).cholesky().unwrap());
            let log_determinant = (0..ROWS).map(|i| 2.0 * libm::log(factor.l_dirty()[(i, i)])).sum::<f64>();
            let evidence = -0.5 * (y.dot(&factor.solve(&y)) + log_determinant);
            let covariance =
                (SMatrix::<f64, BOTH, BOTH>::identity() + design.transpose() * design).try_inverse().unwrap();
            let mean = covariance * design.transpose() * -y;
            let mean = SVector::<f64, BOTH>::from_fn(|c, _| mean[c] * unit(c));
            let covariance = SMatrix::<f64, BOTH, BOTH>::from_fn(|a, b| covariance[(a, b)] * unit(a) * unit(b));
            (evidence, mean, covariance)
        });
        let most = each.iter().map(|(evidence, ..)| *evidence).fold(f64::MIN, f64::max);
        let total: f64 = each.iter().map(|(evidence, ..)| libm::exp(evidence - most)).sum();
        let (mut mean, mut square) = (SVector::zeros(), SMatrix::zeros());
        for (evidence, of_width, covariance) in &each {
            let weight = libm::exp(evidence - most) / total;
            mean += of_width * weight;
            square += (covariance + of_width * of_width.transpose()) * weight;
        }
        (mean, square - mean * mean.transpose())
    }

    fn claimed(&self) -> Vec<usize> {
        let mut claimed: Vec<_> = self.evidence.account.claims.iter().map(|claim| usize::from(claim.effect)).collect();
        claimed.sort_unstable();
        claimed
    }
}

fn is_of_gyro(column: usize) -> bool {
    (BIAS.from..GLOBALS).contains(&column)
}

/// Columns of the effects, the nuisance's among the globals. A step is the first of them.
fn columns_of(effect: usize) -> Range<usize> {
    let effects = |from: usize, count: usize| GLOBALS + from..GLOBALS + from + count;
    match effect {
        OF_SHEAR => effects(SHEARS, 2),
        OF_LAG => effects(LAGS, 1),
        OF_STEP => effects(STEPS_FROM, 3),
        OF_IRON => HARD_IRON.columns(),
        OF_BEND => effects(BENDS, 2),
        _ => effects(TWISTS, 1),
    }
}

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
        assert!(problem.evidence.account.claims.is_empty() && problem.known.candidates.x == [0.0; E]);
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
        let (found, evidence) = (problem.known.candidates.x, &problem.evidence);
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
            candidates.give_columns(*index, MADE[*index], *step).unwrap();
        });
        let narrowed = |x: f64| x as f32;
        globals.x = known.globals.x.map(narrowed);
        globals.root = known.globals.root.map(|row| row.map(narrowed));
        candidates.globals = known.candidates.globals.map(|row| row.map(narrowed));
        candidates.root = known.candidates.root.map(|row| row.map(narrowed));
        candidates.constants = known.candidates.constants.map(narrowed);
        (candidates.increments, candidates.squares) = (4, known.candidates.squares.map(narrowed));
        let mut evidence = Box::new(Evidence::<f32>::zero());
        let (mut rows, mut further) = (Box::new([[0.0; WIDTH]; SCRATCH]), Box::new([[0.0; E]; SCRATCH]));
        let units = Units { sigma: &problem.sigma.map(narrowed), field_ut: 50.0 };
        evidence.start(&rules, 1.0, false);
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
