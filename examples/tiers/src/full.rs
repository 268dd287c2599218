//! Everything but the population search, for a part with 64 KiB of RAM: identification with the effects, surveys and
//! the watch of the drilling.

use crate::Tier;
use meerkat_mwd::{Config, Probe, Sample, identification::Decision, probe::Output, survey::Surveyor};

/// Columns for effects, of the 44 that the library has with three steps of the bias.
pub const COLUMNS: usize = 13;

/// Probe of the tier: no search, fewer columns for effects, one report that waits.
pub type FullProbe = Probe<0, COLUMNS, 1>;

/// The tier, over state that is two statics on a chip.
pub struct Full<'a, const NODES: usize = 0, const E: usize = COLUMNS, const REPORTS: usize = 1> {
    probe: &'a mut Probe<NODES, E, REPORTS>,
    surveyor: &'a mut Surveyor,
    accepted: u32,
}

impl<'a, const NODES: usize, const E: usize, const REPORTS: usize> Full<'a, NODES, E, REPORTS> {
    /// Before a configuration.
    pub const fn new(probe: &'a mut Probe<NODES, E, REPORTS>, surveyor: &'a mut Surveyor) -> Self {
        Self { probe, surveyor, accepted: 0 }
    }
}

impl<const NODES: usize, const E: usize, const REPORTS: usize> Tier for Full<'_, NODES, E, REPORTS> {
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
