//! One run of the pipeline over a trace.

pub mod configuration;
pub mod estimate;
pub mod through_sensors;
mod spooled_output;
mod watched;

use meerkat_mwd::{
    Config, Probe, Sample,
    compensation::{ActiveEffects, Effect, FoundEffect, GyroModel, effects::LIBRARY},
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
    trace::{Trace, seconds, spool::Spool},
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
    /// Models that flew, in order; those between windows too. Empty where only the windows are known, as of a flight on
    /// the emulated chip.
    pub models: Vec<Flying>,
    /// Samples that the probe refused for their time: place among all samples, and time in microseconds.
    pub refused: Vec<(usize, u64)>,
}

/// Models that fly from a sample on.
#[derive(Clone, Debug, PartialEq)]
pub struct Flying {
    /// Time of that sample, microseconds.
    pub from_us: u64,
    /// Model of the gyro.
    pub gyro: GyroModel,
    effects: Vec<FoundEffect>,
}

impl Flying {
    /// Models with which a probe has flown its last sample.
    #[must_use]
    pub fn of(probe: &Probe, sample: &Sample) -> Self {
        let effects = probe.effects().iter().copied().collect();
        Self { from_us: sample.t_us, gyro: *probe.gyro_model(), effects }
    }

    /// Effects that are taken out.
    #[must_use]
    pub fn effects(&self) -> ActiveEffects {
        let mut active = ActiveEffects::none();
        for effect in &self.effects {
            active.add(*effect);
        }
        active
    }

    fn flies_in(&self, probe: &Probe) -> bool {
        self.gyro == *probe.gyro_model() && self.effects.iter().eq(probe.effects().iter())
    }
}

impl Flight {
    /// A flight over `trace`, before its first sample. Its outputs are where the rows of the trace are.
    #[must_use]
    pub fn before(trace: &Trace) -> Self {
        Self { spooled: trace.is_spooled().then(Spool::default), ..Self::default() }
    }

    /// Takes in a sample that a probe has flown, with its output; without one the probe refused it for its time.
    pub fn flown(&mut self, probe: &Probe, sample: &Sample, output: Option<&Output>) {
        let Some(output) = output else {
            return self.refused.push((self.output_count() + self.refused.len(), sample.t_us));
        };
        if !self.models.last().is_some_and(|last| last.flies_in(probe)) {
            self.models.push(Flying::of(probe, sample));
        }
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

    /// The outputs, one a sample: `None` for one that was refused.
    pub fn by_sample(&self) -> impl Iterator<Item = Option<Output>> + '_ {
        let (mut outputs, mut refused) = (self.outputs(), self.refused.iter().peekable());
        (0_usize..).map_while(move |place| match refused.next_if(|(at, _)| *at == place) {
            Some(_) => Some(None),
            None => outputs.next().map(Some),
        })
    }

    /// Rows of a file with one row a sample: without any number for one that was refused.
    pub fn rows(&self) -> impl Iterator<Item = Output> + '_ {
        let mut refused = self.refused.iter();
        self.by_sample().map(move |output| {
            output.unwrap_or_else(|| {
                let t_us = refused.next().map_or(0, |(_, t_us)| *t_us);
                Output { t_us, rate_rad_s: [f32::NAN; 3], attitude: None }
            })
        })
    }

    /// Adds to the trace's notes how many of its samples were refused.
    pub fn note_refused(&self, trace: &mut Trace) {
        if let Some((_, first_us)) = self.refused.first() {
            let (count, first) = (self.refused.len(), seconds(*first_us));
            trace.notes.push(format!(
                "{count} samples refused for their time, the first at {first} s: it is more than 10 s after the sample before"
            ));
        }
    }

    /// Model of the gyro that flies at the end; `None`: none but the factory's ever flew.
    #[must_use]
    pub fn last_model(&self) -> Option<&GyroModel> {
        let of_windows = || self.reports.last().map(|report| &report.flown);
        self.models.last().map(|last| &last.gyro).or_else(of_windows)
    }

    /// Takes models and refused samples from a flight of the same samples elsewhere, if its rates are the same bits.
    pub fn completed_by(&mut self, same: Self) {
        let bits = |flight: &Self| -> Vec<_> {
            flight.outputs().map(|output| (output.t_us, output.rate_rad_s.map(f32::to_bits))).collect()
        };
        if bits(self) == bits(&same) {
            (self.models, self.refused) = (same.models, same.refused);
        }
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
        let output = probe.push(&sample);
        flight.flown(&probe, &sample, output.as_ref());
        let budget = if pace == Pace::OfADesk { u32::MAX } else { probe.poll_budget() };
        flight.reports.extend(probe.poll(budget));
        flight.diagnoses.extend(probe.take_diagnosis());
        progress(flown + 1);
    }
    flight.ended(&mut probe);
    flight
}
