//! The probe: the whole pipeline behind [`Probe::push`] for every sample and [`Probe::poll`] for spare time.

mod effects;
mod latency;
mod output;
mod queries;
mod rail;
mod readings;
mod staleness;
#[cfg(feature = "storage")]
mod stored_model;
mod survey;

pub use output::{Counters, Output};
pub use readings::CLIPPED_SHARE;
#[cfg(feature = "storage")]
pub use stored_model::NotRestored;

use crate::{
    attitude::{AttitudeFilter, AttitudeFlags},
    compensation::{ActiveEffects, Effect, effect::REFERENCE_TEMPERATURE_C},
    config::{Config, ConfigError},
    diagnosis::DiagnosisReport,
    identification::{Identifier, WindowReport},
    magnet::HardIronWatch,
    sample::{Reading, Sample, SampleFlags, Sensor},
};
use nalgebra::Vector3;
use output::count;
use rail::Rail;
use readings::BySensor;
use staleness::Staleness;
use survey::Calibrated;

/// Identification work budgeted per second, in units of some 300 instructions (up to 500 in a diagnosis): 29
/// to 48 % of a Cortex-M4F at 168 MHz while there is work.
const WORK_UNITS_PER_SECOND: u32 = 160_000;

/// Step of time that counts as a gap, in nominal sample periods.
pub const GAP_PERIODS: u32 = 3;

/// The pipeline, with all its buffers. [`Probe::new`] is all zero bytes, so that a `static` of it takes no
/// flash.
pub struct Probe {
    configured: bool,
    config: Config,
    samples_per_second: u32,
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
    /// Time of validity of the last output.
    last_valid_us: u64,
    last_raw_rad_s: [f32; 3],
    /// Time since the last believable rate, seconds.
    unread_s: f32,
    staleness: BySensor<Staleness>,
    gyro_rails: [Rail; 3],
    /// Compensated rate of the previous sample, for the angular acceleration.
    last_rate_rad_s: Option<Vector3<f32>>,
    square_force_m2_s4: f32,
    /// Specific force of the last sample, and its temperature over the effects' reference.
    last_force_m_s2: Vector3<f32>,
    last_warming_k: f32,
    /// Effects taken out of the readings before the attitude filter.
    attitude_effects: ActiveEffects,
    /// Readings of the last sample, for surveys.
    calibrated: Calibrated,
}

impl Session {
    /// All zero, for a static.
    const ZERO: Self = Self {
        counters: Counters::ZERO,
        last_us: 0,
        last_valid_us: 0,
        last_raw_rad_s: [0.0; 3],
        unread_s: 0.0,
        staleness: BySensor { gyro: Staleness::zero(), accel: Staleness::zero(), mag: Staleness::zero() },
        gyro_rails: [Rail::zero(); 3],
        last_rate_rad_s: None,
        square_force_m2_s4: 0.0,
        last_force_m_s2: Vector3::new(0.0, 0.0, 0.0),
        last_warming_k: 0.0,
        attitude_effects: ActiveEffects::none(),
        calibrated: Calibrated::NONE,
    };

    /// A gyro that reads nothing is taken to rest at its factory bias, a force that is not read to be gravity.
    fn new(config: &Config) -> Self {
        let gravity = config.earth.gravity_m_s2;
        Self { last_raw_rad_s: config.gyro.b_rad_s, square_force_m2_s4: gravity * gravity, ..Self::ZERO }
    }
}

impl Probe {
    /// Returns a probe without a configuration.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            configured: false,
            config: Config::UNSET,
            samples_per_second: 0,
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
        self.samples_per_second = 1_000_000_u32.checked_div(config.sample_period_us).unwrap_or(0);
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

    /// Takes one sample. Returns `None` before a configuration, and for a sample whose time does not increase
    /// (counted). One timestamp far ahead blocks all samples until that time; [`Probe::configure`] recovers.
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        self.mark_clipped(&mut sample);
        let first = self.session.counters.samples == 0;
        if !first && sample.t_us <= self.session.last_us {
            count(&mut self.session.counters.out_of_order);
            return None;
        }
        let step_us = sample.t_us - if first { sample.t_us } else { self.session.last_us };
        let gap = step_us > u64::from(GAP_PERIODS * self.config.sample_period_us);
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
        let mut flags = self.flags(&sample);
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        if !missing {
            self.session.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.session.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let gyro = if missing {
            Reading::Missing
        } else if sample.flags.contains(SampleFlags::GYRO_CLIPPED) || self.is_stale(Sensor::Gyro) {
            Reading::Unusable
        } else {
            Reading::Usable(raw)
        };
        let accel = self.vector(Sensor::Accelerometer, &self.config.accel, &sample);
        let mag = self.vector(Sensor::Magnetometer, &self.config.mag, &sample);
        let [accel, mut mag] = self.at_gyro_time([accel, mag], &raw, step_us as f32 * 1e-6);
        self.watch(sample.t_us, [gyro, accel], &mut mag);
        let compensated = self.identifier.flown().compensate(raw.into());
        let before = self.session.last_rate_rad_s.unwrap_or(compensated);
        let moment = self.corrected(&sample, &compensated, [accel, mag], step_us as f32 * 1e-6);
        let rate = moment.rate_rad_s;

        let step_s = step_us as f32 * 1e-6;
        if gap {
            self.filter.gap(step_s);
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
        let if_good = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Usable(_)).then_some(v);
        self.filter.observe(if_good(&accel, moment.force_m_s2).as_ref(), if_good(&mag, moment.field_ut).as_ref());
        self.session.calibrated = Calibrated::of(&sample, [gyro, accel, mag], &moment);
        let is_warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let warming_k = is_warm.then_some(sample.temperature_c - REFERENCE_TEMPERATURE_C);
        // Uncorrected: the estimator takes out by itself what it has found.
        self.identifier.push(sample.t_us, [gyro, accel, mag], warming_k);

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
        match WORK_UNITS_PER_SECOND.checked_div(self.samples_per_second) {
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
