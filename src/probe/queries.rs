//! Queries of a probe's state.

use super::{Counters, Probe};
#[cfg(feature = "explanation")]
use crate::estimator::Estimator;
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel, effects::LIBRARY},
    config::Config,
    identification::WindowCost,
    magnet::{HardIronCounts, HardIronInterval},
};

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Probe<NODES, COLUMNS, REPORTS> {
    /// Library of effects in use since the last [`Probe::configure`].
    #[must_use]
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.library.unwrap_or(&LIBRARY)
    }

    /// Effects that are taken out of the readings.
    #[must_use]
    pub const fn effects(&self) -> &ActiveEffects {
        self.identifier.effects()
    }

    /// Configuration in use.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Instant from which nothing new takes effect, as set by [`Probe::freeze`].
    #[must_use]
    pub fn frozen_at_us(&self) -> Option<u64> {
        Some(self.identifier.freeze_us()).filter(|at_us| *at_us < u64::MAX)
    }

    /// Returns true if the last sample that was taken began a new time base because the clock went back: all that
    /// was learnt is forgotten, the factory's model flies, and the output is flagged
    /// [`AFTER_GAP`](crate::attitude::AttitudeFlags::AFTER_GAP).
    #[must_use]
    pub const fn began_afresh(&self) -> bool {
        self.session.began_afresh
    }

    /// Counters since the configuration.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        Counters {
            overruns: self.identifier.overruns,
            reports_lost: self.identifier.reports_lost,
            diagnoses_lost: self.identifier.diagnoses_lost(),
            increments_lost: self.identifier.increments_lost(),
            ..self.session.counters
        }
    }

    /// Gyro model in use.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        self.identifier.flown()
    }

    /// Cost that the search minimises, for trying other optimisers; `None` before there is a posterior. It
    /// changes with every sample: query it right after a window's report.
    #[must_use]
    pub fn window_cost(&self) -> Option<WindowCost<'_, NODES>> {
        self.identifier.window_cost()
    }

    /// Does one piece of identification work; returns `false` if none was left.
    #[cfg(feature = "explanation")]
    pub fn poll_one(&mut self) -> bool {
        let is_some = self.identifier.step(&self.config) > 0;
        let _ = self.identifier.take_report();
        is_some
    }

    /// Estimator at its present step; [`Probe::poll_one`] advances it by one.
    #[cfg(feature = "explanation")]
    #[must_use]
    pub const fn estimator(&self) -> &Estimator<f32, NODES, COLUMNS> {
        self.identifier.estimator()
    }

    /// Magnets that came while the probe ran, as body-fixed offsets of the field, oldest first: the last eight of
    /// [`Probe::hard_iron_counts`]. Empty when effects are switched off.
    pub fn hard_iron_intervals(&self) -> impl Iterator<Item = &HardIronInterval> {
        self.pipeline.watch.intervals()
    }

    /// Counters of the watch for magnets since the configuration.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.pipeline.watch.counts()
    }
}
