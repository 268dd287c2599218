//! The step of the gyro's bias, the candidate that has a time and no columns of its own.

#![allow(clippy::indexing_slicing)] // Constant indices into pairs and threes.

use super::*;

/// Times at which the bias may have stepped that are looked at in one piece of work.
const TIMES_IN_A_STEP: usize = 12;

impl Diagnosis {
    /// Whether a candidate is the step of the bias.
    pub(super) fn is_bias_step(subject: &Subject, index: usize) -> bool {
        subject.library.get(index).is_some_and(|effect| effect.is_bias_step())
    }

    /// When the pass's test windows are.
    fn timing(&self, subject: &Subject) -> Timing {
        let hop = subject.stream.test_function.hop() as u32;
        let tests = self.test.min(MAX_TESTS as u32);
        Timing { from: self.job.from, hop, hops: UNDER_WAY as u32, tests }
    }

    fn unit_rad_s(subject: &Subject) -> f32 {
        GyroScales::new(&subject.config.identification).c_rad_s
    }

    /// Begins to look for a step of the bias; false where none is looked for, or nothing can be told.
    #[inline(never)]
    pub(super) fn look_for_step(&mut self, subject: &Subject) -> bool {
        if !subject.library.iter().any(|effect| effect.is_bias_step()) {
            return false;
        }
        self.shocks = Shocks::new(subject.stream, self.job.from, self.job.to);
        let (timing, unit_rad_s) = (self.timing(subject), Self::unit_rad_s(subject));
        let scan = RateErrors::new(self.factor.scratch()).begin(&self.step, &timing, unit_rad_s);
        let begun = scan.is_some();
        self.scan = scan.unwrap_or(Scan::zero());
        begun
    }

    /// Looks at some more times; whether there are others.
    pub(super) fn scan_for_step(&mut self, subject: &Subject) -> bool {
        let timing = self.timing(subject);
        let Self { factor, scan, shocks, .. } = self;
        RateErrors::new(factor.scratch()).scan(scan, &timing, (shocks, subject.stream), TIMES_IN_A_STEP)
    }

    /// The step that this pass shows.
    pub(super) fn found_step(&mut self, subject: &Subject) -> Option<BiasStep> {
        let (timing, unit_rad_s) = (self.timing(subject), Self::unit_rad_s(subject));
        RateErrors::new(self.factor.scratch()).found(&self.scan, &timing, &self.shocks, unit_rad_s)
    }

    /// Takes what this pass shows of a step of the bias; one that is in the model follows it. Whether that stays when it was.
    pub(super) fn follow_step(&mut self, found: Option<BiasStep>) -> bool {
        self.shown_step = found.unwrap_or(BiasStep::NONE);
        if self.step.until == 0 || self.shown_step.until == 0 {
            return true;
        }
        let before = core::mem::replace(&mut self.step, self.shown_step);
        let moved = (self.step.step_rad_s - before.step_rad_s).component_div(&self.step.sigma_rad_s);
        before.until == self.step.until && moved.iter().all(|sigmas| libm::fabsf(*sigmas) < STEP_SETTLED)
    }

    /// The step in the unit of its effect's parameters, and its deviations; those of its axes that are not seen to be there 0.
    pub(super) fn step_parameters(&self) -> [[f32; MAX_PARAMETERS]; 2] {
        let mut parameters = [[0.0; MAX_PARAMETERS]; 2];
        let [seen, sigmas] = &mut parameters;
        let axes = self.step.step_rad_s.iter().zip(self.step.sigma_rad_s.iter());
        for ((seen, kept), (x, sigma)) in seen.iter_mut().zip(sigmas).zip(axes) {
            *seen = if libm::fabsf(*x) >= SIGNIFICANT * sigma { *x } else { 0.0 };
            *kept = *sigma;
        }
        parameters
    }

    /// How much the step turns the body in a second, and the deviation of that, rad.
    pub(super) fn step_size_rad(&self) -> (f32, f32) {
        let [seen, sigma] = self.step_parameters();
        let norm = |x: &[f32; MAX_PARAMETERS]| libm::sqrtf(each_parameter().fold(0.0, |sum, k| sum + square(x[k])));
        (norm(&seen), norm(&core::array::from_fn(|k| if seen[k] == 0.0 { 0.0 } else { sigma[k] })))
    }

    /// What is to be done about the step: when it was, and the rates that tell the bias after it.
    pub(super) fn step_report(&self, subject: &Subject) -> Option<BiasStepReport> {
        let mut taken_out = self.chosen.iter().filter(|chosen| !chosen.too_small);
        let chosen = taken_out.find(|chosen| Self::is_bias_step(subject, usize::from(chosen.index)))?;
        let since_us = u64::from(self.job.to.saturating_sub(self.step.until));
        let since_us = since_us * u64::from(subject.stream.grid.interval_us);
        let count = (self.job.to - self.job.from) as f32;
        let [raw, rate] = self.rate_sums.map(|sum| sum / count);
        let before = self.step.until.saturating_sub(self.job.from) as f32 / count;
        let raw = raw + self.p.try_inverse()? * self.step.step_rad_s * before;
        Some(BiasStepReport {
            effect: chosen.index,
            t_us: self.job.t_end_us.saturating_sub(since_us),
            until: self.step.until,
            raw_rad_s: raw.into(),
            rate_rad_s: rate.into(),
        })
    }
}
