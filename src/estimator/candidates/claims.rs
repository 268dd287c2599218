//! The candidates that compete for the evidence, and the claim that a chosen one makes. `choice.rs` chooses.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    Candidates, MAX_CANDIDATES, MAX_TAKEN, STEPS,
    candidate_id::{CandidateId, CandidateSet},
    column_id::{ColumnId, Columns},
    matrix::{LEAST_FACTOR, at, at_most},
};
use crate::{
    algebra::cholesky::Cholesky,
    compensation::{Effect, Sensor, Snapshot, effect::MAX_PARAMETERS},
    estimator::{
        columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, BIAS, GLOBALS, Group, HARD_IRON, MAG_LAG, MAG_MATRIX},
        globals::Globals,
        real::{M3, Real, V3},
    },
};
use nalgebra::Vector3;

/// Errors of the vector sensors that are always possible, with or without a name in the library.
const NAMELESS: [Group; 6] = [MAG_MATRIX, HARD_IRON, MAG_LAG, ACCEL_LAG, ACCEL_MATRIX, ACCEL_BIAS];
/// Microseconds after which a bias step becomes part of the bias: by then two windows have reported it.
const SETTLED_US: u64 = 120_000_000;

/// An effect that the evidence shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Index of the effect in the library.
    pub effect: u8,
    /// Index of a bias step among the steps; 0 for other effects.
    pub step: u8,
    /// Time of a bias step, microseconds; 0 for other effects.
    pub step_us: u64,
    /// Log Bayes factor beside all other claims.
    pub evidence: f32,
    /// Parameters of the effect, SI (field: microtesla).
    pub parameters: [f32; MAX_PARAMETERS],
    /// Deviations of the parameters.
    pub sigma: [f32; MAX_PARAMETERS],
    /// Root mean square that the effect adds to its sensor's reading.
    pub size: f32,
    /// Root mean square that the parameters' deviations alone would add.
    pub size_sigma: f32,
    /// Rivals: candidates that are as likely.
    pub rivals: CandidateSet,
    /// True if the effect is taken out: enough evidence, a possible size, and no rival on the other vector sensor.
    pub is_taken_out: bool,
}

/// Physical units of the matrix columns.
pub(in crate::estimator) struct Units<'a, T> {
    /// Widths of the globals.
    pub sigma: &'a [T; GLOBALS],
    /// Unit of the field, microtesla.
    pub field_ut: T,
}

impl<T: Real, const E: usize> Candidates<T, E> {
    /// Number of candidates.
    fn count(&self) -> usize {
        let steps = self.library().iter().filter(|effect| effect.is_bias_step()).count() * (STEPS - 1);
        let all = self.library().len() + steps + NAMELESS.len();
        if all < MAX_CANDIDATES { all } else { MAX_CANDIDATES }
    }

    /// Number of candidates that the library has a name for.
    pub fn named_count(&self) -> usize {
        let all = self.count();
        if all > NAMELESS.len() { all - NAMELESS.len() } else { 0 }
    }

    /// Candidates that the library has a name for.
    pub(super) fn named(&self) -> impl Iterator<Item = CandidateId> + use<T, E> {
        (0..self.named_count()).map(CandidateId::new)
    }

    /// Candidates that are errors of a vector sensor without a name.
    pub(super) fn nameless(&self) -> impl Iterator<Item = CandidateId> + use<T, E> {
        (self.named_count()..self.count()).map(CandidateId::new)
    }

    fn is_nameless(&self, candidate: CandidateId) -> bool {
        candidate.number() >= self.named_count()
    }

    /// Effect of the library that a candidate is, or whose step it is; `None` without a name.
    fn effect(&self, candidate: CandidateId) -> Option<&'static dyn Effect> {
        let index = self.effect_of(candidate).0;
        self.library().get(index).filter(|_| !self.is_nameless(candidate)).copied()
    }

    /// Log Bayes factor that an effect has without any data, because it was found in an earlier session; `None` if it
    /// was not.
    pub(super) fn restored(&self, candidate: CandidateId) -> Option<f32> {
        let effect = CandidateId::new(self.effect_of(candidate).0);
        let mut restored = self.restored.iter().filter(|_| !self.is_nameless(candidate));
        restored.find(|(of, _)| *of == effect).map(|(_, evidence)| *evidence)
    }

    /// Returns true if an effect is taken out now.
    pub(super) fn is_taken_out(&self, candidate: CandidateId) -> bool {
        let is_out = |column: ColumnId| column.place().is_some_and(|place| at(&self.root.x, place) != T::ZERO);
        self.columns_of(candidate).iter().any(is_out)
    }

    /// Effects with columns of their own that are taken out now.
    pub fn taken_out(&self) -> CandidateSet {
        let mut all = CandidateSet::EMPTY;
        for (_, place) in self.root.x.iter().zip(self.places()).filter(|(x, _)| **x != T::ZERO) {
            all.insert(CandidateId::new(usize::from(place.effect)));
        }
        all
    }

    /// Index of a candidate's effect in the library, and its step.
    pub(super) fn effect_of(&self, candidate: CandidateId) -> (usize, u8) {
        match candidate.number().checked_sub(self.library().len()) {
            None => (candidate.number(), 0),
            Some(more) => {
                let step = self.library().iter().position(|effect| effect.is_bias_step()).unwrap_or(0);
                (step, more as u8 + 1)
            }
        }
    }

    /// Returns true if a candidate is an error of one vector sensor where an error of the other is as likely.
    /// Compensating the wrong one may turn the attitude by the other's error.
    pub(super) fn is_of_either_vector(&self, candidate: CandidateId, rivals: CandidateSet) -> bool {
        let of = |candidate: CandidateId| {
            let effect = self.effect(candidate).filter(|effect| effect.vector_error().is_some());
            effect.map(|effect| effect.sensor())
        };
        let is_other =
            |rival: CandidateId| rivals.has(rival) && of(rival).is_some_and(|sensor| Some(sensor) != of(candidate));
        of(candidate).is_some() && self.named().any(is_other)
    }

    /// Columns of a candidate.
    pub fn columns_of(&self, candidate: CandidateId) -> Columns {
        if let Some(group) = candidate.number().checked_sub(self.named_count()) {
            let columns = NAMELESS.get(group).map_or(Columns::NONE, Columns::of_group);
            let mut named = self.library().iter().filter_map(|effect| effect.vector_error());
            return if named.any(|error| Columns::of_error(error) == columns) { Columns::NONE } else { columns };
        }
        let (effect, step) = self.effect_of(candidate);
        let Some(own) = self.library().get(effect) else { return Columns::NONE };
        if let Some(error) = own.vector_error() {
            return Columns::of_error(error);
        }
        let Some(from) = self.places.first_column(effect, step) else { return Columns::NONE };
        // A bias step for which there was no shock has no columns.
        let is_idle = own.is_bias_step() && self.shocks.at_us(step).is_none();
        Columns::of_effect(from, if is_idle { 0 } else { own.parameters().len() })
    }

    /// Log of the number of chances that a candidate has had: a bias step has one at each shock.
    pub(super) fn chances(&self, candidate: CandidateId) -> f32 {
        let is_chance = self.is_step_of(candidate) && self.shocks.seen > 1;
        if is_chance { libm::logf(self.shocks.seen as f32) } else { 0.0 }
    }

    /// Returns true if a candidate is a step of the bias.
    pub(super) fn is_step_of(&self, candidate: CandidateId) -> bool {
        self.effect(candidate).is_some_and(|effect| effect.is_bias_step())
    }

    /// Candidate of a step of the bias.
    fn candidate_of_step(&self, step: u8) -> Option<CandidateId> {
        let first = self.library().iter().position(|effect| effect.is_bias_step())?;
        Some(CandidateId::new(if step == 0 { first } else { self.library().len() + usize::from(step) - 1 }))
    }

    /// Notes how clearly each bias step shows: its log Bayes factor, infinite if it is claimed.
    pub fn note_steps(&mut self, claims: &[Claim], tried: &[f32; MAX_CANDIDATES]) {
        for step in 0..STEPS as u8 {
            let at_us = self.shocks.at_us(step);
            let is_claimed = at_us.is_some_and(|us| claims.iter().any(|claim| claim.step_us == us));
            let tried = self.candidate_of_step(step).and_then(|candidate| tried.get(candidate.number()));
            self.shocks.show(step, if is_claimed { f32::INFINITY } else { tried.copied().unwrap_or(0.0) });
        }
    }

    /// Returns the bias step that has been taken out for so long that it becomes part of the bias.
    pub fn old_step(&self, claims: &[Claim], now_us: u64) -> Option<Claim> {
        let is_old = |claim: &&Claim| {
            claim.is_taken_out && claim.step_us > 0 && claim.step_us.saturating_add(SETTLED_US) < now_us
        };
        claims.iter().find(is_old).copied()
    }

    /// Sign that the only parameter of an effect must have; `None` if either is possible or there are several
    /// parameters.
    pub(super) fn sign(&self, candidate: CandidateId) -> Option<T> {
        let [parameter] = self.effect(candidate)?.parameters() else { return None };
        (!parameter.signed).then_some(T::ONE)
    }

    /// Returns true if all parameters of the claim are possible for its effect.
    pub fn is_believed(&self, claim: &Claim) -> bool {
        let Some(effect) = self.library().get(usize::from(claim.effect)) else { return false };
        effect.parameters().iter().zip(&claim.parameters).all(|(parameter, x)| parameter.believes(*x))
    }

    /// Builds a claim, in physical units, from mean and covariance of its columns.
    pub(super) fn claim(
        &self,
        candidate: CandidateId,
        x: &[T; MAX_PARAMETERS],
        covariance: &[[T; MAX_PARAMETERS]; MAX_PARAMETERS],
        units: &Units<T>,
    ) -> Claim {
        let (effect, step) = self.effect_of(candidate);
        let mut one = Claim {
            effect: effect as u8,
            step,
            step_us: 0,
            evidence: 0.0,
            parameters: [0.0; MAX_PARAMETERS],
            sigma: [0.0; MAX_PARAMETERS],
            size: 0.0,
            size_sigma: 0.0,
            rivals: CandidateSet::EMPTY,
            is_taken_out: false,
        };
        let Some(own) = self.library().get(effect) else { return one };
        if own.is_bias_step() {
            one.step_us = self.shocks.at_us(step).unwrap_or(0);
        }
        let columns = self.columns_of(candidate);
        let n = at_most(columns.len(), MAX_PARAMETERS);
        // Rows: parameters; columns: unknowns.
        let mut by = [[0.0_f32; MAX_PARAMETERS]; MAX_PARAMETERS];
        if own.vector_error().is_some() {
            for (k, column) in columns.iter().enumerate().take(n) {
                let mut unit = [0.0; MAX_PARAMETERS];
                if let Some(unit) = unit.get_mut(k) {
                    *unit = at(units.sigma, column.index()).narrow();
                }
                for (row, value) in by.iter_mut().zip(own.parameters_of(&unit, units.field_ut.narrow())) {
                    if let Some(slot) = row.get_mut(k) {
                        *slot = value;
                    }
                }
            }
        } else {
            for ((k, row), column) in by.iter_mut().enumerate().zip(columns.iter()) {
                let place = column.place().and_then(|place| self.places().get(place));
                if let Some(slot) = row.get_mut(k) {
                    *slot = place.map_or(0.0, |place| place.usual);
                }
            }
        }
        let (mut square, mut square_sigma) = (0.0, 0.0);
        for (k, row) in by.iter().enumerate().take(own.parameters().len()) {
            let value = row.iter().zip(x).fold(0.0, |sum, (a, x)| sum + a * x.narrow());
            let mut variance = 0.0;
            for i in 0..n {
                for j in 0..n {
                    variance += row[i] * row[j] * covariance[i][j].narrow();
                }
            }
            let shown = if own.is_bias_step() { 1.0 } else { self.shown(effect, k).narrow() };
            one.parameters[k] = value;
            one.sigma[k] = libm::sqrtf(if variance > 0.0 { variance } else { 0.0 });
            square += value * value * shown * shown;
            square_sigma += variance * shown * shown;
        }
        one.size = libm::sqrtf(square);
        one.size_sigma = libm::sqrtf(if square_sigma > 0.0 { square_sigma } else { 0.0 });
        one
    }

    /// The current bias less that of the beginning: the steps that are taken out, compensated frame, rad/s.
    pub fn stepped(&self) -> V3<T> {
        let mut sum = V3::new(T::ZERO, T::ZERO, T::ZERO);
        for (x, place) in self.root.x.iter().zip(self.places()) {
            let is_step = self.library().get(usize::from(place.effect)).is_some_and(|effect| effect.is_bias_step());
            if let Some(sum) = sum.get_mut(usize::from(place.parameter)).filter(|_| is_step) {
                *sum += *x * T::of(place.usual);
            }
        }
        sum
    }

    /// Part of a resting probe's rate that the effects which are taken out explain, rad/s. Steps of the bias have none:
    /// they are in the bias.
    pub fn at_rest(&self, still: &Snapshot) -> Vector3<f32> {
        self.root.x.iter().zip(self.places()).fold(Vector3::zeros(), |sum, (x, place)| {
            let effect = self.library().get(usize::from(place.effect));
            match effect.filter(|effect| place.sensor == Sensor::Gyro && !effect.is_bias_step()) {
                Some(effect) => sum + effect.term(usize::from(place.parameter), still) * (x.narrow() * place.usual),
                None => sum,
            }
        })
    }

    /// Vector of the taken out column `of`: the outer products of these vectors add up to the covariance that the
    /// uncertainty of the effects that are taken out adds to the globals'. The bias that flies has its steps in it, and
    /// so has its uncertainty: `inverse` is that of P, by which a step is turned back, and `sigma` the globals' widths.
    // Not inlined: its Cholesky factor would enlarge the stack frame of all other work.
    #[inline(never)]
    pub fn inflation(
        &self,
        of: usize,
        (taken, covariance): (&[ColumnId], &[T]),
        globals: &Globals<T>,
        (inverse, sigma): (&M3<T>, &[T; GLOBALS]),
    ) -> [T; GLOBALS] {
        let mut by = [T::ZERO; GLOBALS];
        let n = at_most(taken.len(), MAX_TAKEN);
        let of_both = |i: usize, j: usize| at(covariance, i * (i + 1) / 2 + j);
        let mut factor = Cholesky::<T, MAX_TAKEN>::unset();
        factor.fill_or_least(n, of_both, T::of(LEAST_FACTOR));
        let mut right = [T::ZERO; GLOBALS];
        for (right, row) in right.iter_mut().zip(&self.root.globals) {
            for (i, column) in taken.iter().enumerate() {
                *right -= at(row, column.place().unwrap_or(0)) * factor.at(i, of);
            }
        }
        for j in (0..GLOBALS).rev() {
            let sum = (j + 1..GLOBALS).fold(right[j], |sum, c| sum - globals.root[j][c] * by[c]);
            by[j] = sum / globals.root[j][j];
        }
        let mut step = V3::new(T::ZERO, T::ZERO, T::ZERO);
        for (i, column) in taken.iter().enumerate() {
            let place = column.place().filter(|place| self.places.is_step(*place));
            let Some(place) = place.and_then(|place| self.places().get(place)) else { continue };
            if let Some(axis) = step.get_mut(usize::from(place.parameter)) {
                *axis += T::of(place.usual) * factor.at(i, of);
            }
        }
        for (b, raw) in BIAS.columns().zip((inverse * step).iter()) {
            if sigma[b] > T::ZERO {
                by[b] += *raw / sigma[b];
            }
        }
        by
    }
}
