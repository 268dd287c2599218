//! Which candidate shows, which does not, and whether P does.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs and threes.

use super::*;
use crate::identification::LEAST_EXPLAINED;

/// What a candidate shows beside the model.
pub(super) struct Effective {
    scores: Scores,
    whitening: Whitening,
}

impl Diagnosis {
    /// A candidate's scores, group by group, cleared of what the model explains, and the information that it has beside the model. `None`
    /// where it shows nothing or is one with the model.
    pub(super) fn effective_scores(&mut self, subject: &Subject, index: usize, model: &Model) -> Option<Effective> {
        self.effective_scores_of(self.columns_of(subject, index), model)
    }

    /// The same of some columns.
    pub(super) fn effective_scores_of(&mut self, columns: core::ops::Range<usize>, model: &Model) -> Option<Effective> {
        let dimension = columns.len();
        if dimension == 0 || model.len() + dimension > MAX_COLUMNS {
            return None;
        }
        self.factor.of(&self.normal, model)?;
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
        let whitening = Whitening::new(&information, dimension, |i| {
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
        Some(Effective { scores, whitening })
    }

    /// Whether P, after all effects, explains most of what is left: then it is about to be identified, and stays free. Else what it would
    /// take is the effects' own: which of two sensors' axes are turned cannot be told, and P flies as it is.
    pub(super) fn p_is_wrong(&mut self, model: &Model) -> bool {
        let mut others = Model::new();
        for &column in model.iter().filter(|column| usize::from(**column) >= P) {
            // As much room as the model has.
            let _ = others.push(column);
        }
        let Some(Effective { scores, whitening }) = self.effective_scores_of(0..P, &others) else { return false };
        let (gain, _) = sign_flip(&whitening.whitened(&scores));
        // What is left with P free, in the same units: three components of two vectors.
        let left = 6.0 * self.usable as f32;
        gain > LEAST_EXPLAINED * (gain + left)
    }

    /// Adds this window's scores to those of the windows before, and the candidate that shows most in all of them together to the model.
    pub(super) fn add_by_history(&mut self, subject: &Subject, model: &Model, history: &mut History) -> bool {
        let chosen = self.chosen.iter();
        history.begin(
            chosen.fold(self.banned, |mask, chosen| mask | 1_u32.checked_shl(u32::from(chosen.index)).unwrap_or(0)),
        );
        let candidates = subject.library.len().min(MAX_CANDIDATES);
        let limit = FALSE_ALARMS / candidates as f32;
        let mut best: Option<(Chosen, [f32; MAX_PARAMETERS], f32)> = None;
        for index in 0..candidates {
            let taken = self.chosen.iter().any(|c| usize::from(c.index) == index);
            if taken || self.banned.checked_shr(index as u32).unwrap_or(0) & 1 != 0 {
                continue;
            }
            let Some(Effective { scores, whitening }) = self.effective_scores(subject, index, model) else { continue };
            let columns = self.columns_of(subject, index);
            let Some(together) = history.with(&columns, &scores) else { continue };
            let whitened = whitening.whitened(&together);
            let windows = f32::from(history.windows());
            let (twice_the_gain, p_value) = sign_flip(&whitened);
            let evidence = 0.5 * twice_the_gain / windows;
            let worth = self.worth(subject, index, evidence);
            if let Some(tried) = self.tried.get_mut(index).filter(|tried| tried.p_value > p_value) {
                (tried.evidence, tried.p_value) = (evidence, p_value);
            }
            if p_value <= limit && worth > best.map_or(LEAST_WORTH, |(.., most)| most + LEAST_LEAD) {
                let estimate = whitening.estimate(&whitened).map(|x| x / windows);
                let sigma = whitening.sandwich(&whitened).map(|x| x / windows);
                let found = Chosen { index: index as u8, evidence, p_value, sigma, by_history: true, ..Chosen::NONE };
                best = Some((found, estimate, worth));
            }
        }
        let Some((found, estimate, _)) = best else { return false };
        let columns = self.columns_of(subject, usize::from(found.index));
        let residual_before_rad = Self::shown_in(subject, found.index, self.residual);
        if self.chosen.push(Chosen { residual_before_rad, ..found }).is_err() {
            return false;
        }
        self.x.get_mut(columns).unwrap_or_default().iter_mut().zip(estimate).for_each(|(x, found)| *x = found);
        true
    }

    /// Drops a chosen effect that, as far as it is seen to be there, is not beyond its own deviation, or that, with the others there, no
    /// longer shows; notes which are too small to matter.
    pub(super) fn drop_one(&mut self, subject: &Subject) -> bool {
        for slot in 0..self.chosen.len() {
            let Some(&Chosen { index, by_history, .. }) = self.chosen.get(slot) else { break };
            let index = usize::from(index);
            let model = self.model(subject, Some(index));
            let effective = self.effective_scores(subject, index, &model);
            let is_step = Self::is_bias_step(subject, index);
            let shows = is_step && self.shown_step.p_value <= FALSE_ALARMS
                || effective.is_some_and(|effective| {
                    let scores = effective.whitening.whitened(&effective.scores);
                    // With P free: held, its own errors would not count.
                    if let Some(chosen) = self.chosen.get_mut(slot).filter(|_| !by_history && !self.p_is_held) {
                        chosen.sigma = effective.whitening.sandwich(&scores);
                    }
                    by_history || sign_flip(&scores).1 <= FALSE_ALARMS
                });
            let is_gyro = subject.library.get(index).is_some_and(|effect| effect.sensor() == Sensor::Gyro);
            let least_rad = if is_gyro { LEAST_DRIFT_RAD } else { LEAST_TURN_RAD };
            let (size_rad, sigma_rad) = self.size_rad(subject, slot);
            let too_small = size_rad < least_rad;
            if let (Some(chosen), Some(tried)) = (self.chosen.get_mut(slot), self.tried.get_mut(index)) {
                chosen.too_small = too_small;
                tried.too_small = too_small;
            }
            if !shows || size_rad < SIGNIFICANT * sigma_rad {
                self.banned |= 1_u32.checked_shl(index as u32).unwrap_or(0);
                let columns = self.columns_of(subject, index);
                self.x.get_mut(columns).unwrap_or_default().fill(0.0);
                self.chosen.retain(|chosen| usize::from(chosen.index) != index);
                if is_step {
                    self.step = BiasStep::NONE;
                }
                return true;
            }
        }
        false
    }

    /// How much that of a chosen effect turns which is seen to be there, and the deviation of that, rad.
    pub(super) fn size_rad(&self, subject: &Subject, slot: usize) -> (f32, f32) {
        match self.chosen.get(slot) {
            Some(chosen) if Self::is_bias_step(subject, usize::from(chosen.index)) => self.step_size_rad(),
            Some(chosen) => chosen.size_rad(&self.seen_parts(subject, slot)),
            None => (0.0, 0.0),
        }
    }

    /// The candidate that shows most, of those that show beyond chance.
    pub(super) fn best_candidate(&mut self, subject: &Subject, model: &Model) -> Option<(usize, f32, f32)> {
        let candidates = subject.library.len().min(MAX_CANDIDATES);
        let limit = FALSE_ALARMS / candidates as f32;
        let mut best: Option<(usize, f32, f32, f32)> = None;
        for index in 0..candidates {
            let chosen = self.chosen.iter().any(|c| usize::from(c.index) == index);
            if chosen || self.banned.checked_shr(index as u32).unwrap_or(0) & 1 != 0 {
                continue;
            }
            let (evidence, p_value) = if Self::is_bias_step(subject, index) {
                (self.shown_step.gain, self.shown_step.p_value)
            } else {
                let Some(Effective { scores, whitening }) = self.effective_scores(subject, index, model) else {
                    continue;
                };
                let (twice_the_gain, p_value) = sign_flip(&whitening.whitened(&scores));
                (0.5 * twice_the_gain, p_value)
            };
            if let Some(tried) = self.tried.get_mut(index) {
                *tried = Tried { evidence, p_value, too_small: false };
            }
            if p_value <= limit
                && self.worth(subject, index, evidence) > best.map_or(LEAST_WORTH, |(.., most)| most + LEAST_LEAD)
            {
                best = Some((index, evidence, p_value, self.worth(subject, index, evidence)));
            }
        }
        best.map(|(index, evidence, p_value, _)| (index, evidence, p_value))
    }

    /// Evidence of a candidate less what its parameters cost (Schwarz, Annals of Statistics 6 (1978) 461).
    pub(super) fn worth(&self, subject: &Subject, index: usize, evidence: f32) -> f32 {
        let parameters = subject.library.get(index).map_or(0, |effect| effect.parameters().len()) as f32;
        evidence - 0.5 * parameters * libm::logf(self.usable as f32)
    }
}
