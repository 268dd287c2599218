//! A P that does not come from the probe's own sensors: the simulator's, or one fitted to the reference
//! attitude.

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    estimator::{
        Estimator, Posterior, Settings,
        columns::{ACCEL_LAG, MAG_LAG},
    },
    sample::Reading,
};
use nalgebra::Vector3;

use crate::{
    diagnosis::{attitudes, vectors_from},
    score::nees::{Covariance, p_of},
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
        let covariance = Covariance::from_fn(|row, column| {
            let (long, short) = (row.max(column), row.min(column));
            found.p_covariance.get(long * (long + 1) / 2 + short).copied().map_or(f64::NAN, f64::from)
        });
        Some(Self { source: "from the reference attitude", p: p_of(&found.gyro), covariance })
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
    let mut estimator = Box::new(Estimator::<f64>::zero());
    estimator.configure(&settings, &[]);
    for sample in vectors_from(trace, &attitudes(trace)) {
        estimator.push(sample.t_us, readings(&sample), None);
        while estimator.step() > 0 {}
    }
    estimator.close(false);
    while estimator.step() > 0 {}
    estimator.posterior().filter(|posterior| posterior.fitness.is_ok()).copied()
}

fn readings(sample: &Sample) -> [Reading; 3] {
    let gyro = SampleFlags::GYRO_MISSING | SampleFlags::GYRO_CLIPPED;
    let of = |without: SampleFlags, v: [f32; 3]| {
        if sample.flags.intersects(without) { Reading::Missing } else { Reading::Usable(Vector3::from(v)) }
    };
    [
        of(gyro, sample.gyro_rad_s),
        of(SampleFlags::ACCEL_MISSING, sample.accel_m_s2),
        of(SampleFlags::MAG_MISSING, sample.mag_ut),
    ]
}
