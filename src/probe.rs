//! The probe: the whole pipeline behind [`Probe::push`] for every sample and [`Probe::poll`] for spare time.

mod attitude_probe;
mod corrector;
mod latency;
mod output;
mod pipeline;
mod rail;
mod reading_checks;
mod session;
mod staleness;
#[cfg(feature = "storage")]
mod stored_model;
mod survey;

pub use attitude_probe::AttitudeProbe;
pub use output::{Counters, Output};
pub use reading_checks::CLIPPED_SHARE;
#[cfg(feature = "storage")]
pub use stored_model::NotRestored;

pub use crate::time_step::GAP_PERIODS;

#[cfg(feature = "explanation")]
use crate::estimator::Estimator;
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel, effect::REFERENCE_TEMPERATURE_C, effects::LIBRARY},
    config::{Config, ConfigError, micros},
    diagnosis::DiagnosisReport,
    estimator::{EFFECTS, WINDOW_NODES},
    identification::{Identifier, WindowCost, WindowReport},
    magnet::{HardIronCounts, HardIronInterval},
    sample::{Sample, SampleFlags, TurnFlags},
};
use corrector::Found;
use latency::mag_delay_sigma_s;
use output::count;
use pipeline::{Pipeline, With};
use session::{Session, Stamp};

/// Processor cycles budgeted for each unit of identification work. A unit takes up to
/// [`UNIT_CYCLES`](crate::estimator::UNIT_CYCLES), so that this work takes at most 48 % of the time.
const CLOCK_CYCLES_PER_UNIT: u32 = 1_050;

/// Clock of the STM32F405, Hz.
const USUAL_CLOCK_HZ: u32 = 168_000_000;

/// Default room for reports of windows, and for as many on their effects, that wait to be taken.
pub const PENDING_REPORTS: usize = 2;

/// The pipeline, with all its buffers. [`Probe::new`] is all zero bytes, so that a `static` of it takes no
/// flash.
///
/// A program with less memory chooses smaller buffers, and starts from [`Probe::zero`] (docs/new_board.md has the
/// sizes):
/// - `NODES`: nodes kept for the population search of a window, 166 bytes each. The search reads the latest of them; 0
///   leaves it out, and the posterior's mean flies.
/// - `COLUMNS`: parameters of effects, and of the bias's steps, that are looked for at a time, 636 bytes each. An
///   effect for which there is no column left is not looked for.
/// - `REPORTS`: reports that wait for [`Probe::poll`] and [`Probe::take_diagnosis`], 1.7 KB each. Without room a report
///   is lost, and counted.
pub struct Probe<
    const NODES: usize = WINDOW_NODES,
    const COLUMNS: usize = EFFECTS,
    const REPORTS: usize = PENDING_REPORTS,
> {
    configured: bool,
    config: Config,
    library: Option<&'static [&'static dyn Effect]>,
    /// Library that the next configuration takes. Effects are known by their place in the library, so that it must not
    /// change while they fly.
    next_library: Option<&'static [&'static dyn Effect]>,
    session: Session,
    pipeline: Pipeline<Found>,
    identifier: Identifier<NODES, COLUMNS, REPORTS>,
}

impl Probe {
    /// Returns a probe without a configuration.
    #[must_use]
    pub const fn new() -> Self {
        Self::zero()
    }
}

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Probe<NODES, COLUMNS, REPORTS> {
    /// Returns a probe without a configuration, of the capacities that its type names.
    #[must_use]
    pub const fn zero() -> Self {
        Self {
            configured: false,
            config: Config::UNSET,
            library: None,
            next_library: None,
            session: Session::ZERO,
            pipeline: Pipeline::zero(),
            identifier: Identifier::zero(),
        }
    }

    /// Checks a configuration and starts anew from it: everything learnt, found or counted before is
    /// forgotten, and a library set by [`Probe::set_library`] takes effect.
    ///
    /// # Errors
    /// Names the field that cannot be used; the probe then stays as it was.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = *config;
        self.library = self.next_library;
        self.session = Session::ZERO;
        self.identifier.configure(config, self.library());
        self.pipeline.start(config);
        // After the identifier's reset: its effects say how well the magnetometer's delay is known.
        self.pipeline.filter.mag_delay_known(self.mag_delay_sigma_s());
        self.configured = true;
        Ok(())
    }

    /// Takes one sample. Returns `None` before a configuration, and for a sample that is refused (and counted): its
    /// time does not increase, or is more than ten seconds after the last accepted sample's. Of two such late stamps in
    /// a row, at most ten seconds apart, the second is accepted, as after a gap. If the clock goes back by more than
    /// ten seconds, the second stamp is accepted in the same way, and the probe begins afresh
    /// ([`Probe::began_afresh`]); if by less, samples are refused until the old time is reached again.
    // Inlined, its stack frame would lie under all work between samples.
    #[inline(never)]
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        self.pipeline.checks.mark_clipped(&mut sample, &self.config.full_scale);
        match self.session.judge(sample.t_us) {
            Stamp::Refused => return None,
            Stamp::OfEarlierClock => self.begin_afresh(),
            Stamp::Later => {}
        }
        let step = self.session.step(sample.t_us, self.config.sample_period_us);
        if step.is_first {
            self.identifier.start(sample.t_us);
            self.pipeline.watch.start(sample.t_us);
        } else if step.is_gap {
            count(&mut self.session.counters.gaps);
            self.identifier.gap(self.session.last_us, sample.t_us, step.refused_s - step.seconds);
            self.pipeline.watch.gap(sample.t_us);
        }
        self.session.last_us = sample.t_us;
        self.session.counters.samples += 1;

        self.take_effect(sample.t_us);
        if sample.t_us >= self.identifier.freeze_us() {
            self.pipeline.watch.freeze();
        }
        if self.session.look_due_us > 0 && sample.t_us >= self.session.look_due_us {
            self.session.look_due_us = 0;
            if let Some(known) = self.identifier.known_attitude() {
                self.pipeline.filter.compare(known);
            }
        }
        self.count_faults(&sample);
        let found_s = self.effects().gyro_delay_s(self.library());
        let with = With {
            config: &self.config,
            model: self.identifier.flown(),
            library: self.library(),
            gyro_delay_known: found_s != 0.0 || self.config.latency.gyro_s.is_some(),
            step_s: step.seconds,
            gap_s: step.gap_s(),
        };
        let stepped = self.pipeline.step(&sample, &with);
        if self.pipeline.watch.own_iron_changed() && self.identifier.forget_iron() {
            self.pipeline.watch.own_iron_forgotten();
        }
        let is_warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let warming_k = is_warm.then_some(sample.temperature_c - REFERENCE_TEMPERATURE_C);
        // Readings uncorrected by effects: the estimator itself takes out the effects that it has found.
        let can_look = self.identifier.push(sample.t_us, stepped.readings, warming_k);
        if can_look && self.pipeline.filter.is_doubted() && self.session.look_due_us == 0 {
            self.identifier.look();
            self.pipeline.filter.mark();
            self.session.look_due_us = sample.t_us.saturating_add(micros(self.config.identification.latency_s));
        }

        let delay_s = found_s + self.config.latency.gyro_s.unwrap_or(0.0);
        // No output is valid later than its sample: a gyro that seems early means that both vector sensors are late.
        let t_us = sample.t_us.saturating_sub((delay_s * 1e6) as u64);
        // A delay found just now must not make the output's time go back.
        let t_us = self.session.valid_at(t_us, step.is_first);
        Some(Output {
            t_us,
            rate_rad_s: stepped.rate_rad_s.into(),
            attitude: self
                .pipeline
                .filter
                .attitude_by_corrected_force(stepped.flags, Some(&stepped.force_variances_m2_s4)),
        })
    }

    /// Starts anew from the present configuration after the clock went back. The counters go on, and a freeze stays.
    #[inline(never)]
    fn begin_afresh(&mut self) {
        let (config, counters, frozen_at_us) = (self.config, self.counters(), self.frozen_at_us());
        // This configuration was valid before.
        let _ = self.configure(&config);
        if let Some(at_us) = frozen_at_us {
            self.freeze(at_us);
        }
        self.session.begin_afresh(counters);
    }

    /// Lets an update that is due take effect before a sample is compensated: the gyro model, and the effects
    /// with it.
    // Inlined, its reports would lie on the stack under all work on a sample.
    #[inline(never)]
    fn take_effect(&mut self, t_us: u64) {
        if !self.identifier.is_due(t_us) {
            return;
        }
        let before = self.pipeline.corrector.taken_out.model_here(self.identifier.flown(), self.library());
        let Some(taken) = self.identifier.take_effect(t_us, &self.config) else { return };
        if taken.effects {
            self.pipeline.corrector.taken_out.effects = self.effects().of_attitude(self.library());
        }
        if taken.is_window || self.mag_delay_sigma_s().is_none() {
            // A delay just found counts as known only from the next window on, so that the heading does not depend on
            // it yet.
            self.pipeline.filter.mag_delay_known(self.mag_delay_sigma_s());
        }
        if taken.of_field {
            self.pipeline.filter.field_changed();
        }
        let after = self.pipeline.corrector.taken_out.model_here(self.identifier.flown(), self.library());
        self.pipeline.filter.model_changed(&before, &after, &taken.sigma);
    }

    fn count_faults(&mut self, sample: &Sample) {
        let clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        if sample.flags.intersects(clipped) {
            count(&mut self.session.counters.clipped);
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            count(&mut self.session.counters.gyro_missing);
        }
    }

    fn mag_delay_sigma_s(&self) -> Option<f32> {
        mag_delay_sigma_s(self.effects(), self.library(), &self.config.latency)
    }

    /// Does about `budget` units of identification work: a unit takes up to 500 cycles of a Cortex-M4F. The last piece
    /// may overshoot by 650 units; the next calls do so many fewer. Returns the report of a window when its result has
    /// taken effect, or when there is no result. Results depend only on whether the work is done when they are due, not
    /// on how it is divided into calls. An update that is late is counted as an overrun, and the flown model stays.
    pub fn poll(&mut self, budget: u32) -> Option<WindowReport> {
        let mut spent = self.session.overspent;
        while spent < budget {
            let units = self.identifier.step(&self.config);
            if units == 0 {
                break;
            }
            spent = spent.saturating_add(units);
        }
        self.session.overspent = spent.saturating_sub(budget);
        self.identifier.take_report()
    }

    /// Lets nothing new take effect after an instant of the samples' time, for a part that is held out: the last window
    /// ends [`latency_s`](crate::config::IdentificationConfig::latency_s) before it, and its result lands on it. A
    /// magnet that comes later is taken out only if it was known before. Call it after [`Probe::configure`] and two
    /// latencies ahead; it lasts until the next configuration.
    pub fn freeze(&mut self, at_us: u64) {
        self.identifier.freeze(at_us);
    }

    /// Accepts no P while the sensors do not agree on these turns, as found by a
    /// [`MountingCheck`](crate::sensors::MountingCheck), and grades no survey good. Call it with every sample: a new
    /// configuration, and a clock that goes back, forget it.
    pub const fn mistrust_mounting(&mut self, wrong: TurnFlags) {
        self.identifier.mistrust_mounting(wrong);
    }

    /// Sets the library of effects that takes effect with the next [`Probe::configure`], with a restart or when the
    /// clock goes back. The default is [`LIBRARY`].
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.next_library = Some(library);
    }

    /// Takes the oldest diagnosis that has taken effect and was not taken yet.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.identifier.take_diagnosis()
    }

    /// Budget for [`Probe::poll`] after each sample, in units, with which every result is ready when it is due, on a
    /// chip of 168 MHz.
    #[must_use]
    pub const fn poll_budget(&self) -> u32 {
        self.poll_budget_at(USUAL_CLOCK_HZ)
    }

    /// Budget for [`Probe::poll`] after each sample, in units of work, on a chip that runs at `clock_hz`. From 64 MHz
    /// on nothing of the bundled recordings is late; what is late is counted.
    #[must_use]
    pub const fn poll_budget_at(&self, clock_hz: u32) -> u32 {
        let Some(samples_per_second) = 1_000_000_u32.checked_div(self.config.sample_period_us) else { return 0 };
        match (clock_hz / CLOCK_CYCLES_PER_UNIT).checked_div(samples_per_second) {
            Some(units) => units,
            None => 0,
        }
    }

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
    #[inline(never)]
    pub const fn counters(&self) -> Counters {
        let [reports_lost, overruns] = self.identifier.reports_lost_and_overruns();
        // The session's counters hold what was counted before the clock went back.
        let before = self.session.counters;
        Counters {
            overruns: before.overruns.saturating_add(overruns),
            reports_lost: before.reports_lost.saturating_add(reports_lost),
            diagnoses_lost: before.diagnoses_lost.saturating_add(self.identifier.diagnoses_lost()),
            increments_lost: before.increments_lost.saturating_add(self.identifier.increments_lost()),
            ..before
        }
    }

    /// Gyro model in use.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        self.identifier.flown()
    }

    /// Sample from which this gyro model is in use, microseconds; `None`: since the start.
    #[must_use]
    pub const fn model_since_us(&self) -> Option<u64> {
        self.identifier.flown_since_us()
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

    /// Takes an interval of [`Probe::hard_iron_intervals`] when it has begun, and again when it has ended.
    pub fn take_hard_iron_interval(&mut self) -> Option<HardIronInterval> {
        self.pipeline.watch.take_interval()
    }

    /// Counters of the watch for magnets since the configuration.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.pipeline.watch.counts()
    }
}

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Default for Probe<NODES, COLUMNS, REPORTS> {
    fn default() -> Self {
        Self::zero()
    }
}

#[cfg(test)]
mod tests;
