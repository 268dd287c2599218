//! The first attitude, at a start and after a turn that nobody saw: from the mean force and field over seconds,
//! turned to their beginning.

use super::{
    preintegration::Preintegration,
    real::{M3, Real, V3, identity, zero3, zero33},
};

/// Seconds over which force and field are averaged at a start. What moves within a metre a second has a mean
/// acceleration of 0.5 m/s^2 over two seconds: 3 deg. From one instant the filter would converge to a wrong point.
const START_S: f32 = 2.0;
/// The same after a gap, when P and b are known and the field's heading is.
pub(super) const AFTER_GAP_S: f32 = 1.0;

/// Sums over the nodes since the start or the turn.
#[derive(Clone, Copy)]
pub(super) struct Alignment<T> {
    seconds: T,
    rotation: M3<T>,
    velocity: V3<T>,
    field: V3<T>,
}

impl<T: Real> Alignment<T> {
    pub const fn zero() -> Self {
        Self { seconds: T::ZERO, rotation: zero33(), velocity: zero3(), field: zero3() }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
        self.rotation = identity();
    }

    /// Adds a node; a node without force begins it anew. Whether there is enough.
    pub fn add(&mut self, pre: &Preintegration<T>, after_gap: bool) -> bool {
        if pre.forces < pre.increments {
            self.start();
            return false;
        }
        self.velocity += self.rotation * pre.velocity.value;
        self.field += self.rotation * pre.field;
        self.rotation *= pre.rotation;
        self.seconds += pre.seconds;
        self.seconds >= T::of(if after_gap { AFTER_GAP_S } else { START_S })
    }

    /// Mean force and field, of any length, as the body has them now; the field is zero where there was none.
    pub fn vectors(&self) -> [V3<T>; 2] {
        let back = self.rotation.transpose();
        [back * self.velocity, back * self.field]
    }
}
