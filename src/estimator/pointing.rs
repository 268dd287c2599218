//! Directions in which the body's axes have pointed. A constant field along an axis that always points the same way is
//! part of the earth's: what seems to tell them apart is the noise of the attitudes at which rows are made linear. So
//! it is along one that turns slowly, with the hole: its turns of hours are no larger than the errors of the attitude,
//! which come and go within minutes, and pass for iron of several microtesla.

use super::real::{M3, Real, square, zero33};

/// Mean square turn of an axis, in variances of the attitude, from which on a constant field along it shows: at least
/// half of what tells it from the earth's are then turns, and no noise. Without any turn it stays below 1.1 over
/// simulated days, because most of the attitude's error lasts for longer than a minute.
const SHOWN_BY: f32 = 2.0;
/// Squared turn that a node counts for at most, in variances of the attitude: some nodes with a wrong attitude, as a
/// fault leaves, are no turn. Wobble of one size throughout counts in full up to twice what shows.
const MOST: f32 = 4.0 * SHOWN_BY;
/// Nodes that a mean direction remembers: about a minute, some periods of the slowest wobble of a string.
const REMEMBERED: f32 = 128.0;

/// Angle between an axis of the sensors and the one that it stands for, rad: three deviations of what a gyro's matrix
/// turns off the axes, 3 %.
const TILT_RAD: f32 = 0.1;

/// Scatter of the body's axes in the earth frame.
#[derive(Clone, Copy)]
pub(super) struct Pointing<T> {
    swings: [Swing<T>; 3],
    /// Weight of the mean attitudes: the sum of one over the attitude's variance, 1/rad^2.
    weight: T,
    nodes: T,
}

/// Swings of one of the axes.
#[derive(Clone, Copy)]
struct Swing<T> {
    /// Mean direction of each axis over the nodes that are remembered, since the heading began anew.
    mean: M3<T>,
    /// Sums of the products of the axes' distances from it, in units of the attitude's variance at each node.
    scatter: M3<T>,
}

impl<T: Real> Pointing<T> {
    pub const fn zero() -> Self {
        Self { swings: [Swing { mean: zero33(), scatter: zero33() }; 3], weight: T::ZERO, nodes: T::ZERO }
    }

    /// Forgets the mean directions: they do not compare with those of a new heading.
    pub fn turn_anew(&mut self) {
        self.swings.iter_mut().for_each(|swing| swing.mean = zero33());
        self.weight = T::ZERO;
    }

    /// Adds the attitude at which a node's rows are made linear, and its variance, rad^2.
    pub fn add(&mut self, attitude: &M3<T>, variance: T) {
        if variance <= T::ZERO {
            return;
        }
        let own = T::ONE / variance;
        self.weight = self.weight * T::of(1.0 - 1.0 / REMEMBERED) + own;
        self.nodes += T::ONE;
        let share = own / self.weight;
        for (axis, swing) in self.swings.iter_mut().enumerate() {
            swing.add(axis, attitude, share, own * (T::ONE - share));
        }
    }

    /// Returns, axis by axis, true if a constant field along it cannot be told from the earth's.
    pub fn hides(&self) -> [bool; 3] {
        let least = self.nodes * T::of(SHOWN_BY);
        let [x, y, z] = self.swings.each_ref().map(|swing| &swing.scatter);
        let scatters = [
            [x.m11, x.m12, x.m13, x.m22, x.m23, x.m33],
            [y.m22, y.m23, y.m21, y.m33, y.m31, y.m11],
            [z.m33, z.m31, z.m32, z.m11, z.m12, z.m22],
        ];
        scatters.map(|scatter| beside_tilt(&scatter, least / T::of(TILT_RAD * TILT_RAD)) <= least)
    }
}

impl<T: Real> Swing<T> {
    /// Adds an attitude, with its share of the mean's weight and the weight of its squared distance from the mean.
    fn add(&mut self, axis: usize, attitude: &M3<T>, share: T, weight: T) {
        let off = attitude - self.mean;
        let turned = off.column_iter().nth(axis).map_or(T::ZERO, |off| square(&off.into())) * weight;
        let most = T::of(MOST);
        let counted = if turned > most { most / turned } else { T::ONE };
        // A node that is far off moves the mean as one that counts in full.
        self.mean += off * (share * counted.root());
        self.scatter += off.transpose() * off * (weight * counted);
    }
}

/// Returns the scatter `aa` of an axis a without what a small tilt towards the others, b and c, explains: an axis that
/// is tilted from the one about which the tool turns goes round with it, and that turns no iron against the earth's
/// field. `stiffness`: what a tilt costs, over its square.
fn beside_tilt<T: Real>(&[aa, ab, ac, bb, bc, cc]: &[T; 6], stiffness: T) -> T {
    let (bb, cc) = (bb + stiffness, cc + stiffness);
    if bb <= T::ZERO {
        return aa;
    }
    let (ac, cc) = (ac - ab * bc / bb, cc - bc * bc / bb);
    aa - ab * ab / bb - if cc > T::ZERO { ac * ac / cc } else { T::ZERO }
}

#[cfg(test)]
mod tests;
