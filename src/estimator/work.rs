//! The work between samples, piece by piece.

use super::{
    Centre, Estimator, Item, Kind, Refusal, Task,
    candidates::Units,
    columns::{GLOBALS, NUISANCES},
    increment::Increment,
    real::{Real, V3, norm, widened, zero3},
    remainder::INNOVATIONS,
    walk,
    window_cost::{Information, gather},
};
use core::f32::consts::PI;
use nalgebra::Vector3;

/// Length of a node, seconds.
const NODE_S: f32 = 0.5;
/// Degrees of freedom of a node: its rows less its states.
pub(super) const FREEDOM: f32 = 9.0;

/// Work units (some 300 instructions) of the pieces.
const INCREMENT_UNITS: u32 = 40;
const COLUMN_UNITS: u32 = 45;
const START_UNITS: u32 = 120;
const WEIGHING_UNITS: u32 = 400;
const SPREADING_UNITS: u32 = 100;
/// Interval at which the effects are weighed, microseconds.
const WEIGHED_EVERY_US: u64 = 5_000_000;
const WIDTHS_UNITS: u32 = 150;
const CENTRE_UNITS: u32 = 500;
/// Nodes whose rows are gathered in one piece.
const BOUND_NODES: usize = 20;

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// One bounded piece of work; its size in units of some 300 instructions, 0 when there is nothing to do.
    // What it calls seldom is not inlined: the frame would lie under all else.
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
                self.weigh();
                WEIGHING_UNITS
            }
            Task::Spreading(of) => {
                self.spread(of);
                SPREADING_UNITS
            }
            Task::Walking(column) => {
                self.walk(column);
                COLUMN_UNITS
            }
            Task::Averaging => {
                if !self.averaging.step(&mut self.update.rows) {
                    self.centre();
                    self.task = Task::Bounding(0);
                    return CENTRE_UNITS;
                }
                WIDTHS_UNITS
            }
            Task::Bounding(from) => {
                if self.bound(from) {
                    self.conclude();
                }
                CENTRE_UNITS
            }
        }
    }

    fn next(&mut self) -> u32 {
        match self.waiting.pop_front() {
            None => 0,
            Some(Item::Increment(increment)) => {
                if let Some(held) = self.held.pop() {
                    self.take(&held, Some(&increment));
                }
                // Just emptied, so there is room.
                let _ = self.held.push(increment);
                INCREMENT_UNITS
            }
            Some(Item::Gap { seconds, silent_s }) => {
                if let Some(held) = self.held.pop() {
                    self.take(&held, None);
                }
                if silent_s < seconds * T::of(0.5) {
                    // It is the gyro's; so is the node that it cuts short.
                    self.unread.add(T::ONE, seconds - silent_s + self.pre.seconds);
                }
                self.gap(seconds);
                INCREMENT_UNITS
            }
            Some(Item::Look) => {
                self.note_attitude();
                INCREMENT_UNITS
            }
            Some(Item::Close) => {
                self.average();
                START_UNITS
            }
        }
    }

    /// The posterior is averaged: what the search goes about.
    #[inline(never)]
    fn centre(&mut self) {
        let averaged = self.averaging.result();
        self.centre.clear();
        let inflations = self.settings.widths.inflations;
        let inflation = inflations.iter().fold(1.0_f32, |most, x| if *x > most { *x } else { most });
        let (mean, covariance) = (averaged.mean.map(|x| x.narrow()), averaged.covariance.map(|x| x.narrow()));
        if let Some(centre) = Centre::new(&self.left_over, &mean, &covariance, inflation) {
            // Just emptied, so there is room.
            let _ = self.centre.push(centre);
        }
    }

    /// Sees to it that the search's cost has a minimum: gathers the information of so many nodes' rows at a time, in
    /// scratch memory, and bounds the cost by it; `true` when that is done.
    fn bound(&mut self, from: usize) -> bool {
        let Some(centre) = self.centre.first_mut() else { return true };
        let scratch = self.update.rows.as_flattened_mut();
        let mut left = Information::zero();
        if from > 0 {
            left.0.iter_mut().zip(scratch.iter()).for_each(|(left, kept)| *left = kept.narrow());
        }
        let count = self.left_over.count();
        if from >= count {
            centre.bound(&left);
            return true;
        }
        let end = if from + BOUND_NODES < count { from + BOUND_NODES } else { count };
        gather(&self.left_over, from..end, &mut left);
        scratch.iter_mut().zip(&left.0).for_each(|(kept, left)| *kept = T::of(*left));
        self.task = Task::Bounding(end);
        false
    }

    #[inline(never)]
    fn conclude(&mut self) {
        let posterior = self.posterior_of(&self.averaging.result());
        // Then it is not the gyro any more that the stored model was of.
        let is_forsaken = self.is_restored && matches!(posterior.fitness, Err(Refusal::Implausible { .. }));
        self.posterior.clear();
        let _ = self.posterior.push(posterior);
        self.task = Task::Next;
        if self.has_diverged() || is_forsaken {
            self.begin();
        } else if let Some(claim) = self.candidates.old_step(&self.evidence.claims, self.weighed_us) {
            let [x, y, z, ..] = claim.parameters;
            self.candidates.settle(&claim, &mut self.globals, &self.sigma);
            self.evidence.claims.retain(|other| other.step_us != claim.step_us);
            let step =
                self.parameters.p.try_inverse().map_or_else(zero3, |inverse| inverse * widened(&Vector3::new(x, y, z)));
            self.step_bias(&step);
            self.task = Task::Walking(0);
        }
    }

    /// An increment whose neighbours are known.
    fn take(&mut self, increment: &Increment<T>, next: Option<&Increment<T>>) {
        let after = next.and_then(|next| next.force);
        let mut increment = *increment;
        if let Some(field) = &mut increment.field {
            if self.field_unit == T::ZERO {
                self.field_unit = norm(field);
            }
            if self.field_unit > T::ZERO {
                *field /= self.field_unit;
            }
        }
        let before = core::mem::replace(&mut self.held_before, increment.force);
        let force_rate = match (before, increment.force, after) {
            (Some(before), _, Some(after)) => (after - before) / (increment.seconds + increment.seconds),
            (None, Some(now), Some(after)) => (after - now) / increment.seconds,
            (Some(before), Some(now), None) => (now - before) / increment.seconds,
            _ => zero3(),
        };
        let earlier = self.rate_before.replace(increment.rate);
        let rate_change = match (earlier, next) {
            (Some(before), Some(next)) => (next.rate - before) / (increment.seconds + increment.seconds),
            (None, Some(next)) => (next.rate - increment.rate) / increment.seconds,
            (Some(before), None) => (increment.rate - before) / increment.seconds,
            (None, None) => zero3(),
        };
        let (out, moment) = self.candidates.look_at(&increment, &rate_change, self.field_unit, &self.parameters);
        let gravity = (self.is_aligned && self.settings.noise.predicted_gravity).then(|| {
            let up = V3::new(T::ZERO, T::ZERO, T::of(self.settings.gravity_m_s2));
            self.node.point().transpose() * up
        });
        let turned = self.pre.add(&increment, &force_rate, gravity.as_ref(), &self.parameters, &out);
        self.candidates.add(&turned);
        self.remainder.watch(&moment, &(self.node.attitude * turned.middle).map(|x| x.narrow()));
        // Half an increment early: lengths are rounded.
        let late = self.pre.seconds + self.builder.seconds() * T::of(0.5);
        if late >= T::of(NODE_S) || self.pre.angle >= T::of(PI) {
            self.end_node();
        }
    }

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
            let square = self.update.innovation() / T::of(FREEDOM);
            self.innovations = if self.innovations < INNOVATIONS { self.innovations + 1 } else { INNOVATIONS };
            self.innovation += (square - self.innovation) / T::of(f32::from(self.innovations));
        }
        self.task = Task::AbsorbingOwn(0);
    }

    fn absorb_own(&mut self, column: usize) {
        if self.candidates.absorb_own(&mut self.further, self.update.left_over(), column) {
            self.task = Task::AbsorbingOwn(column + 2);
            return;
        }
        if self.kind == Kind::Moving {
            self.unexplained += self.update.innovation();
            self.nodes = self.nodes.saturating_add(1);
        }
        let change = self.globals.solve();
        self.update.finish(&mut self.node, &change);
        self.candidates.finish(&self.further);
        let end_us = self.pre.end_us;
        self.pre.start();
        self.linearise();
        self.task = Task::Next;
        // Means move with both: not in the middle of a node.
        if self.unwalked_s >= T::of(walk::EVERY_S) {
            self.widen();
        } else if end_us >= self.weighed_us.saturating_add(WEIGHED_EVERY_US) {
            self.weighed_us = end_us;
            let is_unexplained = self.was_unexplained || self.remainder.is_contradicted();
            self.evidence.start(&self.settings.rules, self.remainder.dispersion(), is_unexplained);
            self.task = Task::Weighing;
        }
    }

    /// One piece of the weighing of the effects; when it is done, what is taken out is the mean of what they want.
    #[inline(never)]
    fn weigh(&mut self) {
        let units = Units { sigma: &self.sigma, field_ut: self.field_unit };
        let rows = (&mut self.update.rows, &mut self.further);
        if self.evidence.step(rows, &self.globals, &self.candidates, &units) {
            return;
        }
        let mut x = [T::ZERO; E];
        for (column, mean) in self.evidence.taken.iter().zip(&self.evidence.mean) {
            if let Some(x) = usize::from(*column).checked_sub(NUISANCES).and_then(|e| x.get_mut(e)) {
                *x = *mean;
            }
        }
        self.candidates.take_out(&x, &mut self.globals, &mut self.node);
        self.candidates.note_steps(&self.evidence.claims, &self.evidence.tried);
        self.linearise();
        self.task = Task::Next;
    }

    fn average(&mut self) {
        self.averaging.start(&self.globals, &self.settings.widths, &mut self.update.rows);
        self.task = Task::Spreading(0);
    }

    /// Widens the gyro's covariance by an effect's: an unknown part of an effect that is taken out is unknown of the
    /// gyro.
    fn spread(&mut self, of: usize) {
        if of >= self.evidence.taken.len() {
            self.task = Task::Averaging;
            return;
        }
        let spread = self.candidates.spread(of, (&self.evidence.taken, &self.evidence.covariance), &self.globals);
        self.averaging.spread(&spread, &mut self.update.rows);
        self.task = Task::Spreading(of + 1);
    }

    fn widen(&mut self) {
        for (column, sigma) in self.sigma.iter().enumerate() {
            let variance = T::of(walk::variance_per_s(column, sigma.narrow(), &self.settings.noise)) * self.unwalked_s;
            self.candidates.widen(&self.globals, column, variance);
            self.globals.widen(column, variance);
        }
        self.unwalked_s = T::ZERO;
        self.task = Task::Walking(0);
    }

    fn walk(&mut self, column: usize) {
        self.updates = self.updates.wrapping_add(1);
        self.candidates.triangular(&mut self.globals, column);
        self.task = if column + 1 < GLOBALS { Task::Walking(column + 1) } else { Task::Next };
    }
}
