//! Effects that fly already.

#![allow(clippy::indexing_slicing)] // Every index is one of a parameter.

use super::*;

impl Diagnosis {
    /// Lets an effect stay as it flies that this window does not show by itself, or not enough of, if it explains the window better than nothing
    /// does: held out, since it was learnt from others.
    #[inline(never)]
    pub(super) fn keep_flown(&mut self, subject: &Subject, flown: &FoundEffect) {
        let index = usize::from(flown.index);
        let Some(effect) = subject.library.get(index) else { return };
        let columns = self.columns_of(subject, index);
        let scaled = |values: &[f32; MAX_PARAMETERS]| {
            let mut scaled = [0.0; MAX_PARAMETERS];
            for (k, parameter) in each_parameter().zip(effect.parameters()) {
                scaled[k] = values[k] / parameter.usual;
            }
            scaled
        };
        let (x, sigma) = (scaled(&flown.parameters), scaled(&flown.sigma));
        let mut found = self.chosen.iter().filter(|chosen| !chosen.too_small && self.is_whole(subject, chosen));
        if found.any(|chosen| chosen.index == flown.index) {
            // What the bias and P share with an effect of the gyro is not the same from window to window; a delay they do not.
            if effect.sensor() != Sensor::Gyro || effect.gyro_delay_s(&flown.parameters) != 0.0 {
                self.sharpen(flown.index, columns, [&x, &sigma]);
            }
            return;
        }
        if self.find_scores(columns.clone(), &self.model(subject, Some(index))).is_none() {
            return;
        }
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
            sigma,
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

    /// What flies of an effect that this window shows by itself, too, is known before it, so that it sharpens from window to window; but not a
    /// parameter that has become another, by the deviations of both. What both windows hold is not to count twice.
    #[inline(never)]
    fn sharpen(&mut self, index: u8, columns: core::ops::Range<usize>, [x, sigma]: [&[f32; MAX_PARAMETERS]; 2]) {
        let Some(chosen) = self.chosen.iter_mut().find(|chosen| chosen.index == index) else { return };
        for (k, column) in each_parameter().zip(columns) {
            let (mean, variance, own) = (x[k], square(sigma[k]), square(chosen.sigma[k]));
            let Some(prior) = self.priors.get_mut(column).filter(|_| mean != 0.0 && variance > 0.0) else { continue };
            if square(at(&self.x, column) - mean) < square(SIGNIFICANT) * (own + variance) {
                *prior = Prior { information: self.job.unseen / (AGEING * variance), mean };
                chosen.sigma[k] = 1.0 / libm::sqrtf(prior.information + 1.0 / own);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn what_flies_is_known_before_as_far_as_its_samples_are_others_and_what_has_moved_is_not() {
        let mut diagnosis = std::boxed::Box::new(Diagnosis::zero());
        diagnosis.priors = [Prior::UNIT; COLUMNS];
        diagnosis.x[20..24].copy_from_slice(&[1.0, 1.0, 1.0, 1.0]);
        let mut chosen = Chosen { index: 3, ..Chosen::NONE };
        chosen.sigma[..4].copy_from_slice(&[0.1; 4]);
        assert!(diagnosis.chosen.push(chosen).is_ok());
        // Much the same; another one by three and a half deviations; one that was not seen; one that nothing is known of.
        let mut flown = [[0.0; MAX_PARAMETERS]; 2];
        flown[0][..4].copy_from_slice(&[1.2, 1.5, 0.0, 1.0]);
        flown[1][..4].copy_from_slice(&[0.1, 0.1, 0.1, 0.0]);
        for (unseen, information) in [(1.0, 100.0), (0.5, 50.0)] {
            diagnosis.job.unseen = unseen;
            diagnosis.chosen[0].sigma[0] = 0.1;
            let [x, sigma] = &flown;
            diagnosis.sharpen(3, 20..24, [x, sigma]);
            let prior = diagnosis.priors[20];
            assert!((prior.information - information / AGEING).abs() < 1e-2 && prior.mean == 1.2);
            let sigma = 1.0 / libm::sqrtf(information / AGEING + 100.0);
            assert!((diagnosis.chosen[0].sigma[0] - sigma).abs() < 1e-5);
            for prior in &diagnosis.priors[21..] {
                assert_eq!((prior.information, prior.mean), (1.0, 0.0));
            }
            assert_eq!(diagnosis.chosen[0].sigma[1..4], [0.1; 3]);
        }
    }
}
