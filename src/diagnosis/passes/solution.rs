//! The solution so far, and how it is moved to the optimum of a model.

use super::*;

impl Diagnosis {
    /// The columns of a candidate; empty where there is no room for it.
    pub(super) fn columns_of(&self, subject: &Subject, index: usize) -> core::ops::Range<usize> {
        self.layout.columns_of(subject.library, index)
    }

    /// Parameters of a candidate in the solution so far, in SI units.
    pub(super) fn parameters(&self, subject: &Subject, index: usize) -> [f32; MAX_PARAMETERS] {
        let mut parameters = [0.0; MAX_PARAMETERS];
        let Some(effect) = subject.library.get(index) else { return parameters };
        let columns = self.columns_of(subject, index);
        for ((k, column), parameter) in each_parameter().zip(columns).zip(effect.parameters()) {
            parameters[k] = self.x_of(column) * parameter.usual;
        }
        parameters
    }

    /// The scores of each group.
    pub(super) fn groups(&self) -> &[[f32; COLUMNS]] {
        self.scores.as_chunks().0
    }

    /// The model so far, or all of it but one effect. What history added is not this window's to solve for, unless the bias has to move with
    /// it.
    pub(super) fn model(&self, subject: &Subject, without: Option<usize>) -> Model {
        let mut model = Model::new();
        let is_solved = |chosen: &&Chosen| {
            !chosen.by_history || !chosen.stays && Self::is_of_gyro(subject, usize::from(chosen.index))
        };
        let chosen = self.chosen.iter().filter(is_solved);
        let effects = chosen.map(|chosen| usize::from(chosen.index)).filter(|index| Some(*index) != without);
        let gyro = if self.p_is_held { P..GYRO } else { 0..GYRO };
        let columns = gyro.chain(effects.flat_map(|index| self.columns_of(subject, index)));
        let columns = columns.filter(|column| !self.is_left_out(*column));
        for column in columns {
            // No room is no column.
            let _ = model.push(column as u8);
        }
        model
    }

    /// P and c of the solution so far.
    pub(super) fn gyro(&self, subject: &Subject) -> (Matrix3<f32>, Vector3<f32>) {
        let scales = GyroScales::new(&subject.config.identification);
        let p = self.job.flown.p_matrix();
        let c = p * Vector3::from(self.job.flown.b_rad_s);
        (
            Matrix3::from_fn(|i, j| p[(i, j)] + scales.of_p(i, j) * self.x[3 * i + j]),
            Vector3::from_fn(|i, _| c[i] + scales.c_rad_s * self.x[9 + i]),
        )
    }

    /// Chosen effects that are too small, and parts of the others that are not seen to be there, leave the solution: what is taken out of the readings is the rest, and
    /// the bias has to fit to that.
    pub(super) fn leave_out_unseen(&mut self, subject: &Subject) {
        for slot in 0..self.chosen.len() {
            let Some(index) = self.chosen.get(slot).map(|chosen| usize::from(chosen.index)) else { return };
            let is_out = self.chosen.get(slot).is_some_and(|chosen| chosen.too_small || chosen.in_p);
            let seen = if is_out { [0.0; MAX_PARAMETERS] } else { self.seen_parts(subject, slot) };
            for (column, x) in self.columns_of(subject, index).zip(seen) {
                if x == 0.0 {
                    self.left_out |= 1_u64.checked_shl(column as u32).unwrap_or(0);
                    if let Some(x) = self.x.get_mut(column) {
                        *x = 0.0;
                    }
                }
            }
        }
    }

    /// Notes what the gyro's effects are while P is free: held, it may have them in.
    #[inline(never)]
    pub(super) fn note_free(&mut self, subject: &Subject) {
        for slot in 0..self.chosen.len() {
            let (free, free_size_rad) = (self.seen_parts(subject, slot), self.size_rad(subject, slot));
            let Some(chosen) = self.chosen.get_mut(slot) else { return };
            let index = usize::from(chosen.index);
            if Self::is_of_gyro(subject, index)
                && !Self::is_bias_step(subject, index)
                && !chosen.too_small
                && !chosen.by_history
            {
                (chosen.free, chosen.free_size_rad) = (free, free_size_rad);
            }
        }
    }

    fn is_left_out(&self, column: usize) -> bool {
        self.left_out.checked_shr(column as u32).unwrap_or(0) & 1 != 0
    }

    /// The solution so far of a column.
    pub(super) fn x_of(&self, column: usize) -> f32 {
        at(&self.x, column)
    }

    /// The bias from rests, if it is known to less than matters, and has not stepped since.
    #[inline(never)]
    pub(super) fn rest(&self) -> Option<&RestBias> {
        let rest = &self.job.rest;
        (self.step.until == 0 && rest.sigma_rad_s() < LEAST_DRIFT_RAD).then_some(rest)
    }

    /// Adds what rests say to the equations, once the model is final. A rate that is constant about the field only gravity shows, and over a test
    /// window hardly: an effect of the gyro and the bias would share it at will. Candidates are tested without it, as what the bias has done
    /// since is no effect. At rest P hardly matters.
    #[inline(never)]
    pub(super) fn add_rest(&mut self, subject: &Subject) {
        let Some(rest) = self.rest().filter(|_| self.is_final) else { return };
        let variance = square(rest.sigma_rad_s());
        let mut moment = rest.moment();
        moment.rate_rad_s = self.p * rest.rate - self.c;
        self.taken_out.correct_rate(subject.library, &mut moment);
        let left = -moment.rate_rad_s;
        let mut rows = NO_ROWS;
        let unit_rad_s = GyroScales::new(&subject.config.identification).c_rad_s;
        for (i, row) in rows.iter_mut().enumerate() {
            row[P + i] = -unit_rad_s;
        }
        self.layout.each_term(subject.library, &moment, &mut |sensor, at, term| {
            if sensor == Sensor::Gyro {
                put(&mut rows, at, &-term);
            }
        });
        let weight = huber(left.norm_squared() / variance) / variance;
        self.normal.add(&rows, self.layout.width(), weight);
        for (row, r) in rows.iter().zip(left.iter()) {
            // Which group it is in does not matter to their sum.
            self.scores.iter_mut().zip(row).for_each(|(sum, a)| *sum += weight * a * r);
        }
    }

    /// Moves the solution to the optimum of the model.
    pub(super) fn solve(&mut self, model: &Model) -> Option<()> {
        self.factor.of(&self.normal, &self.priors, model)?;
        let mut rhs = [0.0; MAX_COLUMNS];
        for (sum, &column) in rhs.iter_mut().zip(model) {
            let column = usize::from(column);
            // The prior pulls by how far it is off.
            let pull =
                self.priors.get(column).map_or(0.0, |prior| prior.information * (prior.mean - self.x_of(column)));
            *sum = self.groups().iter().fold(pull, |sum, scores| sum + at(scores, column));
        }
        self.factor.solve(&mut rhs);
        for (change, &column) in rhs.iter().zip(model) {
            if let Some(x) = self.x.get_mut(usize::from(column)) {
                *x += change;
            }
        }
        Some(())
    }
}
