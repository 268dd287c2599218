//! A simulated run of which one window identifies and the rest is scored.

use std::path::Path;

use anyhow::Context;
use meerkat_mwd::{
    Config,
    compensation::GyroModel,
    config::{OptimizerKind, VectorErrors},
    identification::WindowReport,
};

use super::cramer_rao::{Bound, Known};
use crate::{
    flight::{configuration::of_trace, fly_frozen},
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, Truth, simulate},
    trace::Trace,
};

/// Length of the window, seconds.
pub const WINDOW_S: f64 = 50.0;

/// Vector sensors after a good calibration: a thirtieth of what data sheets allow. Those of the simulation are perfect,
/// so that to declare this claims nothing that is not so.
pub const CALIBRATED: VectorErrors = VectorErrors {
    mag_matrix: 0.001,
    hard_iron: 0.003,
    mag_lag_s: 0.0005,
    accel_matrix: 0.000_17,
    accel_bias_m_s2: 0.007,
    accel_lag_s: 0.000_17,
};

/// The scenario of a file in `host-tests/scenarios`.
///
/// # Errors
/// It cannot be read.
pub fn scenario(name: &str) -> anyhow::Result<Scenario> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("scenarios");
    Ok(Scenario::read(&folder.join(name).with_extension("toml"))?)
}

/// A simulated run.
pub struct Run {
    /// Scenario that was simulated.
    pub scenario: Scenario,
    /// Readings of the sensors.
    pub trace: Trace,
    /// Truth of the simulator.
    pub truth: Truth,
    /// Configuration: frozen as soon as the first window's result takes effect.
    pub config: Config,
    /// Instant from which nothing new takes effect, microseconds: that of the window's result.
    freeze_us: u64,
    /// The sample at which the window closes.
    pub close: usize,
    /// The first sample to which its result applies.
    pub effect: usize,
}

impl Run {
    /// Simulates a scenario whose first [`WINDOW_S`] are the window.
    ///
    /// # Errors
    /// The run is too short for the window and the latency of its result.
    pub fn simulate(scenario: &Scenario, seed: u64) -> anyhow::Result<Self> {
        let (trace, truth) = simulate(scenario, seed);
        Self::of(scenario.clone(), trace, truth)
    }

    /// A run that has been simulated.
    ///
    /// # Errors
    /// It is too short for the window and the latency of its result.
    pub fn of(scenario: Scenario, trace: Trace, truth: Truth) -> anyhow::Result<Self> {
        let mut config = of_trace(&trace);
        // Only the identification is measured.
        config.effects = false;
        let close_us = trace.first_us() + (WINDOW_S * 1e6) as u64;
        let freeze_us = close_us + (f64::from(config.identification.latency_s) * 1e6) as u64;
        let at = |t_us: u64| trace.samples.partition_point(|s| s.t_us < t_us);
        let (close, effect) = (at(close_us), at(freeze_us));
        anyhow::ensure!(effect + 1 < trace.samples.len(), "the run ends before the result of its window takes effect");
        Ok(Self { scenario, trace, truth, config, freeze_us, close, effect })
    }

    /// Report of the window with this search.
    ///
    /// # Errors
    /// The configuration cannot be used, or no window was closed.
    pub fn identify(&self, optimizer: OptimizerKind) -> anyhow::Result<WindowReport> {
        let mut config = self.config;
        config.identification.optimizer = optimizer;
        self.identify_as(&config)
    }

    /// Report of the window with this configuration.
    ///
    /// # Errors
    /// The configuration cannot be used, or no window was closed.
    pub fn identify_as(&self, config: &Config) -> anyhow::Result<WindowReport> {
        // Samples after the window's result need not be flown.
        let needed = self.trace.samples.get(..=self.effect + 1).unwrap_or(&self.trace.samples);
        fly_frozen(config, self.freeze_us, needed)?.reports.first().copied().context("no window was closed")
    }

    /// The true model when the window closes.
    #[must_use]
    pub fn true_model(&self) -> GyroModel {
        self.truth.gyro_at(self.close)
    }

    /// True rates from the time on at which the window's result applies, rad/s.
    #[must_use]
    pub fn rates_ahead(&self) -> &[[f64; 3]] {
        self.trace.true_rate.as_deref().and_then(|rates| rates.get(self.effect..)).unwrap_or_default()
    }

    /// Systematic rate error of a model over the run after the window, deg/s, against the true model when it
    /// closed.
    ///
    /// # Errors
    /// There is no rate to score over, which no valid scenario gives.
    pub fn rate_error_deg_s(&self, model: &GyroModel) -> anyhow::Result<f64> {
        systematic_rate_error_rad_s(&self.true_model(), model, self.rates_ahead())
            .map(f64::to_degrees)
            .context("no rate to score over")
    }

    /// The Cramer-Rao bound of the window.
    #[must_use]
    pub fn bound(&self, known: Known) -> Bound {
        Bound::of_window(&self.scenario, &self.trace, &self.truth, self.close, &self.config.identification, known)
    }

    /// Bound of [`Self::rate_error_deg_s`], rms.
    #[must_use]
    pub fn bound_deg_s(&self, known: impl Into<Known>) -> f64 {
        self.bound(known.into()).rate_error_rad_s(&self.true_model(), self.rates_ahead()).to_degrees()
    }
}
