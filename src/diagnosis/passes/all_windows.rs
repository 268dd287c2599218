//! What the windows so far show together.

use super::{selection::Tested, *};

impl Diagnosis {
    /// Keeps what this window showed for the next. A step of the bias says nothing about another one.
    pub(super) fn remember(&mut self, subject: &Subject, history: &mut History) {
        let mut p_values = self.tried.map(|tried| tried.p_value);
        for chosen in &self.chosen {
            if let Some(p_value) = p_values.get_mut(usize::from(chosen.index)) {
                *p_value = chosen.p_value;
            }
        }
        for (index, both) in p_values.iter_mut().zip(&mut self.worths).enumerate() {
            if Self::is_bias_step(subject, index) {
                (*both.0, *both.1) = (1.0, 0.0);
            }
        }
        history.remember(&p_values, &self.worths);
    }

    /// Begins to add this window's scores to those of the windows before.
    pub(super) fn begin_history(&mut self, history: &mut History) {
        let chosen = self.chosen.iter();
        history.begin(
            chosen.fold(self.banned, |mask, chosen| mask | 1_u32.checked_shl(u32::from(chosen.index)).unwrap_or(0)),
        );
    }

    /// Adds a candidate's scores, and keeps it if it shows most so far in all windows together.
    #[inline(never)]
    pub(super) fn tries_with_history(&mut self, subject: &Subject, index: usize, history: &mut History) -> Tested {
        if !self.is_open(index) {
            return Tested::Done;
        }
        if !self.trial.is_under_way {
            let model = self.model(subject, None);
            let columns = self.columns_of(subject, index);
            if self.find_scores(columns.clone(), &model).is_none() {
                return Tested::Done;
            }
            let Some(together) = history.with(&columns, &self.trial.scores) else { return Tested::Done };
            self.trial.scores = together;
            self.trial.start(columns.len());
            return Tested::Under;
        }
        let Some((twice_the_gain, p_value)) = self.trial.step() else { return Tested::Under };
        if !self.is_possible(subject, index) {
            return Tested::Done;
        }
        let windows = f32::from(history.windows());
        let evidence = 0.5 * twice_the_gain / windows;
        if let Some(tried) = self.tried.get_mut(index).filter(|tried| tried.p_value > p_value) {
            (tried.evidence, tried.p_value) = (evidence, p_value);
        }
        let worth = self.worth(subject, index, evidence);
        if self.leads(subject, index, p_value, worth) {
            let Trial { whitening, whitened, .. } = &self.trial;
            let sigma = whitening.sandwich(whitened).map(|x| x / windows);
            self.estimate = whitening.estimate(whitened).map(|x| x / windows);
            let found = Chosen { index: index as u8, evidence, p_value, sigma, by_history: true, ..Chosen::NONE };
            self.keep(found, worth);
        }
        Tested::Done
    }

    /// Adds the candidate that shows most in all windows together to the model.
    pub(super) fn add_by_history(&mut self, subject: &Subject) -> bool {
        let Some((found, _)) = self.best.pop() else { return false };
        if !self.is_open(usize::from(found.index)) {
            return false;
        }
        let columns = self.columns_of(subject, usize::from(found.index));
        let residual_before_rad = Self::shown_in(subject, found.index, self.residual);
        if self.chosen.push(Chosen { residual_before_rad, ..found }).is_err() {
            return false;
        }
        let estimate = self.estimate;
        self.x.get_mut(columns).unwrap_or_default().iter_mut().zip(estimate).for_each(|(x, found)| *x = found);
        true
    }
}
