//! Directions in which the body's axes have pointed. A constant field along an axis that always points the same way is
//! part of the earth's: what seems to tell them apart is the noise of the attitudes at which rows are made linear. So it
//! is along one that turns slowly, with the hole: its turns of hours are no larger than the errors of the attitude, which
//! come and go within minutes, and pass for iron of several microtesla.

use super::real::{M3, Real, V3, square, zero3};

/// Mean square turn of an axis, in variances of the attitude, from which on a constant field along it shows: at least half
/// of what tells it from the earth's are then turns, and no noise. Without any turn it stays below 1.1 over simulated
/// days, because most of the attitude's error lasts for longer than a minute.
const SHOWN_BY: f32 = 2.0;
/// Squared turn that a node counts for at most, in variances of the attitude: some nodes with a wrong attitude, as a fault
/// leaves, are no turn. Wobble of one size throughout counts in full up to twice what shows.
const MOST: f32 = 4.0 * SHOWN_BY;
/// Nodes that a mean direction remembers: about a minute, some periods of the slowest wobble of a string.
const REMEMBERED: f32 = 128.0;

/// Scatter of the body's axes in the earth frame.
#[derive(Clone, Copy)]
pub(super) struct Pointing<T> {
    /// Mean direction of each axis over the nodes that are remembered, since the heading began anew, and its weight: the
    /// sum of one over the attitude's variance, 1/rad^2.
    mean: [V3<T>; 3],
    weight: T,
    /// Sums of the squared distances from this mean, in units of the attitude's variance at each node, and the number of
    /// nodes.
    scatter: [T; 3],
    nodes: T,
}

impl<T: Real> Pointing<T> {
    pub const fn zero() -> Self {
        Self { mean: [zero3(); 3], weight: T::ZERO, scatter: [T::ZERO; 3], nodes: T::ZERO }
    }

    /// Forgets the mean directions: they do not compare with those of a new heading.
    pub fn turn_anew(&mut self) {
        (self.mean, self.weight) = ([zero3(); 3], T::ZERO);
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
        for ((mean, scatter), axis) in self.mean.iter_mut().zip(&mut self.scatter).zip(attitude.column_iter()) {
            let off = axis - *mean;
            let turned = square(&off) * own * (T::ONE - share);
            let most = T::of(MOST);
            // A node that is far off moves the mean as one that counts in full.
            let step = if turned > most { (most / turned).root() } else { T::ONE };
            *mean += off * (share * step);
            *scatter += if turned < most { turned } else { most };
        }
    }

    /// Returns, axis by axis, true if a constant field along it cannot be told from the earth's.
    pub fn hides(&self) -> [bool; 3] {
        let least = self.nodes * T::of(SHOWN_BY);
        self.scatter.map(|scatter| scatter <= least)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::estimator::real::rotation;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// Attitudes of a tool that turns about its axis, which swings by so much. They are known to a hundredth, but for
    /// two after a gap.
    fn turning(swing_rad: f64, new_heading: bool) -> [bool; 3] {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
        let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
        let mut pointing = Pointing::<f64>::zero();
        for k in 0..400 {
            let time = f64::from(k);
            let error = if k == 90 || k == 91 { 0.5 } else { 0.01 };
            let noise = V3::new(uniform(), uniform(), uniform()) * error;
            let swing = V3::new(0.6 + swing_rad * libm::sin(0.1 * time), 0.0, 0.0);
            let heading = if new_heading && k >= 200 { 2.0 } else { 0.0 };
            if new_heading && k == 200 {
                pointing.turn_anew();
            }
            let about_the_axis = rotation(&V3::new(0.0, 0.0, 1.3 * time));
            let attitude = rotation(&V3::new(0.0, 0.0, heading)) * rotation(&noise) * rotation(&swing) * about_the_axis;
            pointing.add(&attitude, error * error);
        }
        pointing.hides()
    }

    #[test]
    fn an_axis_that_points_one_way_hides_and_one_that_swings_by_more_than_the_attitude_errs_does_not() {
        assert_eq!(turning(0.0, false), [false, false, true]);
        assert_eq!(turning(0.01, false), [false, false, true]);
        assert_eq!(turning(0.05, false), [false, false, false]);
    }

    #[test]
    fn an_axis_that_turns_with_the_hole_hides() {
        let mut pointing = Pointing::<f64>::zero();
        for k in 0..8_000 {
            let time = f64::from(k);
            let (hole, tool) = (V3::new(0.6 + 5e-5 * time, 0.0, 0.0), V3::new(0.0, 0.0, 1.3 * time));
            pointing.add(&(rotation(&hole) * rotation(&tool)), 1e-4);
        }
        assert_eq!(pointing.hides(), [false, false, true]);
    }

    #[test]
    fn some_nodes_with_a_wrong_attitude_are_no_turn() {
        let mut pointing = Pointing::<f64>::zero();
        for k in 0..400 {
            let wrong = if (200..210).contains(&k) { 0.5 } else { 0.0 };
            let turned = rotation(&V3::new(0.6 + wrong, 0.0, 0.0)) * rotation(&V3::new(0.0, 0.0, 1.3 * f64::from(k)));
            pointing.add(&turned, 1e-4);
        }
        assert_eq!(pointing.hides(), [false, false, true]);
    }

    #[test]
    fn a_new_heading_is_no_turn() {
        assert_eq!(turning(0.0, true), [false, false, true]);
        assert_eq!(turning(0.05, true), [false, false, false]);
    }

    #[test]
    fn before_any_node_all_are_hidden() {
        assert_eq!(Pointing::<f32>::zero().hides(), [true; 3]);
    }
}
