//! What follows from a pass: the solution moves, an effect is dropped or added, or there is no more to find.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs.

use super::*;

impl Diagnosis {
    /// Ends a pass; whether another is needed.
    #[inline(never)]
    pub(super) fn end_pass(&mut self, subject: &Subject, history: &mut History) -> bool {
        if self.usable < LEAST_PER_GROUP * GROUPS as u32 {
            return false;
        }
        // The first residuals are those of the errors that are looked for.
        let is_stable = self.pass > 0 && self.rescale();
        let is_stable = self.find_step(subject) && is_stable;
        // The solution that made these residuals comes from the pass before: it has settled when the scales had by then.
        let has_settled = is_stable && self.was_stable;
        self.was_stable = is_stable;
        let rms = self.residual_sums.map(|[sum, count]| libm::sqrtf(if count > 0.0 { sum / count } else { 0.0 }));
        self.residual = rms;
        let [sum, count] = self.nis_sums;
        self.nis = if count > 0.0 { sum / count } else { 0.0 };
        let model = self.model(subject, None);
        self.pass += 1;
        self.since_change += 1;
        let may_go_on = self.pass < MOST_PASSES;
        if !has_settled && self.since_change < PATIENCE && may_go_on {
            return self.solve(&model).is_some();
        }
        self.tested = true;
        if self.residual_before_rad.is_none() {
            self.residual_before_rad = Some(rms);
            self.nis_before = self.nis;
        }
        if let Some(last) = self.chosen.last_mut() {
            last.residual_after_rad = Self::shown_in(subject, last.index, rms);
        }
        if (has_settled || self.is_final) && self.drop_one(subject) {
            return may_go_on && self.changed(subject);
        }
        if self.is_final || !may_go_on {
            return false;
        }
        if !self.chosen.is_full()
            && let Some((index, evidence, p_value)) = self.best_candidate(subject, &model)
        {
            let residual_before_rad = Self::shown_in(subject, index as u8, rms);
            // There is room.
            let _ =
                self.chosen.push(Chosen { index: index as u8, evidence, p_value, residual_before_rad, ..Chosen::NONE });
            if Self::is_bias_step(subject, index) {
                self.step = self.shown_step;
            }
            return self.changed(subject);
        }
        if !has_settled {
            return self.solve(&model).is_some();
        }
        // Nothing more shows in this window by itself. What is left while P is free is what the verdict is about: what P itself lacks is the
        // identification's.
        self.is_final = true;
        self.leave_out_unseen(subject);
        self.left = (self.nis, rms[1]);
        let p_is_wrong = self.p_is_wrong(&model);
        let added = self.add_by_history(subject, &model, history);
        if !p_is_wrong {
            self.p_is_held = true;
            self.x.iter_mut().take(P).for_each(|x| *x = 0.0);
        }
        // More passes, to see what is left with P as it flies, what was added and what is not seen left out.
        (added || !p_is_wrong || !self.chosen.is_empty()) && self.changed(subject)
    }

    /// The model has been changed: whether it can be solved.
    pub(super) fn changed(&mut self, subject: &Subject) -> bool {
        self.since_change = 0;
        let model = self.model(subject, None);
        self.solve(&model).is_some()
    }
}
