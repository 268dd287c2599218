//! What a probe can be asked.

use super::{Counters, Probe};
#[cfg(feature = "explanation")]
use crate::estimator::Estimator;
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel, effects::LIBRARY},
    config::Config,
    identification::WindowCost,
    magnet::{HardIronCounts, HardIronInterval},
};

impl Probe {
    /// The effects that are looked for.
    #[must_use]
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.library.unwrap_or(&LIBRARY)
    }

    /// The effects that are taken out.
    #[must_use]
    pub const fn effects(&self) -> &ActiveEffects {
        self.identifier.effects()
    }

    /// What it was configured with.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// What has been counted since the start.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        Counters {
            overruns: self.identifier.overruns,
            reports_lost: self.identifier.reports_lost,
            diagnoses_lost: self.identifier.diagnoses_lost(),
            increments_lost: self.identifier.increments_lost(),
            ..self.counters
        }
    }

    /// The gyro model in use.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        self.identifier.flown()
    }

    /// What the search minimises, for other optimisers to be tried on; `None` before there is a posterior. It changes with every sample: ask
    /// right after the report of a window.
    #[must_use]
    pub fn window_cost(&self) -> Option<WindowCost<'_>> {
        self.identifier.window_cost()
    }

    /// The estimator at its present step: a budget of 1 for [`Probe::poll`] makes it go on by one.
    #[cfg(feature = "explanation")]
    #[must_use]
    pub const fn estimator(&self) -> &Estimator {
        self.identifier.estimator()
    }

    /// Body-fixed magnetic offsets that came while the probe ran, the oldest first: the last eight of
    /// [`Probe::hard_iron_counts`]. Empty when effects are switched off.
    pub fn hard_iron_intervals(&self) -> impl Iterator<Item = &HardIronInterval> {
        self.watch.intervals()
    }

    /// What the watch for them has counted since the start.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.watch.counts()
    }
}
