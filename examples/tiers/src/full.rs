//! Everything: the whole pipeline, and surveys.

use crate::Tier;
use meerkat_mwd::{Config, Probe, Sample, identification::Decision, probe::Output, survey::Surveyor};

/// The tier, over state that is two statics on a chip.
pub struct Full<'a> {
    probe: &'a mut Probe,
    surveyor: &'a mut Surveyor,
    accepted: u32,
}

impl<'a> Full<'a> {
    /// Before a configuration.
    pub const fn new(probe: &'a mut Probe, surveyor: &'a mut Surveyor) -> Self {
        Self { probe, surveyor, accepted: 0 }
    }
}

impl Tier for Full<'_> {
    fn configure(&mut self, config: &Config) -> bool {
        self.probe.configure(config).is_ok() && self.surveyor.configure(&config.earth, &config.survey).is_ok()
    }

    fn push(&mut self, sample: &Sample) -> Option<Output> {
        let output = self.probe.push(sample)?;
        self.surveyor.push(&self.probe.survey_input(sample, &output));
        if let Some(report) = self.probe.poll(self.probe.poll_budget()) {
            self.accepted += u32::from(report.decision == Decision::Accepted);
        }
        Some(output)
    }

    fn results(&self) -> u32 {
        self.accepted
    }
}
