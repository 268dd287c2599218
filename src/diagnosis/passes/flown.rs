//! Effects that fly already.

use super::*;

impl Diagnosis {
    /// Lets an effect stay as it flies that this window does not show by itself, or not enough of, if it explains the window better than nothing
    /// does: held out, since it was learnt from others.
    #[inline(never)]
    pub(super) fn keep_flown(&mut self, subject: &Subject, flown: &FoundEffect) {
        let index = usize::from(flown.index);
        let Some(effect) = subject.library.get(index) else { return };
        let mut found = self.chosen.iter().filter(|chosen| !chosen.too_small && self.is_whole(subject, chosen));
        if found.any(|chosen| chosen.index == flown.index) {
            return;
        }
        let columns = self.columns_of(subject, index);
        if self.find_scores(columns.clone(), &self.model(subject, Some(index))).is_none() {
            return;
        }
        let scaled = |values: &[f32; MAX_PARAMETERS]| {
            let mut scaled = [0.0; MAX_PARAMETERS];
            let values = values.iter().zip(effect.parameters());
            scaled.iter_mut().zip(values).for_each(|(x, (value, parameter))| *x = value / parameter.usual);
            scaled
        };
        let x = scaled(&flown.parameters);
        let whitened = self.trial.whitening.whitened(&self.trial.scores);
        let twice_the_gain = self.trial.whitening.twice_the_gain(&whitened, &x);
        // Asked for what passes, so that a NaN does not.
        let is_better = twice_the_gain > 0.0;
        if !is_better {
            return;
        }
        let kept = Chosen {
            index: flown.index,
            evidence: 0.5 * twice_the_gain,
            p_value: self.tried.get(index).map_or(1.0, |tried| tried.p_value),
            sigma: scaled(&flown.sigma),
            by_history: true,
            stays: true,
            residual_before_rad: Self::shown_in(subject, flown.index, self.residual),
            ..Chosen::NONE
        };
        // In its place, or where there is room.
        self.chosen.retain(|chosen| chosen.index != flown.index);
        if self.chosen.push(kept).is_err() {
            return;
        }
        self.x.get_mut(columns).unwrap_or_default().iter_mut().zip(x).for_each(|(x, flown)| *x = flown);
    }
}
