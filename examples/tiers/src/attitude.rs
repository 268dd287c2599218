//! Attitude: the filter with the factory's calibration, surveys, and the watch for magnets. Nothing is identified.

use crate::Tier;
use meerkat_mwd::{
    Config, Sample,
    probe::{AttitudeProbe, Output},
    survey::{SurveyNews, Surveyor},
};

/// The tier, over state that is two statics on a chip.
pub struct Attitude<'a> {
    probe: &'a mut AttitudeProbe,
    surveyor: &'a mut Surveyor,
    surveys: u32,
}

impl<'a> Attitude<'a> {
    /// Before a configuration.
    pub const fn new(probe: &'a mut AttitudeProbe, surveyor: &'a mut Surveyor) -> Self {
        Self { probe, surveyor, surveys: 0 }
    }
}

impl Tier for Attitude<'_> {
    fn configure(&mut self, config: &Config) -> bool {
        self.probe.configure(config).is_ok() && self.surveyor.configure(&config.earth, &config.survey).is_ok()
    }

    fn push(&mut self, sample: &Sample) -> Option<Output> {
        let output = self.probe.push(sample)?;
        let news = self.surveyor.push(&self.probe.survey_input(sample, &output));
        self.surveys += u32::from(news.contains(SurveyNews::STATIONARY));
        Some(output)
    }

    fn results(&self) -> u32 {
        self.surveys
    }
}
