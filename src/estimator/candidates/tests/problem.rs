//! A linear problem with known truth, as the filter knows it and as dense matrices.

extern crate std;

use super::{
    super::{Misfit, Rules, Units, Unturned, evidence::Evidence},
    BENDS, E, GLOBALS, Known, LAGS, OF_BEND, OF_IRON, OF_LAG, OF_SHEAR, OF_STEP, Row, SHEARS, STEPS_FROM, TWISTS,
    deviate,
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

/// Innovations are as they should be.
pub(super) const SOUND: Misfit = Misfit { dispersion: 1.0, is_unexplained: false };

/// Rows of a linear model, and what the filter makes of them.
pub(super) struct Problem {
    pub(super) rows: Vec<Row>,
    pub(super) known: Box<Known>,
    pub(super) evidence: Box<Evidence<f64>>,
    pub(super) sigma: [f64; GLOBALS],
}

impl Problem {
    /// Random rows, their coefficients changed by `shape`. The gyro is random; `truth` gives the other unknowns.
    pub(super) fn new(seed: u64, truth: &[(usize, f64)], shape: impl Fn(&mut Row, &mut Xoshiro128PlusPlus)) -> Self {
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
        known.candidates.terms.increments = 4;
        known.candidates.terms.squares = core::array::from_fn(|k| (1 + k) as f64 * (1 + k) as f64);
        let sigma = core::array::from_fn(|c| 0.1 + 0.01 * c as f64);
        Self { rows, known, evidence: Box::new(Evidence::zero()), sigma }
    }

    /// As the filter weighs, every half minute or so.
    pub(super) fn weigh(&mut self, rules: &Rules) {
        self.known.learn(&self.rows);
        self.weigh_again(rules);
    }

    pub(super) fn weigh_again(&mut self, rules: &Rules) {
        self.weigh_unturned(rules, Unturned::NONE);
    }

    pub(super) fn weigh_unturned(&mut self, rules: &Rules, unturned: Unturned<f64>) {
        self.weigh_as(rules, SOUND, unturned);
    }

    pub(super) fn weigh_as(&mut self, rules: &Rules, misfit: Misfit, unturned: Unturned<f64>) {
        let known = &mut *self.known;
        let Known { globals, candidates, rows, further } = known;
        let units = Units { sigma: &self.sigma, field_ut: 50.0 };
        self.evidence.start(rules, misfit, unturned, candidates);
        while self.evidence.step((rows, further), globals, candidates, &units) {}
        let mut x = [0.0; E];
        for (column, mean) in self.evidence.account.taken.iter().zip(&self.evidence.account.mean) {
            x[column.place().unwrap()] = *mean;
        }
        candidates.take_out(&x, globals, &mut Node::zero());
    }

    /// Log marginal likelihood of the readings: gyro and these columns are N(0, 1), all others are zero.
    pub(super) fn likelihood(&self, unknown: &[Range<usize>]) -> f64 {
        let design = self.design(unknown);
        let covariance = SMatrix::<f64, ROWS, ROWS>::identity() + design * design.transpose();
        let factor = Box::new(covariance.cholesky().unwrap());
        let y = SVector::<f64, ROWS>::from_fn(|i, _| self.rows[i].constant);
        let log_determinant = (0..ROWS).map(|i| 2.0 * libm::log(factor.l_dirty()[(i, i)])).sum::<f64>();
        -0.5 * (y.dot(&factor.solve(&y)) + log_determinant)
    }

    /// Mean and covariance of all unknowns after the readings, in units of the priors.
    pub(super) fn posterior(&self, unknown: &[Range<usize>]) -> (SVector<f64, BOTH>, SMatrix<f64, BOTH, BOTH>) {
        let design = self.design(unknown);
        let y = SVector::<f64, ROWS>::from_fn(|i, _| -self.rows[i].constant);
        let covariance = (SMatrix::identity() + design.transpose() * design).try_inverse().unwrap();
        (covariance * design.transpose() * y, covariance)
    }

    /// Variance of a column with the gyro and these columns, all others zero.
    pub(super) fn variance_beside_gyro(&self, column: usize, others: &[usize]) -> f64 {
        let is_in = |c: usize| is_of_gyro(c) || c == column || others.contains(&c);
        let design =
            SMatrix::<f64, ROWS, BOTH>::from_fn(|i, c| if is_in(c) { self.rows[i].coefficient(c) } else { 0.0 });
        (SMatrix::<f64, BOTH, BOTH>::identity() + design.transpose() * design).try_inverse().unwrap()[(column, column)]
    }

    fn design(&self, unknown: &[Range<usize>]) -> SMatrix<f64, ROWS, BOTH> {
        // The made library has a name for one error of the vector sensors, the hard iron: the others are always in.
        let is_nameless = |c: usize| c < NUISANCES && !HARD_IRON.columns().contains(&c);
        let is_in = |c: usize| is_of_gyro(c) || is_nameless(c) || unknown.iter().any(|columns| columns.contains(&c));
        SMatrix::from_fn(|i, c| if is_in(c) { self.rows[i].coefficient(c) } else { 0.0 })
    }

    /// Mean and covariance of the unknowns, weighed over priors of these columns that are 1, 1/2, ... 1/128 as wide.
    pub(super) fn averaged(
        &self,
        unknown: &[Range<usize>],
        of: &Range<usize>,
    ) -> (SVector<f64, BOTH>, SMatrix<f64, BOTH, BOTH>) {
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

    pub(super) fn claimed(&self) -> Vec<usize> {
        let mut claimed: Vec<_> = self.evidence.account.claims.iter().map(|claim| usize::from(claim.effect)).collect();
        claimed.sort_unstable();
        claimed
    }
}

fn is_of_gyro(column: usize) -> bool {
    (BIAS.from..GLOBALS).contains(&column)
}

/// Columns of the effects, the nuisance's among the globals. A step is the first of them.
pub(super) fn columns_of(effect: usize) -> Range<usize> {
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
