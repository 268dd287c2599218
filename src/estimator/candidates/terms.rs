//! Terms of the effects: their additions to the readings of an increment, and to rotation, field, velocity and
//! position from node to node.

use super::{Candidates, Kind, Place, STEPS};
use crate::{
    compensation::{Effect, Sensor, Snapshot, effect::MAX_PARAMETERS},
    estimator::{
        increment::Increment,
        parameters::Parameters,
        preintegration::Turned,
        real::{Real, V3, square, zero3},
        taken_out::TakenOut,
    },
};
use nalgebra::Vector3;

impl<T: Real, const EFFECTS: usize> Candidates<T, EFFECTS> {
    /// Works out the terms of an increment. `rate_change`: derivative of its rate, rad/s^2; `field_ut`: the unit of
    /// its field.
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
        let rate = with.p * (increment.rate - with.bias);
        let field = with.mag_matrix * increment.field.unwrap_or_else(zero3) + with.hard_iron;
        let narrowed = |v: &V3<T>| v.map(|x| x.narrow());
        let moment = Snapshot {
            rate_rad_s: narrowed(&rate),
            acceleration_rad_s2: narrowed(&(with.p * rate_change)),
            force_m_s2: narrowed(&increment.force.unwrap_or_else(zero3)),
            square_force_m2_s4: increment.square_force.narrow(),
            field_ut: narrowed(&(field * field_ut)),
            warming_k: increment.warming_k.map_or(0.0, |x| x.narrow()),
        };
        self.increments = self.increments.saturating_add(1);
        let mut out = TakenOut::nothing();
        let mut before = 0;
        let mut all = [Vector3::zeros(); MAX_PARAMETERS];
        for (index, effect) in self.library.unwrap_or(&[]).iter().enumerate() {
            let count = effect.parameters().len();
            let terms = all.get_mut(..count).unwrap_or_default();
            effect.set_terms(&moment, terms);
            let squares = self.squares.get_mut(before..).unwrap_or_default();
            for (sum, term) in squares.iter_mut().zip(terms.iter()) {
                *sum += T::of(square(term));
            }
            before += count;
            match self.kinds.get(index).copied().unwrap_or_else(|| Kind::of(*effect)) {
                Kind::Nuisance => continue,
                Kind::BiasStep => {
                    self.look_at_steps(index, *effect, increment.end_us, &mut out);
                    continue;
                }
                Kind::Own => {}
            }
            let known = self.first_column(index, 0);
            // An effect whose terms have been zero so far needs no columns.
            let is_there = || terms.iter().any(|term| square(term) > 0.0);
            let Some(first) = known.or_else(|| if is_there() { self.give_columns(index, *effect, 0) } else { None })
            else {
                continue;
            };
            self.set_terms(first, terms, field_ut, &mut out);
        }
        (out, moment)
    }

    /// Sets the terms of the bias steps, each from its shock on.
    fn look_at_steps(&mut self, index: usize, effect: &dyn Effect, end_us: u64, out: &mut TakenOut<T>) {
        // Without a shock there is no step.
        if self.shocks.seen == 0 && self.first_column(index, 0).is_none() {
            return;
        }
        for step in 0..STEPS as u8 {
            let known = self.first_column(index, step);
            let Some(at_us) = self.shocks.at_us(step) else {
                if let Some(first) = known {
                    self.set_terms(first, &[Vector3::zeros(); 3], T::ONE, out);
                }
                continue;
            };
            let Some(first) = known.or_else(|| self.give_columns(index, effect, step)) else { continue };
            let on = if end_us > at_us { 1.0 } else { 0.0 };
            self.set_terms(first, &[Vector3::x() * on, Vector3::y() * on, Vector3::z() * on], T::ONE, out);
        }
    }

    /// Sets the terms of an effect's columns, and adds what is taken out to `out`.
    fn set_terms(&mut self, first: usize, terms: &[Vector3<f32>], field_ut: T, out: &mut TakenOut<T>) {
        let per_unit = if field_ut > T::ZERO { T::ONE / field_ut } else { T::ONE };
        let own = first..first + terms.len();
        let columns = (self.terms.get_mut(own.clone()), self.x.get(own.clone()), self.places.get(own));
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

    /// Adds the increment of the last `look_at`, turned to the node's beginning, to the sums of the node.
    pub fn add(&mut self, turned: &Turned<T>) {
        let Turned { middle, seconds, field, force } = turned;
        let (dt, half) = (*seconds, *seconds * T::of(0.5));
        let sums = self.rotation.iter_mut().zip(&mut self.field).zip(&mut self.velocity).zip(&mut self.position);
        let terms = self.terms.iter().zip(self.places.iter().take(self.columns));
        for ((((rotation, field_sum), velocity), position), (term, Place { sensor, .. })) in sums.zip(terms) {
            // The reading less its effect is the truth, so the term is subtracted.
            let term = -(middle * term);
            let mut go_on = |step: V3<T>| {
                *position += *velocity * dt + step * (dt * half);
                *velocity += step * dt;
            };
            match *sensor {
                Sensor::Gyro => {
                    let at_middle = *rotation + term * half;
                    if let Some(field) = field {
                        *field_sum += at_middle.cross(field);
                    }
                    if let Some(force) = force {
                        go_on(at_middle.cross(force));
                    }
                    *rotation += term * dt;
                }
                Sensor::Accelerometer if force.is_some() => go_on(term),
                Sensor::Magnetometer if field.is_some() => *field_sum += term,
                Sensor::Accelerometer | Sensor::Magnetometer => {}
            }
        }
    }
}
