//! Physical effects that the model may lack, as further columns of the estimator's square root of information, behind
//! all others. The columns before them are the filter as it flies, with every effect at the value that is taken out;
//! the rows of the effects hold all that the data say of them.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

mod account;
mod candidate_id;
mod choice;
mod claims;
mod column_id;
mod entered;
pub(super) mod evidence;
mod matrix;
mod places;
mod root;
mod rules;
mod shocks;
mod size;
mod steadiness;
mod sums;
mod terms;
mod unturned;

use super::{
    columns::{BIAS, GLOBALS},
    globals::Globals,
    increment::Increment,
    node::Node,
    parameters::Parameters,
    preintegration::{Preintegration, Turned},
    real::{M3, Real, V3},
    rows::{SCRATCH, WIDTH},
    taken_out::TakenOut,
};
use crate::compensation::{ActiveEffects, Effect, MAX_ACTIVE, Snapshot};
pub use candidate_id::{CandidateId, CandidateSet};
pub(super) use choice::Misfit;
pub use claims::Claim;
pub(super) use claims::Units;
use heapless::Vec;
use places::{Place, Places};
use root::Root;
pub use rules::Rules;
use shocks::Shocks;
use sums::Sums;
use terms::Terms;
pub(super) use unturned::Unturned;

/// Capacity in columns: the library's effects, with three bias steps.
pub const EFFECTS: usize = 44;

/// Most effects that are claimed at a time.
pub const MAX_CLAIMED: usize = MAX_ACTIVE;
/// Most candidates, each step of the bias for itself.
pub const MAX_CANDIDATES: usize = 32;
/// Most columns of effects that are taken out.
pub(super) const MAX_TAKEN: usize = 24;

/// Most parameters of a library.
const PARAMETERS: usize = 72;

/// Number of steps of the gyro's bias that the filter looks for at a time, each after a shock of its own.
pub const STEPS: usize = 3;

/// Columns of all effects that are not among the nuisances.
pub(super) struct Candidates<T, const EFFECTS: usize> {
    places: Places<EFFECTS>,
    /// Effects that were found in an earlier session, and the log Bayes factor that each has without any data.
    restored: Vec<(CandidateId, f32), MAX_ACTIVE>,
    shocks: Shocks,
    terms: Terms<T, EFFECTS>,
    sums: Sums<T, EFFECTS>,
    root: Root<T, EFFECTS>,
}

impl<T: Real, const EFFECTS: usize> Candidates<T, EFFECTS> {
    pub const fn zero() -> Self {
        Self {
            places: Places::zero(),
            restored: Vec::new(),
            shocks: Shocks::zero(),
            terms: Terms::zero(),
            sums: Sums::zero(),
            root: Root::zero(),
        }
    }

    /// Sets the effects that are looked for.
    pub fn configure(&mut self, library: &'static [&'static dyn Effect]) {
        self.places.configure(library);
        self.begin();
    }

    /// Forgets all that was learnt of the effects, and takes nothing out.
    pub fn begin(&mut self) {
        self.places.begin();
        self.restored.clear();
        self.shocks.start();
        self.terms.begin();
        self.sums.start_node();
        self.root.begin();
    }

    /// Takes out what was found in an earlier session. It may have changed since: half of the usual size is added to
    /// its deviation.
    pub fn restore(&mut self, effects: &ActiveEffects) {
        for found in effects.iter() {
            let index = usize::from(found.index);
            // There is room for all effects of the set.
            let _ = self.restored.push((CandidateId::new(index), 0.0));
            // A nuisance is restored with the filter's own state.
            let Some(effect) = self.library().get(index).filter(|effect| effect.vector_error().is_none()) else {
                continue;
            };
            let mut evidence = 0.0;
            if self.places.first_column(index, 0).is_none() {
                self.places.give_columns(index, *effect, 0);
            }
            for column in 0..self.places.used() {
                let Some(place) = self.places.in_use().get(column) else { break };
                let k = usize::from(place.parameter);
                if place.effect != found.index || place.usual <= 0.0 {
                    continue;
                }
                let (Some(value), Some(sigma)) = (found.parameters.get(k), found.sigma.get(k)) else { continue };
                let half = 0.5 * place.usual;
                let x = value / place.usual;
                let inverse = place.usual / libm::sqrtf(sigma * sigma + half * half);
                self.root.x[column] = T::of(x);
                self.root.own[column][column] = T::of(inverse);
                evidence += 0.5 * inverse * inverse * x * x - libm::logf(inverse);
            }
            if let Some((_, of_prior)) = self.restored.last_mut() {
                *of_prior = evidence;
            }
        }
    }

    /// Begins a node.
    pub fn start_node(&mut self) {
        self.sums.start_node();
    }

    /// Works out the terms of an increment, see [`Terms::update`], and looks for a bias step where a shock begins.
    pub fn look_at(
        &mut self,
        increment: &Increment<T>,
        rate_change: &V3<T>,
        field_ut: T,
        with: &Parameters<T>,
    ) -> (TakenOut<T>, Snapshot) {
        if self.shocks.look_at(increment.end_us, increment.peak.narrow()) {
            self.begin_step(increment.end_us, increment.peak.narrow());
        }
        let Self { places, shocks, terms, root, .. } = self;
        terms.update((increment, rate_change, field_ut), with, &root.x, places, shocks)
    }

    /// Adds the increment of the last `look_at`, turned to the node's beginning, to the sums of the node.
    pub fn add(&mut self, turned: &Turned<T>) {
        self.sums.add(turned, &self.terms.all, self.places.in_use());
    }

    /// Fills in the effects' part of a node's rows, see [`Sums::fill`].
    pub fn fill(
        &self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        rows: &[[T; WIDTH]; SCRATCH],
        attitude: &M3<T>,
        pre: &Preintegration<T>,
        at_rest: Option<&M3<T>>,
    ) {
        self.sums.fill((&self.root.node, self.places.used()), further, rows, attitude, pre, at_rest);
    }

    /// Eliminates two columns of the node's states from the rows of an update.
    pub fn eliminate(&self, further: &mut [[T; EFFECTS]; SCRATCH], rows: &mut [[T; WIDTH]; SCRATCH], column: usize) {
        root::eliminate(self.places.used(), further, rows, column);
    }

    /// Absorbs two columns of the rows that a node left over, see [`Root::absorb`].
    pub fn absorb(
        &mut self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        globals: &mut Globals<T>,
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> usize {
        self.root.absorb(self.places.used(), further, globals, left, column)
    }

    /// Absorbs two columns of the effects' own, see [`Root::absorb_own`].
    pub fn absorb_own(
        &mut self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> bool {
        self.root.absorb_own(self.places.used(), further, left, column)
    }

    /// Begins the next node from the rows of the one that is done.
    pub fn finish(&mut self, further: &[[T; EFFECTS]; SCRATCH]) {
        self.root.finish(further);
        self.sums.start_node();
    }

    /// Begins the node's attitude, velocity and position anew, see [`Root::forget_node`].
    pub fn forget_node(&mut self, kept: T) {
        self.root.forget_node(kept);
    }

    /// Adds process noise to one global, see [`Root::add_process_noise`].
    pub fn add_process_noise(&mut self, globals: &mut Globals<T>, global: usize, variance: T) {
        self.root.add_process_noise(self.places.used(), globals, global, variance);
    }

    /// Makes one column of the globals' root triangular again.
    pub fn triangular(&mut self, globals: &mut Globals<T>, column: usize) {
        self.root.triangular(self.places.used(), globals, column);
    }

    /// Changes the sizes that are taken out, see [`Root::take_out`].
    pub fn take_out(&mut self, x: &[T; EFFECTS], globals: &mut Globals<T>, node: &mut Node<T>) {
        self.root.take_out(x, globals, node);
    }

    /// Value of each column that is taken out, in units of its prior's deviation.
    pub const fn x(&self) -> &[T; EFFECTS] {
        &self.root.x
    }

    /// Makes a bias step part of the bias: its place is free for another step, and its uncertainty is added to that of
    /// the bias. The caller has to move the bias by the step.
    pub fn settle(&mut self, claim: &Claim, globals: &mut Globals<T>, sigma: &[T; GLOBALS]) {
        for (column, deviation) in BIAS.columns().zip(claim.sigma) {
            let Some(sigma) = sigma.get(column).filter(|sigma| **sigma > T::ZERO) else { continue };
            let share = T::of(deviation) / *sigma;
            self.root.add_process_noise(self.places.used(), globals, column, share * share);
        }
        self.drop_step(claim.step);
    }

    /// Looks for a bias step from a shock on, see [`Shocks::begin_step`].
    pub fn begin_step(&mut self, at_us: u64, hard_m_s2: f32) {
        if let Some(step) = self.shocks.begin_step(at_us, hard_m_s2) {
            self.empty_step(step);
        }
    }

    /// Stops looking for a bias step, and frees its place for another.
    pub fn drop_step(&mut self, step: u8) {
        self.empty_step(step);
        self.shocks.drop_step(step);
    }

    fn empty_step(&mut self, step: u8) {
        for column in 0..self.places.used() {
            if self.places.is_step(column) && self.places.step(column) == step {
                self.root.forget(column);
                self.sums.forget(column);
            }
        }
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.places.library()
    }

    /// Returns the meaning of the columns in use.
    fn places(&self) -> &[Place] {
        self.places.in_use()
    }

    /// Root mean square of what one unit of an effect's parameter adds to its sensor's reading.
    pub fn shown(&self, effect: usize, parameter: usize) -> T {
        self.terms.shown(self.places.first_parameter_of(effect) + parameter)
    }
}

#[cfg(test)]
mod tests;
