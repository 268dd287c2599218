//! The probe: the whole pipeline behind [`Probe::push`] for every sample and [`Probe::poll`] for spare time.

mod attitude_probe;
mod corrector;
mod latency;
mod output;
mod queries;
mod rail;
mod reading_checks;
mod staleness;
#[cfg(feature = "storage")]
mod stored_model;
mod survey;

pub use attitude_probe::AttitudeProbe;
pub use output::{Counters, Output};
pub use reading_checks::CLIPPED_SHARE;
#[cfg(feature = "storage")]
pub use stored_model::NotRestored;

use crate::{
    attitude::{AttitudeFilter, AttitudeFlags},
    compensation::{Effect, effect::REFERENCE_TEMPERATURE_C},
    config::{Config, ConfigError, micros},
    diagnosis::DiagnosisReport,
    identification::{Identifier, WindowReport},
    magnet::{FieldUse, HardIronWatch},
    sample::{Reading, Sample, SampleFlags, Sensor},
};
use corrector::Corrector;
use latency::{at_gyro_time, mag_delay_sigma_s};
use nalgebra::Vector3;
use output::count;
use reading_checks::ReadingChecks;
use survey::Calibrated;

/// Identification work budgeted per second, in units of some 300 instructions (up to 500 in a diagnosis): 29
/// to 48 % of a Cortex-M4F at 168 MHz while there is work.
const WORK_UNITS_PER_SECOND: u32 = 160_000;

/// Step of time that counts as a gap, in nominal sample periods; and refused samples in a row that do.
pub const GAP_PERIODS: u32 = 3;

/// Longest gap that one timestamp is believed, microseconds; a longer one needs two stamps in a row. It leaves nothing
/// of the attitude (half a turn at the 0.3 rad/s that are assumed where no rate is read), so the sample that it
/// costs is worth little, and a wrong stamp that is believed makes samples old for no longer than this.
const UNCONFIRMED_GAP_US: u64 = 10_000_000;

/// The pipeline, with all its buffers. [`Probe::new`] is all zero bytes, so that a `static` of it takes no
/// flash.
pub struct Probe {
    configured: bool,
    config: Config,
    library: Option<&'static [&'static dyn Effect]>,
    /// Library of the next configuration: effects are told by their place in it, so that it must not change
    /// in flight.
    next_library: Option<&'static [&'static dyn Effect]>,
    session: Session,
    filter: AttitudeFilter,
    identifier: Identifier,
    watch: HardIronWatch,
}

/// State that a probe gathers from samples, apart from the parts that reset themselves. It dies with the
/// configuration, as one value.
struct Session {
    counters: Counters,
    /// Time of the last sample; meaningless while no sample is counted.
    last_us: u64,
    /// Time of the sample before, which was too far from the last one to be believed alone; 0: it was not.
    doubted_us: u64,
    /// Samples refused since the last one.
    refused: u32,
    /// True from the first sample of a time base on; false in a static.
    has_begun: bool,
    /// True if the last sample began a new time base because the clock went back.
    began_afresh: bool,
    /// Time of validity of the last output.
    last_valid_us: u64,
    /// When the estimator's attitude is compared; 0: it was not asked for.
    look_due_us: u64,
    last_raw_rad_s: [f32; 3],
    /// Time since the last believable rate, seconds.
    unread_s: f32,
    checks: ReadingChecks,
    corrector: Corrector,
    /// Readings of the last sample, for surveys.
    calibrated: Calibrated,
}

impl Session {
    /// All zero, for a static.
    const ZERO: Self = Self {
        counters: Counters::ZERO,
        last_us: 0,
        doubted_us: 0,
        refused: 0,
        has_begun: false,
        began_afresh: false,
        last_valid_us: 0,
        look_due_us: 0,
        last_raw_rad_s: [0.0; 3],
        unread_s: 0.0,
        checks: ReadingChecks::ZERO,
        corrector: Corrector::ZERO,
        calibrated: Calibrated::NONE,
    };

    /// Creates a session before its first sample; a gyro that reads nothing is taken to rest at its factory bias.
    fn new(config: &Config) -> Self {
        Self {
            last_raw_rad_s: config.gyro.b_rad_s,
            checks: ReadingChecks::new(config),
            corrector: Corrector::new(config),
            ..Self::ZERO
        }
    }
}

impl Probe {
    /// Returns a probe without a configuration.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            configured: false,
            config: Config::UNSET,
            library: None,
            next_library: None,
            session: Session::ZERO,
            filter: AttitudeFilter::new(),
            identifier: Identifier::zero(),
            watch: HardIronWatch::zero(),
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
        self.session = Session::new(config);
        self.identifier.configure(config, self.library());
        self.watch.configure(config);
        self.filter.start(&config.attitude, &config.earth);
        // After the identifier's reset, whose effects say how well the delay is known.
        self.filter.mag_delay_known(self.mag_delay_sigma_s());
        self.filter.gyro_delay_known(config.latency.gyro_s.is_some());
        self.configured = true;
        Ok(())
    }

    /// Takes one sample. Returns `None` before a configuration, and for a sample that is not taken (counted): its time
    /// does not increase, or is more than ten seconds after the last one's and the sample before said nothing of the
    /// kind. Of two such stamps in a row, at most ten seconds apart, the later begins a new time base, after a gap.
    /// A clock that goes back for good is believed in the same way if by more than ten seconds, and is waited for
    /// if by less: the probe then begins afresh ([`Probe::began_afresh`]).
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        self.session.checks.mark_clipped(&mut sample, &self.config.full_scale);
        self.session.began_afresh = false;
        let last_us = if self.session.has_begun { self.session.last_us } else { sample.t_us };
        let is_far = sample.t_us.abs_diff(last_us) > UNCONFIRMED_GAP_US;
        let doubted_us = core::mem::replace(&mut self.session.doubted_us, 0);
        let is_confirmed = doubted_us > 0 && doubted_us < sample.t_us && sample.t_us - doubted_us <= UNCONFIRMED_GAP_US;
        let is_old = sample.t_us <= last_us && self.session.has_begun;
        if if is_far { !is_confirmed } else { is_old } {
            self.session.doubted_us = if is_far { sample.t_us } else { 0 };
            count(&mut self.session.counters.out_of_order);
            count(&mut self.session.refused);
            return None;
        }
        if is_old {
            self.begin_afresh();
        }
        let first = !self.session.has_begun;
        self.session.has_begun = true;
        let step_us = if first { 0 } else { sample.t_us - last_us };
        // While samples were refused time went by, whatever they said of it.
        let refused = core::mem::replace(&mut self.session.refused, 0);
        let gap = step_us > u64::from(GAP_PERIODS * self.config.sample_period_us)
            || refused > GAP_PERIODS && !first
            || self.session.began_afresh;
        if first {
            self.identifier.start(sample.t_us);
            self.watch.start(sample.t_us);
        } else if gap {
            count(&mut self.session.counters.gaps);
            self.identifier.gap(self.session.last_us, sample.t_us);
            self.watch.gap(sample.t_us);
        }
        self.session.last_us = sample.t_us;
        self.session.counters.samples += 1;

        self.take_effect(sample.t_us);
        if self.session.look_due_us > 0 && sample.t_us >= self.session.look_due_us {
            self.session.look_due_us = 0;
            if let Some(known) = self.identifier.known_attitude() {
                self.filter.compare(known);
            }
        }
        let mut flags = self.flags(&sample);
        if !sample.flags.contains(SampleFlags::GYRO_MISSING) {
            self.session.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.session.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let compensated = self.identifier.flown().compensate(raw.into());
        let step_s = step_us as f32 * 1e-6;
        let gyro = self.session.checks.rate(raw, &sample);
        let [accel, mag] = self.vectors(&sample, &compensated, step_s);
        let mag = self.without_magnets(sample.t_us, [gyro, accel, mag]);
        let before = self.session.corrector.last_rate_or(compensated);
        let library = self.library();
        let corrected = self.session.corrector.correct(library, &sample, &compensated, [accel, mag], step_s);
        let rate = corrected.rate_rad_s;

        if gap {
            let refused_s = refused as f32 * self.config.sample_period_us as f32 * 1e-6;
            self.filter.gap(if refused_s > step_s { refused_s } else { step_s });
            flags.insert(AttitudeFlags::AFTER_GAP);
            self.session.unread_s = 0.0;
        } else {
            // The rate changes linearly between readings of known time. A reading of unknown time counts as
            // the mean over the interval that it ends (see `Latency::gyro_s`). A delay that was found is all
            // of the delay.
            let is_found = self.effects().gyro_delay_s(self.library()) != 0.0;
            let held = if is_found || self.config.latency.gyro_s.is_some() { 0.5 } else { 0.0 };
            self.filter.propagate(step_s, &(rate + (before - compensated) * held));
        }
        if let Reading::Usable(_) = gyro {
            self.session.unread_s = 0.0;
        } else if !gap {
            self.session.unread_s += step_s;
            self.filter.unread(step_s, self.session.unread_s);
        }
        let if_usable = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Usable(_)).then_some(v);
        self.filter
            .observe(if_usable(&accel, corrected.force_m_s2).as_ref(), if_usable(&mag, corrected.field_ut).as_ref());
        self.session.calibrated = Calibrated::of(&sample, [gyro, accel, mag], &corrected);
        let is_warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let warming_k = is_warm.then_some(sample.temperature_c - REFERENCE_TEMPERATURE_C);
        // Uncorrected: the estimator takes out by itself what it has found.
        let can_look = self.identifier.push(sample.t_us, [gyro, accel, mag], warming_k);
        if can_look && self.filter.is_doubted() && self.session.look_due_us == 0 {
            self.identifier.look();
            self.filter.mark();
            self.session.look_due_us = sample.t_us.saturating_add(micros(self.config.identification.latency_s));
        }

        let delay_s = self.effects().gyro_delay_s(self.library()) + self.config.latency.gyro_s.unwrap_or(0.0);
        // No output is valid later than its sample: a gyro ahead of its time means two late vector sensors.
        let t_us = sample.t_us.saturating_sub((delay_s * 1e6) as u64);
        // A delay found just now must not turn time back.
        let t_us = if first || t_us > self.session.last_valid_us {
            t_us
        } else {
            self.session.last_valid_us.saturating_add(1)
        };
        self.session.last_valid_us = t_us;
        Some(Output { t_us, rate_rad_s: rate.into(), attitude: self.filter.attitude(flags) })
    }

    /// Starts anew from the present configuration after the clock went back. The counters go on.
    #[inline(never)]
    fn begin_afresh(&mut self) {
        let (config, counters) = (self.config, self.session.counters);
        // It was valid before.
        let _ = self.configure(&config);
        self.session.counters = counters;
        count(&mut self.session.counters.gaps);
        self.session.began_afresh = true;
    }

    /// Lets an update that is due take effect before a sample is compensated: the gyro model, and the effects
    /// with it.
    fn take_effect(&mut self, t_us: u64) {
        let before = self.session.corrector.model_here(self.identifier.flown(), self.library());
        let Some(taken) = self.identifier.take_effect(t_us, &self.config) else { return };
        if taken.effects {
            self.session.corrector.effects = self.effects().of_attitude(self.library());
        }
        if taken.is_window || self.mag_delay_sigma_s().is_none() {
            // A heading must not depend yet on a delay found a moment ago.
            self.filter.mag_delay_known(self.mag_delay_sigma_s());
        }
        if taken.of_field {
            self.filter.field_changed();
        }
        let after = self.session.corrector.model_here(self.identifier.flown(), self.library());
        self.filter.model_changed(&before, &after, &taken.sigma);
    }

    /// Counts the sample's faults and translates them into the attitude's flags.
    fn flags(&mut self, sample: &Sample) -> AttitudeFlags {
        let clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        let mut flags = AttitudeFlags::empty();
        if sample.flags.intersects(clipped) {
            count(&mut self.session.counters.clipped);
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            count(&mut self.session.counters.gyro_missing);
            flags.insert(AttitudeFlags::GYRO_HELD);
        }
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        flags.set(AttitudeFlags::FROZEN_SENSOR, self.session.checks.update(sample));
        flags
    }

    /// Returns the calibrated readings of accelerometer and magnetometer at the gyro's time; `rate` is
    /// compensated.
    fn vectors(&self, sample: &Sample, rate: &Vector3<f32>, step_s: f32) -> [Reading; 2] {
        let Session { checks, corrector, .. } = &self.session;
        let accel = checks.vector(Sensor::Accelerometer, &self.config.accel, sample);
        let mag = checks.vector(Sensor::Magnetometer, &self.config.mag, sample);
        let [accel_s, mag_s] = self.config.latency.behind_gyro_s();
        if accel_s == 0.0 && mag_s == 0.0 {
            return [accel, mag];
        }
        let acceleration = corrector.acceleration_rad_s2(rate, step_s);
        let rate = rate - self.filter.residual_bias_rad_s();
        [(accel, accel_s), (mag, mag_s)]
            .map(|(reading, behind_s)| at_gyro_time(reading, behind_s, &rate, &acceleration))
    }

    /// Returns the field less that of a magnet on the probe; the field is missing while the magnet is
    /// undecided.
    fn without_magnets(&mut self, t_us: u64, readings: [Reading; 3]) -> Reading {
        let [.., mag] = readings;
        if !self.config.effects {
            return mag;
        }
        self.watch.push(t_us, readings);
        match (mag, self.watch.field_use()) {
            (Reading::Usable(field), FieldUse::Less(offset)) => Reading::Usable(field - offset),
            (_, FieldUse::Withheld) => Reading::Missing,
            _ => mag,
        }
    }

    fn mag_delay_sigma_s(&self) -> Option<f32> {
        mag_delay_sigma_s(self.effects(), self.library(), &self.config.latency)
    }

    /// Does about `budget` units of identification work (a unit is some 300 instructions; the last piece may
    /// overshoot by 500). Returns the report of a window when its result has taken effect, or when it has
    /// none. Results depend on whether the work is done when they are due, and on nothing else of its
    /// slicing. An update that is late is counted as an overrun, and the flown model stays.
    pub fn poll(&mut self, budget: u32) -> Option<WindowReport> {
        let mut spent = 0;
        while spent < budget {
            let units = self.identifier.step(&self.config);
            if units == 0 {
                break;
            }
            spent += units;
        }
        self.identifier.take_report()
    }

    /// Sets the library of effects that takes effect with the next [`Probe::configure`]. The default is
    /// [`LIBRARY`](crate::compensation::effects::LIBRARY).
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.next_library = Some(library);
    }

    /// Takes the oldest diagnosis that has taken effect and was not taken yet.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.identifier.take_diagnosis()
    }

    /// Budget for [`Probe::poll`] after each sample with which every result is ready when it is due.
    #[must_use]
    pub const fn poll_budget(&self) -> u32 {
        match WORK_UNITS_PER_SECOND.checked_div(self.session.checks.samples_per_second()) {
            Some(units) => units,
            None => 0,
        }
    }
}

impl Default for Probe {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
