//! What the passes gather from each instant and each test window.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs and threes.

use super::*;

impl Diagnosis {
    /// Whether a candidate changes the gyro's reading.
    pub(super) fn is_of_gyro(subject: &Subject, index: usize) -> bool {
        subject.library.get(index).is_some_and(|effect| effect.sensor() == Sensor::Gyro)
    }

    /// The scaled parameters of a chosen effect. Of the gyro's all of them, as what is seen is what they and the bias add up to; of the others', those
    /// that are not seen to be there are 0.
    pub(super) fn seen_parts(&self, subject: &Subject, slot: usize) -> [f32; MAX_PARAMETERS] {
        let mut parts = [0.0; MAX_PARAMETERS];
        let Some(chosen) = self.chosen.get(slot) else { return parts };
        let index = usize::from(chosen.index);
        let is_of_gyro = Self::is_of_gyro(subject, index);
        for (k, column) in each_parameter().zip(self.columns_of(subject, index)) {
            let x = self.x_of(column);
            parts[k] = if is_of_gyro || chosen.is_seen(k, x) { x } else { 0.0 };
        }
        parts
    }

    /// How much that of a chosen effect turns which is seen to be there, and the deviation of that, rad.
    pub(super) fn size_rad(&self, subject: &Subject, slot: usize) -> (f32, f32) {
        match self.chosen.get(slot) {
            Some(chosen) if Self::is_bias_step(subject, usize::from(chosen.index)) => self.step_size_rad(),
            Some(chosen) => chosen.size_rad(&self.seen_parts(subject, slot)),
            None => (0.0, 0.0),
        }
    }

    /// How much the chosen vector effects turn their vectors.
    pub(super) fn measure_turns(&mut self, subject: &Subject, moment: &Moment) {
        if moment.rate_rad_s.norm_squared() < square(subject.config.identification.max_bias_rad_s) {
            return;
        }
        for slot in 0..self.chosen.len() {
            let Some(index) = self.chosen.get(slot).map(|chosen| usize::from(chosen.index)) else { return };
            let Some(effect) = subject.library.get(index) else { continue };
            let x = self.seen_parts(subject, slot);
            let vector = match effect.sensor() {
                Sensor::Gyro => continue,
                Sensor::Accelerometer => moment.force_m_s2,
                Sensor::Magnetometer => moment.field_ut,
            };
            let norm = vector.norm_squared();
            let Some(chosen) = self.chosen.get_mut(slot).filter(|_| norm > 0.0) else { continue };
            let mut part = Vector3::zeros();
            let parameters = chosen.turned_by.iter_mut().zip(effect.parameters()).zip(&x);
            for (k, ((sum, parameter), x)) in parameters.enumerate() {
                let term = effect.term(k, moment) * parameter.usual;
                part += term * *x;
                *sum += term.norm_squared() / norm;
            }
            chosen.turned[0] += part.norm_squared() / norm;
            chosen.turned[1] += 1.0;
        }
    }

    #[inline(never)]
    pub(super) fn take_test(&mut self, subject: &Subject, test: &TestFacts, under_way: usize, noise_gain: f32) {
        let number = self.test as usize;
        self.test += 1;
        if !(test.counts[0] || test.counts[1]) || number >= MAX_TESTS {
            return;
        }
        let ordinal = self.usable;
        self.usable += 1;
        let width = self.layout.width();
        let group = (ordinal * GROUPS as u32).checked_div(self.usable_before).unwrap_or(0) as usize;
        let is_taken_out = self.taken_out_columns(subject);
        let force = test.force_scatter + square(FORCE_NOISE_M_S2);
        let field = test.field_noise_ut2 + square(FIELD_NOISE_UT);
        let thought = [noise_gain * force, noise_gain * field];
        for v in 0..2 {
            if !test.counts[v] {
                self.squares[number][v] = 0;
                continue;
            }
            let rows = self.columns.rows(under_way, v);
            let mut r = [0.0; 3];
            for ((r, row), rhs) in r.iter_mut().zip(rows).zip(test.rhs[v].iter()) {
                let row = row.iter().zip(&self.x).zip(&is_taken_out).take(width);
                *r = row.fold(*rhs, |r, ((a, x), taken_out)| if *taken_out { r } else { r - a * x });
            }
            let norm = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
            let z = norm / (thought[v] * self.scales[v]);
            self.squares[number][v] = halved(norm / thought[v]);
            let weight = huber(z) / (thought[v] * self.scales[v]);
            if !self.is_final {
                self.remainder.add(v, rows, &r, weight);
            }
            self.normal.add(rows, width, weight);
            RateErrors::new(self.factor.scratch()).add(number, rows, &r, weight);
            if let Some(scores) = self.scores.as_chunks_mut::<COLUMNS>().0.get_mut(group) {
                for (row, r) in rows.iter().zip(&r) {
                    scores.iter_mut().zip(row).take(width).for_each(|(sum, a)| *sum += weight * a * r);
                }
            }
            if test.norms[v] > 0.0 {
                self.residual_sums[v][0] += norm / square(test.norms[v]);
                self.residual_sums[v][1] += 1.0;
            }
            if v == 1 && test.field_noise_ut2 > 0.0 {
                self.nis_sums[0] += norm / (3.0 * noise_gain * test.field_noise_ut2);
                self.nis_sums[1] += 1.0;
            }
        }
        if !self.is_final {
            self.remainder.end_test(number);
        }
        self.measure_drifts(subject, test, under_way);
    }

    /// Columns of what the equations are about already: the gyro's parameters, and the effects whose part is out of the readings.
    pub(super) fn taken_out_columns(&self, subject: &Subject) -> [bool; COLUMNS] {
        let mut is_taken_out: [bool; COLUMNS] = core::array::from_fn(|column| column < GYRO);
        for found in self.taken_out.iter() {
            let index = usize::from(found.index);
            if subject.library.get(index).is_some_and(|effect| effect.sensor() != Sensor::Gyro) {
                let columns = is_taken_out.get_mut(self.columns_of(subject, index)).unwrap_or_default();
                columns.fill(true);
            }
        }
        is_taken_out
    }

    /// How much the chosen gyro effects turn the body over a test window, whose weights add up to a second.
    pub(super) fn measure_drifts(&mut self, subject: &Subject, test: &TestFacts, under_way: usize) {
        for slot in 0..self.chosen.len() {
            let Some(index) = self.chosen.get(slot).map(|chosen| usize::from(chosen.index)) else { return };
            if !Self::is_of_gyro(subject, index) {
                continue;
            }
            let columns = self.columns_of(subject, index);
            let x = self.seen_parts(subject, slot);
            let mut largest = 0.0;
            let mut largest_by = [0.0; MAX_PARAMETERS];
            for v in 0..2 {
                if !(test.counts[v] && test.norms[v] > 0.0) {
                    continue;
                }
                let sum = self.columns.rows(under_way, v).iter().fold(0.0, |sum, row| {
                    let parts = columns.clone().zip(&x);
                    sum + square(parts.fold(0.0, |turned, (column, x)| turned + at(row, column) * x))
                });
                let turned = sum / square(test.norms[v]);
                if turned > largest {
                    largest = turned;
                    for (by, column) in largest_by.iter_mut().zip(columns.clone()) {
                        let rows = self.columns.rows(under_way, v).iter();
                        *by = rows.fold(0.0, |sum, row| sum + square(at(row, column))) / square(test.norms[v]);
                    }
                }
            }
            if let Some(chosen) = self.chosen.get_mut(slot) {
                chosen.turned[0] += largest;
                chosen.turned[1] += 1.0;
                chosen.turned_by.iter_mut().zip(largest_by).for_each(|(sum, by)| *sum += by);
            }
        }
    }

    /// Scales of the rows' variances from the median residual: what every other test window is under. Whether they are much the same
    /// as before.
    pub(super) fn rescale(&mut self) -> bool {
        let mut has_settled = true;
        for v in 0..2 {
            let mut values = [0.0; MAX_TESTS];
            let squares =
                self.squares.iter().take(self.test as usize).map(|squares| whole(squares.get(v).copied().unwrap_or(0)));
            let mut count = 0;
            for (value, square) in values.iter_mut().zip(squares.filter(|square| *square > 0.0)) {
                *value = square;
                count += 1;
            }
            let median = quantile(values.get_mut(..count).unwrap_or_default(), 0.5) / MEDIAN_SQUARE;
            if median > 0.0 && median.is_finite() {
                has_settled &= median < SETTLED * self.scales[v] && self.scales[v] < SETTLED * median;
                self.scales[v] = median;
            }
        }
        has_settled
    }
}
