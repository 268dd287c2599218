//! One run of the pipeline over a trace.

pub mod configuration;
pub mod estimate;
pub mod through_sensors;
mod spooled_output;
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

pub use watched::{Calibrated, Watched, dynamics, surveys, watched, worst_second};

use crate::{
    failure::Failure,
    trace::{Trace, spool::Spool},
};

/// Result of one run of the pipeline over a trace, on the host or on the emulated chip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flight {
    /// One per sample, in order; empty where the trace was spooled: [`Flight::outputs`] has them then.
    pub outputs: Vec<Output>,
    /// One per window, in order of closing.
    pub reports: Vec<WindowReport>,
    /// One per diagnosis, in order.
    pub diagnoses: Vec<DiagnosisReport>,
    /// Magnets that came and went, the latest that the probe keeps.
    pub magnets: Vec<HardIronInterval>,
    /// Counters of the probe at the end.
    pub counters: Counters,
    /// Instant from which nothing new took effect, microseconds of the samples' time; `None`: it was not frozen.
    pub frozen_at_us: Option<u64>,
    /// Outputs that are in a temporary file, as those of a spooled trace are.
    pub spooled: Option<Spool<Output>>,
}

impl Flight {
    /// A flight over `trace`, before its first sample. Its outputs are where the rows of the trace are.
    #[must_use]
    pub fn before(trace: &Trace) -> Self {
        Self { spooled: trace.is_spooled().then(Spool::default), ..Self::default() }
    }

    /// Appends an output.
    pub fn put(&mut self, output: &Output) {
        match &mut self.spooled {
            Some(spooled) => spooled.push(output),
            None => self.outputs.push(*output),
        }
    }

    /// The outputs, from the first on, of a flight in memory or not.
    #[must_use]
    pub fn outputs(&self) -> Box<dyn Iterator<Item = Output> + '_> {
        match &self.spooled {
            Some(spooled) => Box::new(spooled.iter()),
            None => Box::new(self.outputs.iter().copied()),
        }
    }

    /// Number of outputs.
    #[must_use]
    pub fn output_count(&self) -> usize {
        self.spooled.as_ref().map_or(self.outputs.len(), Spool::len)
    }

    /// The first error of the temporary file, behind which outputs may lack.
    ///
    /// # Errors
    /// The temporary file could not be written or read.
    pub fn all_read(&self) -> std::io::Result<()> {
        self.spooled.as_ref().map_or(Ok(()), Spool::checked)
    }

    /// Takes what is left of a probe behind its last sample.
    pub fn ended(&mut self, probe: &mut Probe) {
        // Reports that are ready faster than one a sample.
        self.reports.extend(std::iter::from_fn(|| probe.poll(0)));
        self.diagnoses.extend(std::iter::from_fn(|| probe.take_diagnosis()));
        self.magnets = probe.hard_iron_intervals().copied().collect();
        self.counters = probe.counters();
        self.frozen_at_us = probe.frozen_at_us();
        if let Some(spooled) = &mut self.spooled {
            spooled.flush();
        }
    }

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
    let flight = Flight { outputs: Vec::with_capacity(samples.len()), ..Flight::default() };
    Ok(fly_at(Pace::OfTheChip, probe(&LIBRARY, config, None)?, flight, samples.iter().copied(), progress))
}

/// Flies as [`fly`] does, with nothing new taking effect from an instant on.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly_frozen(config: &Config, freeze_at_us: u64, samples: &[Sample]) -> Result<Flight, ConfigError> {
    fly_with(&LIBRARY, config, Some(freeze_at_us), samples)
}

/// Configures a probe, with a stored model or the factory's, before its first sample. `freeze_at_us`: instant from
/// which nothing new takes effect.
///
/// # Errors
/// The configuration or the model cannot be used.
pub fn started(config: &Config, freeze_at_us: Option<u64>, model: Option<&StoredModel>) -> Result<Box<Probe>, Failure> {
    let mut probe = probe(&LIBRARY, config, freeze_at_us)?;
    let restored = model.map_or(Ok(()), |model| probe.restore(model));
    restored.map_err(|why| Failure::BadInput(format!("the stored model may not fly: {why:?}")))?;
    Ok(probe)
}

/// Flies a configured probe over a trace.
#[must_use]
pub fn fly_on(probe: Box<Probe>, trace: &Trace, progress: impl FnMut(usize)) -> Flight {
    fly_at(Pace::OfTheChip, probe, Flight::before(trace), trace.samples(), progress)
}

/// Flies on the host with another library of effects; `freeze_at_us` as in [`started`].
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly_with(
    library: &'static [&'static dyn Effect],
    config: &Config,
    freeze_at_us: Option<u64>,
    samples: &[Sample],
) -> Result<Flight, ConfigError> {
    let probe = probe(library, config, freeze_at_us)?;
    Ok(fly_at(Pace::OfTheChip, probe, Flight::default(), samples.iter().copied(), |_| {}))
}

/// Flies with all work done as soon as it is there, as a desk computer can.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn fly_at_a_desk(
    library: &'static [&'static dyn Effect],
    config: &Config,
    freeze_at_us: Option<u64>,
    samples: &[Sample],
) -> Result<Flight, ConfigError> {
    let probe = probe(library, config, freeze_at_us)?;
    Ok(fly_at(Pace::OfADesk, probe, Flight::default(), samples.iter().copied(), |_| {}))
}

/// Amount of work done after each sample.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pace {
    OfTheChip,
    OfADesk,
}

fn probe(
    library: &'static [&'static dyn Effect],
    config: &Config,
    freeze_at_us: Option<u64>,
) -> Result<Box<Probe>, ConfigError> {
    let mut probe = Box::new(Probe::new());
    probe.set_library(library);
    probe.configure(config)?;
    if let Some(at_us) = freeze_at_us {
        probe.freeze(at_us);
    }
    Ok(probe)
}

fn fly_at(
    pace: Pace,
    mut probe: Box<Probe>,
    mut flight: Flight,
    samples: impl Iterator<Item = Sample>,
    mut progress: impl FnMut(usize),
) -> Flight {
    for (flown, sample) in samples.enumerate() {
        if let Some(output) = probe.push(&sample) {
            flight.put(&output);
        }
        let budget = if pace == Pace::OfADesk { u32::MAX } else { probe.poll_budget() };
        flight.reports.extend(probe.poll(budget));
        flight.diagnoses.extend(probe.take_diagnosis());
        progress(flown + 1);
    }
    flight.ended(&mut probe);
    flight
}
