//! The smallest probe: attitude with the factory's calibration, and the watch for magnets, without identification. For
//! a microcontroller with little memory; docs/new_board.md lists the functions that it lacks.

use super::{
    Output,
    corrector::Nothing,
    pipeline::{Pipeline, With},
};
use crate::{
    compensation::GyroModel,
    config::{Config, ConfigError},
    magnet::HardIronCounts,
    sample::{Reading, Sample},
    survey::SurveyInput,
    time_step::{is_another_clock, is_gap},
};

/// Probe without identification. It flies the gyro model that it is given: the factory's, or one identified elsewhere
/// ([`AttitudeProbe::fly`]). Like a new [`Probe`](crate::Probe), [`AttitudeProbe::new`] is all zero bytes.
///
/// A sample later than the one before is taken, however large the step; a sample more than ten seconds earlier restarts
/// the probe. `Probe` accepts a step of more than ten seconds only when a second sample confirms it.
pub struct AttitudeProbe {
    configured: bool,
    /// Its gyro model is the one that flies.
    config: Config,
    /// Time of the last sample; `None` before the first.
    last_us: Option<u64>,
    pipeline: Pipeline<Nothing>,
}

impl AttitudeProbe {
    /// Returns a probe without a configuration.
    #[must_use]
    pub const fn new() -> Self {
        Self { configured: false, config: Config::UNSET, last_us: None, pipeline: Pipeline::zero() }
    }

    /// Checks a configuration and starts anew from it.
    ///
    /// # Errors
    /// Names the field that cannot be used; the probe then stays as it was.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = *config;
        self.begin();
        Ok(())
    }

    /// Starts anew from the present configuration.
    fn begin(&mut self) {
        self.last_us = None;
        self.pipeline.start(&self.config);
        self.pipeline.filter.mag_delay_known(self.config.latency.mag_s.map(|_| 0.0));
        self.configured = true;
    }

    /// Flies a gyro model from the next sample on, also after a restart, known with the standard deviations `sigma` of
    /// P (row-major, 9) and b (3, rad/s). Returns false, and changes nothing, for an invalid model and before a
    /// configuration.
    pub fn fly(&mut self, model: &GyroModel, sigma: &[f32; 12]) -> bool {
        let can = self.configured && model.is_valid();
        if can {
            self.pipeline.filter.model_changed(&self.config.gyro, model, sigma);
            self.config.gyro = *model;
        }
        can
    }

    /// Takes one sample. Returns `None` before a configuration, and for a sample whose time does not increase; one that
    /// is more than ten seconds earlier starts the probe anew.
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        self.push_and_read(sample).map(|(output, _)| output)
    }

    /// Takes one sample as [`AttitudeProbe::push`] does. Returns also the readings for an
    /// [`Estimator`](crate::estimator::Estimator): raw rate less the earth's, calibrated force and field.
    // Not inlined: its stack frame would else lie under that of the estimator.
    #[inline(never)]
    pub fn push_and_read(&mut self, sample: &Sample) -> Option<(Output, [Reading; 3])> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        if let Some(last_us) = self.last_us.filter(|last_us| sample.t_us <= *last_us) {
            if !is_another_clock(last_us, sample.t_us) {
                return None;
            }
            self.begin();
        }
        self.pipeline.checks.mark_clipped(&mut sample, &self.config.full_scale);
        let step_us = self.last_us.map_or(0, |last_us| sample.t_us.saturating_sub(last_us));
        let gap = is_gap(step_us, self.config.sample_period_us);
        match self.last_us {
            None => self.pipeline.watch.start(sample.t_us),
            Some(_) if gap => self.pipeline.watch.gap(sample.t_us),
            Some(_) => {}
        }
        self.last_us = Some(sample.t_us);
        let step_s = step_us as f32 * 1e-6;

        let with = With {
            config: &self.config,
            model: &self.config.gyro,
            library: &[],
            gyro_delay_known: self.config.latency.gyro_s.is_some(),
            step_s,
            gap_s: gap.then_some(step_s),
        };
        let stepped = self.pipeline.step(&sample, &with);
        let delay_us = (self.config.latency.gyro_s.unwrap_or(0.0) * 1e6) as u64;
        let t_us = sample.t_us.saturating_sub(delay_us);
        let attitude = self.pipeline.filter.attitude(stepped.flags);
        Some((Output { t_us, rate_rad_s: stepped.rate_rad_s.into(), attitude }, stepped.readings))
    }

    /// Model that flies.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        &self.config.gyro
    }

    /// Counters of the watch for magnets since the configuration.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.pipeline.watch.counts()
    }

    /// Returns the survey's input of a sample that was just pushed and gave `output`, for
    /// [`Surveyor::push`](crate::survey::Surveyor::push).
    #[must_use]
    pub fn survey_input(&self, sample: &Sample, output: &Output) -> SurveyInput {
        self.pipeline.survey_input(&[], sample, output)
    }
}

impl Default for AttitudeProbe {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
