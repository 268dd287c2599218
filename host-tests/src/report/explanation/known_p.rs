//! A P that does not come from the probe's own sensors: the simulator's, or one fitted to the reference
//! attitude.

use meerkat_mwd::{
    Config,
    estimator::{
        Posterior, Settings,
        columns::{ACCEL_LAG, MAG_LAG},
    },
};

use crate::diagnosis::{attitudes, vectors_from};
use testbed::{
    flight::estimate::posterior,
    score::nees::{Covariance, covariance_of, p_of},
    trace::Trace,
};

/// A known P, to compare windows with.
pub(super) struct KnownP {
    /// Its source, for the report.
    pub source: &'static str,
    /// P, row-major.
    pub p: [f64; 9],
    /// Covariance of this P's own error.
    pub covariance: Covariance,
}

impl KnownP {
    /// The simulator's true P; else the estimator's result over the whole trace in `f64`, with gravity and
    /// field computed from the reference attitude. `None` if the trace has neither, or the reference
    /// determines too little.
    pub(super) fn of(trace: &Trace, config: &Config) -> Option<Self> {
        if let Some(p) = trace.keys.true_gyro_p {
            return Some(Self { source: "the simulator's", p, covariance: Covariance::zeros() });
        }
        let found = from_reference(trace, config)?;
        Some(Self { source: "from the reference attitude", p: p_of(&found.gyro), covariance: covariance_of(&found) })
    }
}

fn from_reference(trace: &Trace, config: &Config) -> Option<Posterior> {
    if trace.reference.iter().flatten().count() < 2 {
        return None;
    }
    let mut config = *config;
    config.identification.vectors_from_reference = true;
    let mut settings = Settings::new(&config);
    // The reference has its own clock, so both vectors may be late by some milliseconds.
    for (column, width_s) in [(MAG_LAG.from, 0.015), (ACCEL_LAG.from, 0.005)] {
        *settings.sigma.get_mut(column)? = width_s;
    }
    let found = posterior::<f64>(&settings, &[], vectors_from(trace, &attitudes(trace)));
    found.filter(|posterior| posterior.fitness.is_ok())
}
