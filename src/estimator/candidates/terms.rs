//! Terms of the effects: what each adds to the readings of an increment.

use super::{
    PARAMETERS, STEPS,
    places::{Kind, Places},
    shocks::Shocks,
};
use crate::{
    compensation::{Effect, Sensor, Snapshot, effect::MAX_PARAMETERS},
    estimator::{
        increment::Increment,
        parameters::Parameters,
        real::{Real, V3, rotation, square, zero3},
        taken_out::TakenOut,
    },
};
use nalgebra::Vector3;

/// Number of increments over which the mean squares are kept: an hour and a half. A plain sum over weeks would stop
/// growing in an f32, and a longer mean would stop following.
const REMEMBERED: u32 = 1 << 17;

/// Terms of the latest increment, and what the library's effects have added so far.
pub(super) struct Terms<T, const EFFECTS: usize> {
    /// Term of each column in the latest increment: what its effect adds to its sensor's reading at the prior's
    /// deviation.
    pub all: [V3<T>; EFFECTS],
    /// Mean squares of what one unit of each of the library's parameters adds to a reading, and the number of
    /// increments in these means, at most [`REMEMBERED`].
    pub squares: [T; PARAMETERS],
    pub increments: u32,
    /// Latest specific force, turned back as the probe turned since, and its mean square: an increment without a force
    /// has that of the one before.
    force: V3<T>,
    square_force: T,
}

impl<T: Real, const EFFECTS: usize> Terms<T, EFFECTS> {
    pub const fn zero() -> Self {
        Self {
            all: [zero3(); EFFECTS],
            squares: [T::ZERO; PARAMETERS],
            increments: 0,
            force: zero3(),
            square_force: T::ZERO,
        }
    }

    /// Forgets what the effects have added.
    pub fn begin(&mut self) {
        self.squares = [T::ZERO; PARAMETERS];
        self.increments = 0;
        (self.force, self.square_force) = (zero3(), T::ZERO);
    }

    /// Root mean square of what one unit of a parameter, counted in the library, adds to its sensor's reading.
    pub fn shown(&self, parameter: usize) -> T {
        match self.squares.get(parameter) {
            Some(mean) => mean.root(),
            None => T::ZERO,
        }
    }

    /// Works out the terms of an increment, and what is taken out of it: `x` of each column. `rate_change`: derivative
    /// of its rate, rad/s^2; `field_ut`: the unit of its field.
    pub fn update(
        &mut self,
        (increment, rate_change, field_ut): (&Increment<T>, &V3<T>, T),
        with: &Parameters<T>,
        x: &[T; EFFECTS],
        places: &mut Places<EFFECTS>,
        shocks: &Shocks,
    ) -> (TakenOut<T>, Snapshot) {
        let rate = with.p * (increment.rate - with.bias);
        let field = with.mag_matrix * increment.field.unwrap_or_else(zero3) + with.hard_iron;
        let narrowed = |v: &V3<T>| v.map(|x| x.narrow());
        if let Some(force) = increment.force {
            (self.force, self.square_force) = (force, increment.square_force);
        } else {
            self.force = rotation(&(rate * (T::ZERO - increment.seconds))) * self.force;
        }
        let moment = Snapshot {
            rate_rad_s: narrowed(&rate),
            acceleration_rad_s2: narrowed(&(with.p * rate_change)),
            force_m_s2: narrowed(&self.force),
            square_force_m2_s4: self.square_force.narrow(),
            field_ut: narrowed(&(field * field_ut)),
            warming_k: increment.warming_k.map_or(0.0, |x| x.narrow()),
        };
        self.increments = if self.increments < REMEMBERED { self.increments + 1 } else { REMEMBERED };
        let share = T::ONE / T::of(self.increments as f32);
        let mut out = TakenOut::nothing();
        let mut before = 0;
        let mut all = [Vector3::zeros(); MAX_PARAMETERS];
        for (index, effect) in places.library().iter().enumerate() {
            let count = effect.parameters().len();
            let terms = all.get_mut(..count).unwrap_or_default();
            effect.set_terms(&moment, terms);
            let squares = self.squares.get_mut(before..).unwrap_or_default();
            for (mean, term) in squares.iter_mut().zip(terms.iter()) {
                *mean += (T::of(square(term)) - *mean) * share;
            }
            before += count;
            match places.kind(index, *effect) {
                Kind::Nuisance => continue,
                Kind::BiasStep => {
                    self.update_steps((index, *effect), increment.end_us, x, places, shocks, &mut out);
                    continue;
                }
                Kind::Own => {}
            }
            let known = places.first_column(index, 0);
            // An effect whose terms have been zero so far needs no columns.
            let is_there = || terms.iter().any(|term| square(term) > 0.0);
            let Some(first) = known.or_else(|| if is_there() { places.give_columns(index, *effect, 0) } else { None })
            else {
                continue;
            };
            self.set(first, terms, field_ut, x, places, &mut out);
        }
        (out, moment)
    }

    /// Sets the terms of the bias steps, each from its shock on.
    fn update_steps(
        &mut self,
        (index, effect): (usize, &dyn Effect),
        end_us: u64,
        x: &[T; EFFECTS],
        places: &mut Places<EFFECTS>,
        shocks: &Shocks,
        out: &mut TakenOut<T>,
    ) {
        // Without a shock there is no step.
        if shocks.seen == 0 && places.first_column(index, 0).is_none() {
            return;
        }
        for step in 0..STEPS as u8 {
            let known = places.first_column(index, step);
            let Some(at_us) = shocks.at_us(step) else {
                if let Some(first) = known {
                    self.set(first, &[Vector3::zeros(); 3], T::ONE, x, places, out);
                }
                continue;
            };
            let Some(first) = known.or_else(|| places.give_columns(index, effect, step)) else { continue };
            let on = if end_us > at_us { 1.0 } else { 0.0 };
            let terms = [Vector3::x() * on, Vector3::y() * on, Vector3::z() * on];
            self.set(first, &terms, T::ONE, x, places, out);
        }
    }

    /// Sets the terms of an effect's columns, and adds what is taken out to `out`.
    fn set(
        &mut self,
        first: usize,
        terms: &[Vector3<f32>],
        field_ut: T,
        x: &[T; EFFECTS],
        places: &Places<EFFECTS>,
        out: &mut TakenOut<T>,
    ) {
        let per_unit = if field_ut > T::ZERO { T::ONE / field_ut } else { T::ONE };
        let own = first..first + terms.len();
        let columns = (self.all.get_mut(own.clone()), x.get(own.clone()), places.in_use().get(own));
        let (Some(own), Some(x), Some(places)) = columns else { return };
        for (((term, x), place), one) in own.iter_mut().zip(x).zip(places).zip(terms) {
            let one = one * place.usual;
            let one = V3::new(T::of(one.x), T::of(one.y), T::of(one.z));
            let (sum, one) = match place.sensor {
                Sensor::Gyro => (&mut out.rate, one),
                Sensor::Accelerometer => (&mut out.force, one),
                Sensor::Magnetometer => (&mut out.field, one * per_unit),
            };
            *term = one;
            if *x != T::ZERO {
                *sum += one * *x;
            }
        }
    }
}
