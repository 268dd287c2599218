//! Work of the estimator between samples, piece by piece.

use super::{
    Centre, Estimator, Item, Kind, Refusal,
    candidates::{Misfit, Units, Unturned},
    columns::{GLOBALS, NUISANCES},
    increment::Increment,
    reading,
    real::{Real, V3, norm, widened, zero3},
    walk,
};
use core::f32::consts::PI;
use nalgebra::Vector3;

/// Length of a node, seconds.
const NODE_S: f32 = 0.5;

/// Cycles of a Cortex-M4F that a unit of work stands for: no piece takes more than its units of them
/// (`cargo mwd bench --target --only cost`).
pub const UNIT_CYCLES: u32 = 500;
/// Work units of the pieces: the largest cost of each kind that a flight has shown, in cycles, over [`UNIT_CYCLES`].
const INCREMENT_UNITS: u32 = 60;
const NODE_UNITS: u32 = 340;
const COLUMN_UNITS: u32 = 56;
const WIDENING_UNITS: u32 = 105;
const WALKING_UNITS: u32 = 70;
const START_UNITS: u32 = 320;
const GATHERING_UNITS: u32 = 70;
const SPREADING_UNITS: u32 = 300;
/// Interval at which the effects are weighed, microseconds.
const WEIGHED_EVERY_US: u64 = 5_000_000;
const CENTRE_UNITS: u32 = 420;
const BOUND_UNITS: u32 = 160;
const CONCLUDING_UNITS: u32 = 260;
/// Columns of the root's inverse that are gathered in one piece.
const GATHERED: usize = 4;

/// Piece of work in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// Takes the next waiting item.
    Next,
    /// Eliminates the old states from a node's rows.
    Eliminating,
    /// Adds the remaining rows to the globals, from this column on.
    Absorbing(usize),
    /// Adds the remaining rows to the effects' own, from this column on.
    AbsorbingOwn(usize),
    /// Weighs the effects.
    Weighing,
    /// Adds the uncertainty of the effects that are taken out to the covariance, one after the other.
    Spreading(usize),
    /// Widens each global that walks, from this column on.
    Widening(usize),
    /// Makes the widened root triangular, from this column on.
    Walking(usize),
    /// Gathers the globals' covariance, from this column of the root's inverse on.
    Gathering(usize),
    /// Averages the posterior.
    Averaging,
    /// Gathers the bound of the search's cost, from this node on.
    Bounding(usize),
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Does one bounded piece of work; returns its size in units of [`UNIT_CYCLES`], 0 when there is nothing to do.
    // Rare calls are not inlined: their stack frames would lie under all others.
    pub fn step(&mut self) -> u32 {
        match self.task {
            Task::Next => self.next(),
            Task::Eliminating => {
                if !self.update.eliminate(&self.candidates, &mut self.further) {
                    self.task = Task::Absorbing(0);
                }
                COLUMN_UNITS
            }
            Task::Absorbing(column) => {
                self.absorb(column);
                COLUMN_UNITS
            }
            Task::AbsorbingOwn(column) => {
                self.absorb_own(column);
                COLUMN_UNITS
            }
            Task::Weighing => {
                let units = self.evidence.units();
                self.weigh();
                units
            }
            Task::Gathering(from) => {
                self.gather(from);
                GATHERING_UNITS
            }
            Task::Spreading(of) => {
                if self.spread(of) {
                    return SPREADING_UNITS;
                }
                if self.is_searched {
                    self.task = Task::Bounding(0);
                    return SPREADING_UNITS;
                }
                self.conclude();
                CONCLUDING_UNITS
            }
            Task::Widening(from) => {
                self.widen(from);
                WIDENING_UNITS
            }
            Task::Walking(column) => {
                self.walk(column);
                WALKING_UNITS
            }
            Task::Averaging => {
                let units = self.averaging.units();
                if self.mix() {
                    return units;
                }
                self.task = Task::Spreading(0);
                if self.is_searched {
                    self.centre();
                }
                CENTRE_UNITS
            }
            Task::Bounding(from) => {
                if self.bound(from) {
                    self.conclude();
                    return BOUND_UNITS + CONCLUDING_UNITS;
                }
                BOUND_UNITS
            }
        }
    }

    fn next(&mut self) -> u32 {
        match self.intake.pop() {
            None => 0,
            Some(Item::Increment(increment)) => {
                let ends = self.course.neighbours.take().is_some_and(|held| self.take(&held, Some(&increment)));
                self.course.neighbours.hold(increment);
                if ends { INCREMENT_UNITS + NODE_UNITS } else { INCREMENT_UNITS }
            }
            Some(Item::Gap { seconds, silent_s }) => {
                let ends = self.course.neighbours.take().is_some_and(|held| self.take(&held, None));
                if silent_s < seconds * T::of(0.5) {
                    // Samples came without a usable rate: the gap is the gyro's, and so is the node that it cuts short.
                    self.shares.unread.add(T::ONE, seconds - silent_s + self.pre.seconds);
                }
                self.gap(seconds);
                if ends { INCREMENT_UNITS + NODE_UNITS } else { INCREMENT_UNITS }
            }
            Some(Item::Look) => {
                self.note_attitude();
                INCREMENT_UNITS
            }
            Some(Item::Close { is_searched }) => {
                self.is_searched = is_searched;
                self.average();
                START_UNITS
            }
        }
    }

    /// Puts the centre of the search at the averaged posterior.
    #[inline(never)]
    fn centre(&mut self) {
        let averaged = self.averaging.result(self.is_bias_measured());
        self.centre.clear();
        let inflations = self.settings.widths.inflations;
        let inflation = inflations.iter().fold(1.0_f32, |most, x| if *x > most { *x } else { most });
        let (mean, covariance) = (averaged.mean.map(|x| x.narrow()), averaged.covariance.map(|x| x.narrow()));
        if let Some(centre) = Centre::new(&self.left_over, &mean, &covariance, inflation) {
            // Just emptied, so there is room.
            let _ = self.centre.push(centre);
        }
    }

    /// Bounds the search's cost by some nodes' rows; `true` when the bound is set.
    fn bound(&mut self, from: usize) -> bool {
        let Some(centre) = self.centre.first_mut() else { return true };
        let next = centre.bound_by_rows(&self.left_over, from, self.update.rows.as_flattened_mut());
        if let Some(next) = next {
            self.task = Task::Bounding(next);
        }
        next.is_none()
    }

    /// Returns true if a rest has measured the bias: it is then not the factory's any more, with which the filter
    /// begins.
    fn is_bias_measured(&self) -> bool {
        self.bias != V3::from(self.settings.factory.b_rad_s.map(T::of))
    }

    #[inline(never)]
    fn conclude(&mut self) {
        let posterior = self.posterior_of(&self.averaging.result(self.is_bias_measured()));
        // The stored model is then that of another gyro.
        let is_forsaken = self.prior.is_restored && matches!(posterior.fitness, Err(Refusal::Implausible { .. }));
        self.posterior.clear();
        let _ = self.posterior.push(posterior);
        self.task = Task::Next;
        if self.course.consistency.has_diverged() || is_forsaken {
            self.begin();
        } else if let Some(claim) = self.candidates.old_step(&self.evidence.account.claims, self.course.weighed_us) {
            let [x, y, z, ..] = claim.parameters;
            self.candidates.settle(&claim, &mut self.globals, &self.prior.sigma);
            self.evidence.account.claims.retain(|other| other.step_us != claim.step_us);
            let step =
                self.parameters.p.try_inverse().map_or_else(zero3, |inverse| inverse * widened(&Vector3::new(x, y, z)));
            self.step_bias(&step);
            self.task = Task::Walking(0);
        }
    }

    /// Adds an increment whose neighbours are known; `true` if a node ends with it.
    #[inline(never)]
    fn take(&mut self, increment: &Increment<T>, next: Option<&Increment<T>>) -> bool {
        let mut increment = *increment;
        if let Some(field) = &mut increment.field {
            if self.course.field_unit == T::ZERO {
                self.course.field_unit = norm(field);
            }
            if self.course.field_unit > T::ZERO {
                *field /= self.course.field_unit;
            }
        }
        let [force_rate, rate_change] = self.course.neighbours.derivatives(&increment, next);
        let (out, moment) = self.candidates.look_at(&increment, &rate_change, self.course.field_unit, &self.parameters);
        let gravity = (self.course.is_aligned && self.settings.noise.predicted_gravity).then(|| {
            let up = V3::new(T::ZERO, T::ZERO, T::of(self.settings.gravity_m_s2));
            self.node.point().transpose() * up
        });
        let turned = self.pre.add(&increment, &force_rate, gravity.as_ref(), &self.parameters, &out);
        self.candidates.add(&turned);
        self.remainder.watch(&moment, &(self.node.attitude * turned.middle).map(|x| x.narrow()));
        // A node ends up to half an increment early, as the increments' lengths are rounded.
        let late = self.pre.seconds + self.intake.increment_s() * T::of(0.5);
        let ends = late >= T::of(NODE_S) || self.pre.angle >= T::of(PI);
        if ends {
            self.end_node();
        }
        ends
    }

    #[inline(never)]
    fn absorb(&mut self, column: usize) {
        self.updates = self.updates.wrapping_add(1);
        if column == NUISANCES && self.kind == Kind::Moving {
            self.left_over.push(self.update.left_over(), &self.globals.x);
        }
        let next = self.candidates.absorb(&mut self.further, &mut self.globals, self.update.left_over(), column);
        if next < GLOBALS {
            self.task = Task::Absorbing(next);
            return;
        }
        if self.kind == Kind::Moving {
            self.course.consistency.add(self.update.innovation());
        }
        self.task = Task::AbsorbingOwn(0);
    }

    #[inline(never)]
    fn absorb_own(&mut self, column: usize) {
        if self.candidates.absorb_own(&mut self.further, self.update.left_over(), column) {
            self.task = Task::AbsorbingOwn(column + 2);
            return;
        }
        if self.kind == Kind::Moving {
            self.course.consistency.add_unexplained(self.update.innovation());
        }
        let change = self.globals.solve();
        self.update.finish(&mut self.node, &change);
        self.candidates.finish(&self.further);
        let end_us = self.pre.end_us;
        self.pre.start();
        self.linearise();
        self.task = Task::Next;
        // Both move the means, which must not happen in the middle of a node.
        if self.course.unwalked_s >= T::of(walk::EVERY_S) {
            self.task = Task::Widening(0);
        } else if end_us >= self.course.weighed_us.saturating_add(WEIGHED_EVERY_US) {
            self.course.weighed_us = end_us;
            let of = (&self.settings, self.course.field_unit);
            let told = reading::told_by_reference(&self.node, of, (&self.globals.x, &self.prior.sigma));
            let mut unturned = Unturned { axes: self.unturned(), told };
            let (is_read, is_linear) = (self.node.referred > 0, self.node.curved == 0);
            if is_read && is_linear && !unturned.explains_the_field(&self.globals.x) {
                // An attitude is wrong, and what follows from it would be.
                return;
            }
            if unturned.told.is_none() && is_read {
                // While the attitude is found again, what the field told before holds.
                unturned.told = self.evidence.told();
            }
            let is_unexplained = self.was_unexplained || self.remainder.is_contradicted();
            let misfit = Misfit { dispersion: self.remainder.dispersion(), is_unexplained };
            self.evidence.start(&self.settings.rules, misfit, unturned, &self.candidates);
            self.task = Task::Weighing;
        }
    }

    /// Does one piece of the weighing of the effects; at its end takes out the mean of those that the data show.
    #[inline(never)]
    fn weigh(&mut self) {
        let units = Units { sigma: &self.prior.sigma, field_ut: self.course.field_unit };
        let rows = (&mut self.update.rows, &mut self.further);
        if self.evidence.step(rows, &self.globals, &self.candidates, &units) {
            return;
        }
        let mut x = [T::ZERO; E];
        for (column, mean) in self.evidence.account.taken.iter().zip(&self.evidence.account.mean) {
            if let Some(x) = column.place().and_then(|place| x.get_mut(place)) {
                *x = *mean;
            }
        }
        // The search's rows hold for what was taken out before; with other effects they would draw it off the mean.
        if x != *self.candidates.x() {
            self.left_over.start();
        }
        self.candidates.take_out(&x, &mut self.globals, &mut self.node);
        self.candidates.note_steps(&self.evidence.account.claims, &self.evidence.choice.tried);
        self.linearise();
        self.task = Task::Next;
    }

    // Not inlined, nor are the pieces below: the cost of each kind of work is counted by its function's calls.
    #[inline(never)]
    fn average(&mut self) {
        self.centre.clear();
        self.averaging.start(&self.globals, &self.settings.widths, &mut self.update.rows);
        self.task = Task::Gathering(0);
    }

    /// Gathers the covariance from some columns of the root's inverse.
    #[inline(never)]
    fn gather(&mut self, from: usize) {
        let more = self.averaging.gather(from..from + GATHERED, &mut self.update.rows);
        self.task = if more { Task::Gathering(from + GATHERED) } else { Task::Averaging };
    }

    /// Adds one set of widths to the average; `false` when all are in.
    #[inline(never)]
    fn mix(&mut self) -> bool {
        self.averaging.step(&mut self.update.rows)
    }

    /// Widens the gyro's covariance by the uncertainty of the effects that are taken out, one vector a call; `false`
    /// after the last.
    #[inline(never)]
    fn spread(&mut self, of: usize) -> bool {
        if of >= self.evidence.account.taken.len() {
            return false;
        }
        let spread = self.candidates.spread(
            of,
            (&self.evidence.account.taken, &self.evidence.account.covariance),
            &self.globals,
        );
        self.averaging.spread(&spread);
        self.task = Task::Spreading(of + 1);
        true
    }

    /// Widens the next global that walks, from a column on.
    #[inline(never)]
    fn widen(&mut self, from: usize) {
        for (column, sigma) in self.prior.sigma.iter().enumerate().skip(from) {
            let variance = walk::variance_per_s(column, sigma.narrow(), &self.settings.noise);
            if variance > 0.0 {
                self.candidates.widen(&mut self.globals, column, T::of(variance) * self.course.unwalked_s);
                self.task = Task::Widening(column + 1);
                return;
            }
        }
        self.course.unwalked_s = T::ZERO;
        self.task = Task::Walking(0);
    }

    #[inline(never)]
    fn walk(&mut self, column: usize) {
        self.updates = self.updates.wrapping_add(1);
        self.candidates.triangular(&mut self.globals, column);
        self.task = if column + 1 < GLOBALS { Task::Walking(column + 1) } else { Task::Next };
    }
}
