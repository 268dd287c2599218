//! End of a node: its increments become a rest to start from, a part of an alignment, or the rows of an update.

use super::{
    Estimator, Kind, Task,
    columns::{HARD_IRON, NUISANCES},
    disagreement::{Disagreement, Disagreements},
    gate::attitude_variance,
    preintegration::GYRO,
    reading::{Agreement, Readings, Taken},
    real::{Real, norm},
};

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Not inlined: its calls are counted (`cargo mwd bench --target`), as are those of elimination and absorption.
    #[inline(never)]
    pub(super) fn end_node(&mut self) {
        let seconds = self.pre.seconds;
        self.kind = if self.rests.judge(&self.pre, &self.settings) { Kind::Rest } else { Kind::Moving };
        if self.kind == Kind::Rest && !self.course.has_begun {
            self.shares.unread.add(T::ZERO, seconds);
            self.start_at_rest();
            return;
        }
        if !self.course.is_aligned {
            self.shares.unread.add(T::ZERO, seconds);
            self.course.disagreements.gyro.passed(seconds);
            self.align();
            return;
        }
        let taken = Taken {
            pre: &self.pre,
            parameters: &self.parameters,
            globals: &self.globals,
            settings: &self.settings,
            field_unit: self.course.field_unit,
            sigma: &self.prior.sigma,
            unknown: self.unknown_rotation(),
            kind: self.kind,
        };
        let attitude = self.node.attitude;
        let agreement = self.update.assemble(&mut self.node, &taken);
        if agreement.field == Readings::Used && self.settings.noise.field_is_even {
            self.course.pointing.add(&self.node.linear_at, attitude_variance(&self.node, &self.globals));
        }
        self.candidates.fill(&mut self.further, &self.update.rows, &self.node.linear_at, &self.pre, self.kind);
        if agreement.field == Readings::Contradicted {
            self.remainder.contradict();
        }
        if let Some(innovation) = agreement.innovation.filter(|_| self.kind == Kind::Moving) {
            let turn = self.node.field.cross(&innovation) / norm(&self.node.field);
            let both = [attitude.transpose() * turn, innovation];
            self.remainder.add(seconds.narrow(), both.map(|v| v.map(|x| x.narrow())));
        }
        if self.kind == Kind::Moving {
            self.shares.turned.add(if agreement.is_turned { T::ONE } else { T::ZERO }, seconds);
        }
        if agreement.is_turned {
            self.shares.unread.add(T::ONE, seconds);
            if self.course.disagreements.gyro.contradicted(seconds) {
                // The gyro is another than the one that was learnt: the filter begins anew.
                self.begin();
                return;
            }
            self.gap(T::ZERO);
            return;
        }
        self.course.disagreements.gyro.agreed(seconds);
        self.shares.unread.add(T::ZERO, seconds);
        if self.is_contradicted_for_good(&agreement) {
            return;
        }
        if self.kind == Kind::Moving {
            self.course.motion_s += seconds;
            let fieldless = if agreement.field == Readings::Used { T::ZERO } else { T::ONE };
            self.shares.fieldless.add(fieldless, seconds);
        }
        self.course.unwalked_s += seconds;
        self.task = Task::Eliminating;
    }

    /// Forgets estimates that have contradicted the readings of field or force for too long to be right: the
    /// attitude, and for the field the earth's and the hard iron, which a shock may have changed.
    fn is_contradicted_for_good(&mut self, agreement: &Agreement<T>) -> bool {
        let seconds = self.pre.seconds;
        let is_for_good = |readings, of: &mut Disagreement<T>| match readings {
            Readings::Contradicted => of.contradicted(seconds),
            Readings::Used | Readings::Missing => {
                *of = Disagreement::zero();
                false
            }
        };
        let Disagreements { field, force, .. } = &mut self.course.disagreements;
        let by_field = is_for_good(agreement.field, field);
        let by_force = is_for_good(agreement.force, force);
        if by_field {
            self.node.has_field = false;
            self.node.referred = 0;
            for column in HARD_IRON.columns() {
                self.candidates.widen(&mut self.globals, column, T::ONE);
            }
            self.task = Task::Walking(0);
        }
        if by_field || by_force {
            self.gap(T::ZERO);
        }
        by_field || by_force
    }

    /// Variance of the node's rotation by the uncertainty of bias and P, rad^2.
    pub(super) fn unknown_rotation(&self) -> T {
        let sigma = self.prior.sigma.iter().skip(NUISANCES);
        let mut by = [[T::ZERO; GYRO]; 3];
        for ((k, of), sigma) in self.pre.by_gyro.iter().enumerate().zip(sigma) {
            for (by, of) in by.iter_mut().zip(of.iter()) {
                if let Some(slot) = by.get_mut(k) {
                    *slot = *of * *sigma;
                }
            }
        }
        by.iter().fold(T::ZERO, |sum, by| sum + self.globals.variance(by))
    }

    /// Axes of the body that have not turned, in a drill string: there the earth's field is the same over the whole
    /// path, and only turns of an axis or a declared field tell a constant field along it from the earth's.
    pub(super) fn unturned(&self) -> [bool; 3] {
        if self.settings.noise.field_is_even { self.course.pointing.hides() } else { [false; 3] }
    }

    /// Begins a node.
    pub(super) fn start_node(&mut self) {
        self.pre.start();
        self.candidates.start_node();
        self.remainder.start_node();
    }

    /// Starts at a rest before anything else: its mean rate is the first bias, its mean force gives the attitude.
    fn start_at_rest(&mut self) {
        self.bias = self.rests.rate - self.pre.mean_taken_out();
        self.linearise();
        if self.pre.forces > 0 {
            self.node.start(&self.pre.forces_read, &self.settings.noise);
            (self.course.is_aligned, self.course.has_begun) = (true, true);
        }
        self.course.gap_s = T::ZERO;
        self.start_node();
    }

    /// Adds a node to an alignment: at a start in motion, or after a gap.
    fn align(&mut self) {
        let is_enough = self.course.alignment.add(&self.pre, self.course.has_begun);
        self.start_node();
        if !is_enough {
            return;
        }
        let [force, field] = self.course.alignment.vectors();
        if self.course.has_begun {
            let kept = self.node.realign(&force, &field, self.course.gap_s, &self.settings.noise);
            self.candidates.forget_node(kept.unwrap_or(T::ZERO));
            if kept.is_none() {
                self.course.pointing.turn_anew();
            }
        } else {
            self.node.start(&force, &self.settings.noise);
        }
        (self.course.is_aligned, self.course.has_begun) = (true, true);
        self.course.gap_s = T::ZERO;
    }

    /// Notes seconds in which the rotation of the probe was unknown; the attitude is then aligned anew.
    pub(super) fn gap(&mut self, seconds: T) {
        self.start_node();
        self.rests.interrupt();
        self.course.neighbours.forget_before();
        self.course.is_aligned = false;
        self.course.alignment.start();
        self.course.gap_s += seconds;
    }
}
