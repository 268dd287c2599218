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
mod root;
mod rows;
mod rules;
mod shocks;
mod size;
mod steadiness;
mod terms;
mod unturned;

use super::{
    columns::{GLOBALS, NODE},
    real::{Real, V3, zero3},
};
use crate::compensation::{ActiveEffects, Effect, MAX_ACTIVE, Sensor};
pub use candidate_id::{CandidateId, CandidateSet};
pub use claims::Claim;
pub(super) use claims::Units;
pub use rules::Rules;
use shocks::Shocks;
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

/// Meaning of a column.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Index of the effect in the library.
    pub effect: u8,
    /// Index of the effect's parameter.
    pub parameter: u8,
    /// Index of the bias step among several; 0 for other effects.
    pub step: u8,
    sensor: Sensor,
    /// Deviation of its prior: the unit of the column.
    pub usual: f32,
}

/// Source of an effect's columns.
#[derive(Clone, Copy)]
enum Kind {
    /// The effect has columns of its own, from the first increment with a term that is not zero.
    Own,
    /// The effect's unknowns are nuisances.
    Nuisance,
    /// The effect is a bias step, with columns for each of several shocks.
    BiasStep,
}

impl Kind {
    fn of(effect: &dyn Effect) -> Self {
        if effect.vector_error().is_some() {
            Self::Nuisance
        } else if effect.is_bias_step() {
            Self::BiasStep
        } else {
            Self::Own
        }
    }
}

/// Columns of all effects that are not among the nuisances.
pub(super) struct Candidates<T, const EFFECTS: usize> {
    library: Option<&'static [&'static dyn Effect]>,
    /// Kind of each effect of the library: asked for at every increment.
    kinds: [Kind; MAX_CANDIDATES],
    places: [Place; EFFECTS],
    columns: usize,
    /// One past the first column of each effect, for a bias step that of the first step; 0: the effect has no columns.
    firsts: [u8; MAX_CANDIDATES],
    /// Effects that were found in an earlier session.
    restored: CandidateSet,
    /// Value of each column that is taken out, in units of its prior's deviation.
    pub x: [T; EFFECTS],
    shocks: Shocks,
    /// Term of each column in the latest increment: what its effect adds to its sensor's reading at the prior's
    /// deviation.
    terms: [V3<T>; EFFECTS],
    /// Sums of the squares of what one unit of each of the library's parameters adds to a reading, and the number of
    /// increments.
    squares: [T; PARAMETERS],
    increments: u32,
    // From node to node: rotation, sum of the fields, velocity and position.
    rotation: [V3<T>; EFFECTS],
    field: [V3<T>; EFFECTS],
    velocity: [V3<T>; EFFECTS],
    position: [V3<T>; EFFECTS],
    /// Effects' columns of the node's rows and of the globals' rows; then the effects' own root, with their priors.
    node: [[T; EFFECTS]; NODE],
    globals: [[T; EFFECTS]; GLOBALS],
    root: [[T; EFFECTS]; EFFECTS],
    constants: [T; EFFECTS],
}

impl<T: Real, const EFFECTS: usize> Candidates<T, EFFECTS> {
    pub const fn zero() -> Self {
        const NOWHERE: Place = Place { effect: 0, parameter: 0, step: 0, sensor: Sensor::Gyro, usual: 0.0 };
        Self {
            library: None,
            kinds: [Kind::Own; MAX_CANDIDATES],
            places: [NOWHERE; EFFECTS],
            columns: 0,
            firsts: [0; MAX_CANDIDATES],
            restored: CandidateSet::EMPTY,
            x: [T::ZERO; EFFECTS],
            shocks: Shocks::zero(),
            terms: [zero3(); EFFECTS],
            squares: [T::ZERO; PARAMETERS],
            increments: 0,
            rotation: [zero3(); EFFECTS],
            field: [zero3(); EFFECTS],
            velocity: [zero3(); EFFECTS],
            position: [zero3(); EFFECTS],
            node: [[T::ZERO; EFFECTS]; NODE],
            globals: [[T::ZERO; EFFECTS]; GLOBALS],
            root: [[T::ZERO; EFFECTS]; EFFECTS],
            constants: [T::ZERO; EFFECTS],
        }
    }

    /// Sets the effects that are looked for.
    pub fn configure(&mut self, library: &'static [&'static dyn Effect]) {
        self.library = Some(library);
        self.kinds.iter_mut().zip(library).for_each(|(kind, effect)| *kind = Kind::of(*effect));
        self.begin();
    }

    /// Gives an effect its columns, behind those in use; `None` if there is no room: the effect is then not looked for.
    fn give_columns(&mut self, index: usize, effect: &dyn Effect, step: u8) -> Option<usize> {
        let (from, parameters) = (self.columns, effect.parameters());
        let places = self.places.get_mut(from..from + parameters.len())?;
        for (k, (place, parameter)) in places.iter_mut().zip(parameters).enumerate() {
            *place = Place {
                effect: index as u8,
                parameter: k as u8,
                step,
                sensor: effect.sensor(),
                usual: parameter.usual,
            };
        }
        self.columns += parameters.len();
        if let Some(first) = self.firsts.get_mut(index).filter(|_| step == 0) {
            *first = from as u8 + 1;
        }
        Some(from)
    }

    /// First column of an effect, if it has any.
    fn first_column(&self, effect: usize, step: u8) -> Option<usize> {
        if let Some(first) = self.firsts.get(effect).filter(|_| step == 0) {
            return usize::from(*first).checked_sub(1);
        }
        self.places().iter().position(|place| usize::from(place.effect) == effect && place.step == step)
    }

    /// Forgets all that was learnt of the effects, and takes nothing out.
    pub fn begin(&mut self) {
        self.x = [T::ZERO; EFFECTS];
        (self.columns, self.restored) = (0, CandidateSet::EMPTY);
        self.firsts = [0; MAX_CANDIDATES];
        self.shocks.start();
        self.squares = [T::ZERO; PARAMETERS];
        self.increments = 0;
        self.node = [[T::ZERO; EFFECTS]; NODE];
        self.globals = [[T::ZERO; EFFECTS]; GLOBALS];
        self.root = [[T::ZERO; EFFECTS]; EFFECTS];
        self.root.iter_mut().enumerate().for_each(|(i, row)| row[i] = T::ONE);
        self.constants = [T::ZERO; EFFECTS];
        self.start_node();
    }

    /// Takes out what was found in an earlier session. It may have changed since: half of the usual size is added to
    /// its deviation.
    pub fn restore(&mut self, effects: &ActiveEffects) {
        for found in effects.iter() {
            let index = usize::from(found.index);
            self.restored.insert(CandidateId::new(index));
            // A nuisance is restored with the filter's own state.
            let Some(effect) = self.library().get(index).filter(|effect| effect.vector_error().is_none()) else {
                continue;
            };
            if self.first_column(index, 0).is_none() {
                self.give_columns(index, *effect, 0);
            }
            for column in 0..self.used() {
                let place = self.places[column];
                let k = usize::from(place.parameter);
                if place.effect != found.index || place.usual <= 0.0 {
                    continue;
                }
                let (Some(value), Some(sigma)) = (found.parameters.get(k), found.sigma.get(k)) else { continue };
                let half = 0.5 * place.usual;
                self.x[column] = T::of(value / place.usual);
                self.root[column][column] = T::of(place.usual / libm::sqrtf(sigma * sigma + half * half));
            }
        }
    }

    /// Begins a node.
    pub fn start_node(&mut self) {
        self.rotation = [zero3(); EFFECTS];
        self.field = [zero3(); EFFECTS];
        self.velocity = [zero3(); EFFECTS];
        self.position = [zero3(); EFFECTS];
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.library.unwrap_or(&[])
    }

    /// Returns the number of columns in use.
    pub fn used(&self) -> usize {
        // A limit that the compiler knows: no index has to be checked.
        if self.columns < EFFECTS { self.columns } else { EFFECTS }
    }

    /// Returns the meaning of the columns in use.
    pub fn places(&self) -> &[Place] {
        self.places.get(..self.columns).unwrap_or_default()
    }

    /// Place of an effect's first parameter among those of the library.
    pub(super) fn first_parameter_of(&self, effect: usize) -> usize {
        self.library().iter().take(effect).map(|effect| effect.parameters().len()).sum()
    }

    /// Root mean square of what one unit of a parameter adds to its sensor's reading.
    pub fn shown(&self, effect: usize, parameter: usize) -> T {
        match self.squares.get(self.first_parameter_of(effect) + parameter) {
            Some(sum) if self.increments > 0 => (*sum / T::of(self.increments as f32)).root(),
            _ => T::ZERO,
        }
    }
}

#[cfg(test)]
mod tests;
