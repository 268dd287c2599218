//! Places of the effects among the columns: an effect gets its columns when it is first seen to add to a reading.

use super::MAX_CANDIDATES;
use crate::compensation::{Effect, Sensor};

/// Meaning of a column.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Index of the effect in the library.
    pub effect: u8,
    /// Index of the effect's parameter.
    pub parameter: u8,
    /// Index of the bias step among several; 0 for other effects.
    pub step: u8,
    pub sensor: Sensor,
    /// Deviation of its prior: the unit of the column.
    pub usual: f32,
}

/// Source of an effect's columns.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// The effect has columns of its own, from the first increment with a term that is not zero.
    Own,
    /// The effect's unknowns are nuisances.
    Nuisance,
    /// The effect is a bias step, with columns for each of several shocks.
    BiasStep,
}

impl Kind {
    pub fn of(effect: &dyn Effect) -> Self {
        if effect.vector_error().is_some() {
            Self::Nuisance
        } else if effect.is_bias_step() {
            Self::BiasStep
        } else {
            Self::Own
        }
    }
}

/// Columns of the effects, in the order in which they were given.
pub(super) struct Places<const EFFECTS: usize> {
    library: Option<&'static [&'static dyn Effect]>,
    /// Kind of each effect of the library: asked for at every increment.
    kinds: [Kind; MAX_CANDIDATES],
    all: [Place; EFFECTS],
    count: usize,
    /// One past the first column of each effect, for a bias step that of the first step; 0: the effect has no columns.
    firsts: [u8; MAX_CANDIDATES],
}

impl<const EFFECTS: usize> Places<EFFECTS> {
    pub const fn zero() -> Self {
        const NOWHERE: Place = Place { effect: 0, parameter: 0, step: 0, sensor: Sensor::Gyro, usual: 0.0 };
        Self {
            library: None,
            kinds: [Kind::Own; MAX_CANDIDATES],
            all: [NOWHERE; EFFECTS],
            count: 0,
            firsts: [0; MAX_CANDIDATES],
        }
    }

    /// Sets the effects that are looked for.
    pub fn configure(&mut self, library: &'static [&'static dyn Effect]) {
        self.library = Some(library);
        self.kinds.iter_mut().zip(library).for_each(|(kind, effect)| *kind = Kind::of(*effect));
    }

    /// Takes all columns from the effects.
    pub fn begin(&mut self) {
        self.count = 0;
        self.firsts = [0; MAX_CANDIDATES];
    }

    /// The effects that are looked for.
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.library.unwrap_or(&[])
    }

    /// Source of the columns of an effect of the library.
    pub fn kind(&self, index: usize, effect: &dyn Effect) -> Kind {
        self.kinds.get(index).copied().unwrap_or_else(|| Kind::of(effect))
    }

    /// Returns the number of columns in use.
    pub fn used(&self) -> usize {
        // A limit that the compiler knows: no index has to be checked.
        if self.count < EFFECTS { self.count } else { EFFECTS }
    }

    /// Returns the meaning of the columns in use.
    pub fn in_use(&self) -> &[Place] {
        self.all.get(..self.count).unwrap_or_default()
    }

    /// Which of several bias steps a column is of; 0 for other effects.
    pub fn step(&self, column: usize) -> u8 {
        self.all.get(column).map_or(0, |place| place.step)
    }

    /// Returns true if a column is of a step of the bias.
    pub fn is_step(&self, column: usize) -> bool {
        let effect = self.all.get(column).and_then(|place| self.library().get(usize::from(place.effect)));
        effect.is_some_and(|effect| effect.is_bias_step())
    }

    /// Place of an effect's first parameter among those of the library.
    pub(super) fn first_parameter_of(&self, effect: usize) -> usize {
        self.library().iter().take(effect).map(|effect| effect.parameters().len()).sum()
    }

    /// Gives an effect its columns, behind those in use; `None` if there is no room: the effect is then not looked for.
    pub fn give_columns(&mut self, index: usize, effect: &dyn Effect, step: u8) -> Option<usize> {
        let (from, parameters) = (self.count, effect.parameters());
        let places = self.all.get_mut(from..from + parameters.len())?;
        for (k, (place, parameter)) in places.iter_mut().zip(parameters).enumerate() {
            *place = Place {
                effect: index as u8,
                parameter: k as u8,
                step,
                sensor: effect.sensor(),
                usual: parameter.usual,
            };
        }
        self.count += parameters.len();
        if let Some(first) = self.firsts.get_mut(index).filter(|_| step == 0) {
            *first = from as u8 + 1;
        }
        Some(from)
    }

    /// First column of an effect, if it has any.
    pub fn first_column(&self, effect: usize, step: u8) -> Option<usize> {
        if let Some(first) = self.firsts.get(effect).filter(|_| step == 0) {
            return usize::from(*first).checked_sub(1);
        }
        self.in_use().iter().position(|place| usize::from(place.effect) == effect && place.step == step)
    }
}
