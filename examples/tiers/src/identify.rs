//! Identification of P and b: the attitude tier and an estimator without effects and without the rows that a search
//! would need.

use crate::Tier;
use meerkat_mwd::{
    Config, Sample,
    estimator::{Estimator, Settings},
    probe::{AttitudeProbe, Output},
};

/// Interval between models that may fly, microseconds.
const UPDATE_US: u64 = 5_000_000;
/// Steps of the estimator after each sample. One takes 56 to 650 units of 500 cycles.
const STEPS: u32 = 8;

/// Estimator with the rows of one node and one column for effects: as few as it takes.
pub type Small = Estimator<f32, 1, 1>;

/// The tier, over state that is two statics on a chip.
pub struct Identify<'a> {
    probe: &'a mut AttitudeProbe,
    estimator: &'a mut Small,
    updated_us: u64,
    closing: bool,
    flown: u32,
}

impl<'a> Identify<'a> {
    /// Before a configuration.
    pub const fn new(probe: &'a mut AttitudeProbe, estimator: &'a mut Small) -> Self {
        Self { probe, estimator, updated_us: 0, closing: false, flown: 0 }
    }
}

impl Tier for Identify<'_> {
    fn configure(&mut self, config: &Config) -> bool {
        self.estimator.configure(&Settings::new(config), &[]);
        self.probe.configure(config).is_ok()
    }

    fn push(&mut self, sample: &Sample) -> Option<Output> {
        let (output, readings) = self.probe.push_and_read(sample)?;
        let warming_k = None;
        self.estimator.push(sample.t_us, readings, warming_k);
        if !self.closing && sample.t_us.saturating_sub(self.updated_us) >= UPDATE_US {
            self.updated_us = sample.t_us;
            self.estimator.close(false);
            self.closing = true;
        }
        let idle = (0..STEPS).any(|_| self.estimator.step() == 0);
        if idle && self.closing {
            self.closing = false;
            if let Some(posterior) = self.estimator.posterior().filter(|posterior| posterior.fitness.is_ok()) {
                let (model, sigma) = (posterior.gyro, posterior.sigma);
                if self.probe.fly(&model, &sigma) {
                    self.estimator.compose_with(&model);
                    self.flown += 1;
                }
            }
        }
        Some(output)
    }

    fn results(&self) -> u32 {
        self.flown
    }
}
