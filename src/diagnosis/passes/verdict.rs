//! What is made of it.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs and threes.

use super::*;
use crate::diagnosis::remainder::RemainderReport;

impl Diagnosis {
    /// The residual of the vector that shows an effect.
    pub(super) fn shown_in(subject: &Subject, index: u8, [gravity, field]: [f32; 2]) -> f32 {
        match subject.library.get(usize::from(index)).map(|effect| effect.sensor()) {
            Some(Sensor::Accelerometer) => gravity,
            _ => field,
        }
    }

    pub(super) fn report(&self, subject: &Subject) -> DiagnosisReport {
        let enough = self.usable >= LEAST_PER_GROUP * GROUPS as u32 && self.tested;
        let mut effects = [EffectReport::default(); MAX_ACTIVE];
        let mut count = 0;
        let mut tried = self.tried;
        for chosen in self.chosen.iter().filter(|chosen| !chosen.too_small && !self.is_named(subject, chosen)) {
            if let Some(tried) = tried.get_mut(usize::from(chosen.index)) {
                tried.suspected = true;
            }
        }
        let taken_out = self.chosen.iter().enumerate().filter(|(_, chosen)| self.is_named(subject, chosen));
        for (report, (slot, chosen)) in effects.iter_mut().zip(taken_out) {
            let index = usize::from(chosen.index);
            let Some(effect) = subject.library.get(index) else { continue };
            let mut parameters = self.parameters(subject, index);
            let mut sigma = [0.0; MAX_PARAMETERS];
            for (k, parameter) in each_parameter().zip(effect.parameters()) {
                sigma[k] = chosen.sigma[k] * parameter.usual;
                if chosen.in_p {
                    parameters[k] = chosen.free[k] * parameter.usual;
                } else if effect.sensor() != Sensor::Gyro && !chosen.is_seen(k, parameters[k] / parameter.usual) {
                    parameters[k] = 0.0;
                }
            }
            if Self::is_bias_step(subject, index) {
                [parameters, sigma] = self.step_parameters();
            }
            let (size_rad, size_sigma_rad) =
                if chosen.in_p { chosen.free_size_rad } else { self.size_rad(subject, slot) };
            count += 1;
            *report = EffectReport {
                found: FoundEffect { index: chosen.index, parameters, sigma },
                evidence: chosen.evidence,
                p_value: chosen.p_value,
                size_rad,
                size_sigma_rad,
                residual_rad: [chosen.residual_before_rad, chosen.residual_after_rad],
                believed: effect.parameters().iter().zip(&parameters).all(|(parameter, x)| parameter.believes(*x))
                    && self.is_whole(subject, chosen)
                    && !chosen.in_p,
            };
        }
        let verdict = if !enough {
            Verdict::NotEnoughExcitation
        } else if self.is_unexplained() {
            Verdict::UnexplainedResidual
        } else if count > 0 {
            Verdict::EffectsFound
        } else {
            Verdict::ModelSufficient
        };
        DiagnosisReport {
            t_start_us: self.job.t_start_us,
            t_end_us: self.job.t_end_us,
            t_effect_us: 0,
            verdict,
            effects,
            bias_step: if enough { self.step_report(subject) } else { None },
            count: if enough { count } else { 0 },
            tried,
            candidates: subject.stream.library().len().min(MAX_CANDIDATES) as u8,
            bias_change_rad_s: self.bias_change(subject).into(),
            residual_before_rad: self.residual_before_rad.unwrap_or(self.residual),
            residual_after_rad: self.residual,
            nis: [self.nis_before, self.left().0],
            remainder: if verdict == Verdict::UnexplainedResidual {
                self.remainder.report()
            } else {
                RemainderReport::default()
            },
        }
    }

    /// Whether an effect can be taken out by itself. What is not seen of a gyro's effect the bias and P hold, and would be wrong by it beside the
    /// rest; where a step of the bias leaves a residual, something else may have changed with it, such as P; an unknown effect in the field
    /// bends P, which gravity then shows like an error of the accelerometer, and what is unknown in the field may be any part of what is
    /// found there.
    pub(super) fn is_whole(&self, subject: &Subject, chosen: &Chosen) -> bool {
        let index = usize::from(chosen.index);
        let is_explained = !self.is_unexplained();
        if Self::is_bias_step(subject, index) {
            return is_explained;
        }
        // Whether it is anyway, and from what it has to stand out if it is not.
        let (is_whole, noise, others) = match subject.library.get(index).map(|effect| effect.sensor()) {
            Some(Sensor::Gyro) => (is_explained && self.rest().is_some(), 1.0, 0.0),
            Some(Sensor::Accelerometer) => (is_explained, f32::INFINITY, 0.0),
            _ => (is_explained, self.left().0, self.outside),
        };
        chosen.stays || is_whole || chosen.stands_out(noise, others)
    }

    /// Whether a candidate is none of the library.
    pub(super) fn is_outside(subject: &Subject, index: usize) -> bool {
        index >= subject.stream.library().len()
    }

    /// Whether an effect that was found is named. Beside an unexplained field one of the accelerometer, or a part of one of the gyro, is
    /// suspected only: it may be the unknown effect's.
    fn is_named(&self, subject: &Subject, chosen: &Chosen) -> bool {
        let index = usize::from(chosen.index);
        let of_field = subject.library.get(index).is_some_and(|effect| effect.sensor() == Sensor::Magnetometer);
        let is_sure = of_field || Self::is_bias_step(subject, index) || !self.is_unexplained();
        !chosen.too_small && (is_sure || self.is_whole(subject, chosen))
    }

    /// The raw bias that stands for the solution's mean rate with the P that flies, less the bias that flies: a P of the solution's own is not
    /// the identification's, and its bias would not fit to the one that flies.
    fn bias_change(&self, subject: &Subject) -> Vector3<f32> {
        let (p, c) = self.gyro(subject);
        let raw = self.rate_sums[0] / (self.job.to - self.job.from) as f32;
        let bias = self.job.flown.p_matrix().try_inverse().map(|inverse| raw - inverse * (p * raw - c));
        let change = bias.map_or(Vector3::zeros(), |bias| bias - Vector3::from(self.job.flown.b_rad_s));
        // What no bias can be is none.
        if change.amax() < subject.config.identification.max_bias_rad_s { change } else { Vector3::zeros() }
    }

    /// Whether more is left of the field's residual than its noise, and more than matters little.
    pub(super) fn is_unexplained(&self) -> bool {
        // Degrees of freedom: three components of every fourth test window, as they overlap.
        let freedom = 0.75 * self.usable as f32;
        let band = 1.0 + 1.96 * libm::sqrtf(2.0 / freedom);
        let (nis, residual_rad) = self.left();
        self.outside > 0.0 || nis > band && residual_rad > LEAST_LEFT_RAD
    }

    /// NIS and residual of the field with all effects in and P free.
    pub(super) const fn left(&self) -> (f32, f32) {
        let [_, residual] = self.residual;
        if self.is_final { self.left } else { (self.nis, residual) }
    }
}
