//! Attitude: the filter with the factory's calibration, surveys, and the watch for magnets. Nothing is identified.

use crate::Tier;
use meerkat_mwd::{
    Config, Sample,
    probe::{AttitudeProbe, Output},
    survey::{SurveyNews, Surveys},
};

/// The tier, over state that is two statics on a chip.
pub struct Attitude<'a> {
    probe: &'a mut AttitudeProbe,
    surveys: &'a mut Surveys,
    taken: u32,
}

impl<'a> Attitude<'a> {
    /// Before a configuration.
    pub const fn new(probe: &'a mut AttitudeProbe, surveys: &'a mut Surveys) -> Self {
        Self { probe, surveys, taken: 0 }
    }
}

impl Tier for Attitude<'_> {
    fn configure(&mut self, config: &Config) -> bool {
        self.probe.configure(config).is_ok() && self.surveys.configure(&config.earth, &config.survey).is_ok()
    }

    fn push(&mut self, sample: &Sample) -> Option<Output> {
        let output = self.probe.push(sample)?;
        let news = self.surveys.push(&self.probe.survey_input(sample, &output));
        self.taken += u32::from(news.contains(SurveyNews::STATIONARY));
        Some(output)
    }

    fn results(&self) -> u32 {
        self.taken
    }
}
