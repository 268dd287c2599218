//! Which candidate shows, which does not, and whether P does.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs and threes.

use super::*;

/// Whether a candidate has been looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tested {
    Done,
    /// Its test is under way.
    Under,
}

impl Diagnosis {
    /// One piece of testing some columns beside a model; twice the gain and the p-value when it is done. `Err` where they show nothing or
    /// are one with the model.
    fn test_columns(&mut self, columns: core::ops::Range<usize>, model: &Model) -> Result<Option<(f32, f32)>, ()> {
        if self.trial.is_under_way {
            return Ok(self.trial.step());
        }
        let dimension = columns.len();
        self.find_scores(columns, model).ok_or(())?;
        self.trial.start(dimension);
        Ok(None)
    }

    /// Finds what some columns show beside a model, for the trial; `None` where that is nothing.
    #[inline(never)]
    pub(super) fn find_scores(&mut self, columns: core::ops::Range<usize>, model: &Model) -> Option<()> {
        let dimension = columns.len();
        if dimension == 0 || model.len() + dimension > MAX_COLUMNS {
            return None;
        }
        self.factor.of(&self.normal, &self.priors, model)?;
        // B = N00^-1 N0c, column by column.
        let mut gains = [[0.0_f32; MAX_COLUMNS]; MAX_PARAMETERS];
        for (gain, column) in gains.iter_mut().zip(columns.clone()) {
            for (value, &row) in gain.iter_mut().zip(model) {
                *value = self.normal.get(usize::from(row), column);
            }
            self.factor.solve(gain);
        }
        // S = Ncc - Nc0 B.
        let mut information = [[0.0_f32; MAX_PARAMETERS]; MAX_PARAMETERS];
        for (row_of, column) in information.iter_mut().zip(columns.clone()) {
            for ((element, other), gain) in row_of.iter_mut().zip(columns.clone()).zip(&gains) {
                let rows = model.iter().zip(gain);
                let explained =
                    rows.fold(0.0, |sum, (&row, gain)| sum + self.normal.get(usize::from(row), column) * gain);
                *element = self.normal.get(column, other) - explained;
            }
        }
        self.trial.whitening = Whitening::new(&information, dimension, |i| {
            // What is left beside the model has to be more than rounding, too.
            let own = 1e-4 * self.normal.get(columns.start + i, columns.start + i);
            if own > OBSERVED { own } else { OBSERVED }
        })?;
        // A candidate that is in the solution has taken its part out of the residual: put back, evenly, S x of it.
        let own = information.map(|row| {
            let x = columns.clone().zip(&row);
            x.fold(0.0, |sum, (column, s)| sum + s * self.x_of(column)) / GROUPS as f32
        });
        let mut scores = [[0.0; MAX_PARAMETERS]; GROUPS];
        for (score, group) in scores.iter_mut().zip(self.groups()) {
            for (((score, column), gain), own) in score.iter_mut().zip(columns.clone()).zip(&gains).zip(&own) {
                let rows = model.iter().zip(gain);
                let explained = rows.fold(0.0, |sum, (&row, gain)| sum + at(group, usize::from(row)) * gain);
                *score = at(group, column) - explained + own;
            }
        }
        self.trial.scores = scores;
        Some(())
    }

    /// Whether P, after all effects, explains most of what is left: then it is about to be identified, and stays free. Else what it would
    /// take is the effects' own: which of two sensors' axes are turned cannot be told, and P flies as it is. A reference's axes are not.
    /// `None`: there is more to do.
    #[inline(never)]
    pub(super) fn p_is_wrong(&mut self, subject: &Subject) -> Option<bool> {
        if subject.config.identification.vectors_from_reference {
            return Some(true);
        }
        let mut others = Model::new();
        for &column in self.model(subject, None).iter().filter(|column| usize::from(**column) >= P) {
            // As much room as the model has.
            let _ = others.push(column);
        }
        let Ok(found) = self.test_columns(0..P, &others) else { return Some(false) };
        let (gain, _) = found?;
        // What is left with P free, in the same units: three components of two vectors.
        let left = 6.0 * self.usable as f32;
        Some(gain > LEAST_EXPLAINED * (gain + left))
    }

    /// Whether a candidate is neither in the model nor out of question.
    pub(super) fn is_open(&self, index: usize) -> bool {
        let is_chosen = self.chosen.iter().any(|chosen| usize::from(chosen.index) == index);
        !is_chosen && self.banned.checked_shr(index as u32).unwrap_or(0) & 1 == 0
    }

    /// Notes what each candidate is worth that is not in the model, now that one of them is to be.
    pub(super) fn note_worths(&mut self, subject: &Subject) {
        for index in 0..MAX_CANDIDATES {
            if !self.is_open(index) {
                continue;
            }
            let evidence = self.tried.get(index).map_or(0.0, |tried| tried.evidence);
            let worth = self.worth(subject, index, evidence);
            if let Some(noted) = self.worths.get_mut(index) {
                *noted = if worth > 0.0 { worth } else { 0.0 };
            }
        }
    }

    /// Drops a chosen effect that, as far as it is seen to be there, is not beyond its own deviation, or that, with the others there, no
    /// longer shows; notes if it is too small to matter. `None`: there is more to do.
    #[inline(never)]
    pub(super) fn drops(&mut self, subject: &Subject, slot: usize) -> Option<bool> {
        let chosen = self.chosen.get(slot).filter(|chosen| !chosen.in_p);
        let Some(&Chosen { index, by_history, free_size_rad, .. }) = chosen else { return Some(false) };
        let index = usize::from(index);
        let model = self.model(subject, Some(index));
        let tested = self.test_columns(self.columns_of(subject, index), &model);
        if let Ok(None) = tested {
            return None;
        }
        let is_step = Self::is_bias_step(subject, index);
        // With P free: held, its own errors would not count. What flies is in the deviations of vectors' effects by the end.
        let shown_by_itself = !by_history && !self.p_is_held;
        let deviates = shown_by_itself && (!self.is_final || Self::is_of_gyro(subject, index));
        let shows = is_step && self.shown_step.p_value <= FALSE_ALARMS
            || tested.ok().flatten().is_some_and(|(_, p_value)| {
                if let Some(chosen) = self.chosen.get_mut(slot).filter(|_| deviates) {
                    chosen.sigma = self.trial.whitening.sandwich(&self.trial.whitened);
                }
                if let Some(tried) = self.tried.get_mut(index).filter(|_| shown_by_itself) {
                    tried.p_value = p_value;
                }
                by_history || p_value <= FALSE_ALARMS
            });
        let least_rad = if Self::is_of_gyro(subject, index) { LEAST_DRIFT_RAD } else { LEAST_TURN_RAD };
        let (size_rad, sigma_rad) = self.size_rad(subject, slot);
        // What flies already may turn little for once.
        let flies = subject.stream.effects().iter().any(|flown| usize::from(flown.index) == index);
        let too_small = size_rad < least_rad && !flies;
        let drops = !shows || size_rad < SIGNIFICANT * sigma_rad;
        let in_p = free_size_rad.0 > 0.0 && (drops || too_small);
        if let (Some(chosen), Some(tried)) = (self.chosen.get_mut(slot), self.tried.get_mut(index)) {
            chosen.in_p = in_p;
            chosen.too_small = too_small && !in_p;
            tried.too_small = chosen.too_small;
        }
        if in_p {
            self.leave_out_unseen(subject);
            return Some(true);
        }
        if drops {
            self.banned |= 1_u32.checked_shl(index as u32).unwrap_or(0);
            let columns = self.columns_of(subject, index);
            self.x.get_mut(columns).unwrap_or_default().fill(0.0);
            self.chosen.retain(|chosen| usize::from(chosen.index) != index);
            if is_step {
                self.step = BiasStep::NONE;
            }
        }
        Some(drops)
    }

    /// Tests a candidate, and keeps it if it shows most so far, of those that show beyond chance.
    #[inline(never)]
    pub(super) fn tries(&mut self, subject: &Subject, index: usize, history: &History) -> Tested {
        if !self.is_open(index) || self.chosen.is_full() {
            return Tested::Done;
        }
        let (evidence, p_value) = if Self::is_bias_step(subject, index) {
            (self.shown_step.gain, self.shown_step.p_value)
        } else {
            let model = self.model(subject, None);
            match self.test_columns(self.columns_of(subject, index), &model) {
                Ok(Some(_)) if !self.is_possible(subject, index) => (0.0, 1.0),
                Ok(Some((twice_the_gain, p_value))) => (0.5 * twice_the_gain, p_value),
                Ok(None) => return Tested::Under,
                Err(()) => return Tested::Done,
            }
        };
        if let Some(tried) = self.tried.get_mut(index) {
            *tried = Tried { evidence, p_value, ..Tried::default() };
        }
        let together = history.chance_together(index, p_value);
        let worth = self.worth(subject, index, evidence) + history.worth(index);
        if self.leads(subject, index, if together < p_value { together } else { p_value }, worth) {
            self.keep(Chosen { index: index as u8, evidence, p_value, ..Chosen::NONE }, worth);
        }
        Tested::Done
    }

    /// Whether what the trial shows is of a sign that the effect can have: a magnetometer that leads is a gyro that lags.
    pub(super) fn is_possible(&self, subject: &Subject, index: usize) -> bool {
        let estimate = self.trial.whitening.estimate(&self.trial.whitened);
        let parameters = subject.library.get(index).map_or(&[][..], |effect| effect.parameters());
        parameters.iter().zip(&estimate).all(|(parameter, x)| parameter.signed || *x >= 0.0)
    }

    /// Keeps a candidate as the best so far.
    pub(super) fn keep(&mut self, found: Chosen, worth: f32) {
        self.best.clear();
        // Just emptied.
        let _ = self.best.push((found, worth));
    }

    /// Whether a candidate shows beyond chance, and more than the best so far.
    pub(super) fn leads(&self, subject: &Subject, index: usize, chance: f32, worth: f32) -> bool {
        // A name has to be clearly the likelier.
        let lead = if Self::is_outside(subject, index) { -LEAST_LEAD } else { LEAST_LEAD };
        let least = self.best.first().map_or(LEAST_WORTH, |(_, most)| most + lead);
        chance <= FALSE_ALARMS / subject.library.len().min(MAX_CANDIDATES) as f32 && worth > least
    }

    /// Evidence of a candidate less what its parameters cost (Schwarz, Annals of Statistics 6 (1978) 461).
    pub(super) fn worth(&self, subject: &Subject, index: usize, evidence: f32) -> f32 {
        let parameters = subject.library.get(index).map_or(0, |effect| effect.parameters().len()) as f32;
        evidence - 0.5 * parameters * libm::logf(self.usable as f32)
    }
}
