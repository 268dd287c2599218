//! Duration of a sensor's contradiction: a disturbance passes; a contradiction that stays is a change, and is learnt
//! anew.

use super::{
    reading::{Agreement, Readings},
    real::Real,
};

/// Seconds from which on a contradiction is no disturbance: the estimate that the sensor contradicts is wrong.
const FOR_GOOD_S: f32 = 20.0;
/// Seconds of agreement that end a contradiction.
const OVER_S: f32 = 5.0;

/// A contradiction in progress, or none.
#[derive(Clone, Copy)]
pub(super) struct Disagreement<T> {
    /// Seconds since the contradiction began; 0: there is none.
    seconds: T,
    /// Seconds of agreement since the sensor last contradicted.
    agreed_s: T,
}

impl<T: Real> Disagreement<T> {
    pub const fn zero() -> Self {
        Self { seconds: T::ZERO, agreed_s: T::ZERO }
    }

    /// Adds seconds of contradiction. Returns true if it is for good; the count then begins anew.
    pub fn contradicted(&mut self, seconds: T) -> bool {
        self.agreed_s = T::ZERO;
        self.seconds += seconds;
        let is_for_good = self.seconds > T::of(FOR_GOOD_S);
        if is_for_good {
            *self = Self::zero();
        }
        is_for_good
    }

    /// Adds seconds of agreement, which may be by chance if the attitude was just aligned to the sensor.
    pub fn agreed(&mut self, seconds: T) {
        self.agreed_s += seconds;
        self.passed(seconds);
        if self.agreed_s > T::of(OVER_S) {
            *self = Self::zero();
        }
    }

    /// Adds seconds in which the sensor could not be compared.
    pub fn passed(&mut self, seconds: T) {
        if self.seconds > T::ZERO {
            self.seconds += seconds;
        }
    }
}

/// Disagreement of each sensor with all the others together.
#[derive(Clone, Copy)]
pub(super) struct Disagreements<T> {
    pub field: Disagreement<T>,
    pub force: Disagreement<T>,
    pub gyro: Disagreement<T>,
}

impl<T: Real> Disagreements<T> {
    pub const fn zero() -> Self {
        Self { field: Disagreement::zero(), force: Disagreement::zero(), gyro: Disagreement::zero() }
    }

    /// Returns for field and force whether they have contradicted what is estimated for too long for it to be right: of
    /// the field the earth's, the hard iron and the attitude, of the force the attitude. Readings that are missing now
    /// and then end no contradiction; readings that stay away do.
    pub fn for_good(&mut self, agreement: &Agreement<T>, seconds: T) -> [bool; 2] {
        let is_for_good = |readings, of: &mut Disagreement<T>| match readings {
            Readings::Contradicted => of.contradicted(seconds),
            Readings::Used => {
                *of = Disagreement::zero();
                false
            }
            Readings::Missing => {
                of.agreed(seconds);
                false
            }
        };
        [is_for_good(agreement.field, &mut self.field), is_for_good(agreement.force, &mut self.force)]
    }
}

#[cfg(test)]
mod tests;
