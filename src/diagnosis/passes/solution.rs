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
        for ((value, column), parameter) in parameters.iter_mut().zip(columns).zip(effect.parameters()) {
            *value = self.x_of(column) * parameter.usual;
        }
        parameters
    }

    /// The scores of each group.
    pub(super) fn groups(&self) -> &[[f32; COLUMNS]] {
        self.scores.as_chunks().0
    }

    /// The model so far, or all of it but one effect. What history added is not this window's to solve for.
    pub(super) fn model(&self, subject: &Subject, without: Option<usize>) -> Model {
        let mut model = Model::new();
        let chosen = self.chosen.iter().filter(|chosen| !chosen.by_history);
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
            let too_small = self.chosen.get(slot).is_some_and(|chosen| chosen.too_small);
            let seen = if too_small { [0.0; MAX_PARAMETERS] } else { self.seen_parts(subject, slot) };
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

    fn is_left_out(&self, column: usize) -> bool {
        self.left_out.checked_shr(column as u32).unwrap_or(0) & 1 != 0
    }

    /// The solution so far of a column.
    pub(super) fn x_of(&self, column: usize) -> f32 {
        at(&self.x, column)
    }

    /// Moves the solution to the optimum of the model.
    pub(super) fn solve(&mut self, model: &Model) -> Option<()> {
        self.factor.of(&self.normal, model)?;
        let mut rhs = [0.0; MAX_COLUMNS];
        for (sum, &column) in rhs.iter_mut().zip(model) {
            let column = usize::from(column);
            // The prior of deviation 1 about zero pulls with the value itself.
            let pull = -self.x_of(column);
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
