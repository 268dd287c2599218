//! First attitude at a start, and new attitude after a turn that no sensor saw: from specific force and field, averaged
//! over seconds in the body frame of their beginning.

use super::{
    preintegration::Preintegration,
    real::{M3, Real, V3, identity, zero3, zero33},
};

/// Seconds over which force and field are averaged at a start. A probe that moves within 1 m/s has a mean acceleration
/// of 0.5 m/s^2 over two seconds: 3 deg. From one instant the filter would converge to a wrong point.
const START_S: f32 = 2.0;
/// Seconds of the average after a gap: fewer, because P, b and the field's heading are known by then.
pub(super) const AFTER_GAP_S: f32 = 1.0;

/// Sums over the nodes since the average began.
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

    /// Adds a node to the average of force and field; a node with too few readings of force begins it anew. Returns
    /// true once the average is long enough to give an attitude.
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

    /// Directions of mean force and mean field (the lengths mean nothing), in the body's present frame; the field is
    /// zero if none was read.
    pub fn vectors(&self) -> [V3<T>; 2] {
        let back = self.rotation.transpose();
        [back * self.velocity, back * self.field]
    }
}
