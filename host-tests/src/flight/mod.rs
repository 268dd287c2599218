//! One run of the pipeline over a trace.

pub mod configuration;
pub mod through_sensors;
mod watched;

use meerkat_mwd::{
    Config, Probe, Sample,
    compensation::{Effect, effects::LIBRARY},
    config::ConfigError,
    diagnosis::DiagnosisReport,
    identification::{Decision, WindowReport},
    magnet::HardIronInterval,
    probe::{Counters, Output},
    storage::StoredModel,
};

pub use watched::{Calibrated, Watched, surveys, watched, worst_second};

use crate::failure::Failure;

/// Result of one run of the pipeline over a trace, on the host or on the emulated chip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flight {
    /// One per sample, in order.
    pub outputs: Vec<Output>,
    /// One per window, in order of closing.
    pub reports: Vec<WindowReport>,
    /// One per diagnosis, in order.
    pub diagnoses: Vec<DiagnosisReport>,
    /// Magnets that came and went, the latest that the probe keeps.
    pub magnets: Vec<HardIronInterval>,
    /// Counters of the probe at the end.
    pub counters: Counters,
}

impl Flight {
    /// The last window that was accepted.
    #[must_use]
    pub fn standing(&self) -> Option<&WindowReport> {
        self.reports.iter().rev().find(|report| report.decision == Decision::Accepted)
    }
}

/// Flies on the host: pushes every sample, then does [`Probe::poll_budget`] units of work, as the firmware
/// does. Calls `progress` with the number of samples flown so far.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly(config: &Config, samples: &[Sample], progress: impl FnMut(usize)) -> Result<Flight, ConfigError> {
    Ok(fly_on(probe(&LIBRARY, config)?, samples, progress))
}

/// Configures a probe, with a stored model or the factory's, before its first sample.
///
/// # Errors
/// The configuration or the model cannot be used.
pub fn started(config: &Config, model: Option<&StoredModel>) -> Result<Box<Probe>, Failure> {
    let mut probe = probe(&LIBRARY, config)?;
    let restored = model.map_or(Ok(()), |model| probe.restore(model));
    restored.map_err(|why| Failure::BadInput(format!("the stored model may not fly: {why:?}")))?;
    Ok(probe)
}

/// Flies a configured probe.
#[must_use]
pub fn fly_on(probe: Box<Probe>, samples: &[Sample], progress: impl FnMut(usize)) -> Flight {
    fly_at(Pace::OfTheChip, probe, samples, progress)
}

/// Flies on the host with another library of effects.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly_with(
    library: &'static [&'static dyn Effect],
    config: &Config,
    samples: &[Sample],
    progress: impl FnMut(usize),
) -> Result<Flight, ConfigError> {
    Ok(fly_at(Pace::OfTheChip, probe(library, config)?, samples, progress))
}

/// Flies with all work done as soon as it is there, as a desk computer can.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly_at_a_desk(
    library: &'static [&'static dyn Effect],
    config: &Config,
    samples: &[Sample],
) -> Result<Flight, ConfigError> {
    Ok(fly_at(Pace::OfADesk, probe(library, config)?, samples, |_| {}))
}

/// Amount of work done after each sample.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pace {
    OfTheChip,
    OfADesk,
}

fn probe(library: &'static [&'static dyn Effect], config: &Config) -> Result<Box<Probe>, ConfigError> {
    let mut probe = Box::new(Probe::new());
    probe.set_library(library);
    probe.configure(config)?;
    Ok(probe)
}

fn fly_at(pace: Pace, mut probe: Box<Probe>, samples: &[Sample], mut progress: impl FnMut(usize)) -> Flight {
    let mut flight = Flight { outputs: Vec::with_capacity(samples.len()), ..Flight::default() };
    for (flown, sample) in samples.iter().enumerate() {
        flight.outputs.extend(probe.push(sample));
        let budget = if pace == Pace::OfADesk { u32::MAX } else { probe.poll_budget() };
        flight.reports.extend(probe.poll(budget));
        flight.diagnoses.extend(probe.take_diagnosis());
        progress(flown + 1);
    }
    // Reports that are ready faster than one a sample.
    flight.reports.extend(std::iter::from_fn(|| probe.poll(0)));
    flight.diagnoses.extend(std::iter::from_fn(|| probe.take_diagnosis()));
    flight.magnets = probe.hard_iron_intervals().copied().collect();
    flight.counters = probe.counters();
    flight
}
