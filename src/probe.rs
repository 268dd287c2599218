//! The whole pipeline behind two calls: [`Probe::push`] for every sample, [`Probe::poll`] whenever there is time.

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
    sample::{Reading, Sample, SampleFlags},
};
use nalgebra::Vector3;
use output::count;
use rail::Rail;
use readings::STALE_INERTIAL_PART;
use staleness::Staleness;
use survey::Calibrated;

/// Units of work in a second (a unit is some 300 instructions, of a diagnosis up to 500): 29 to 48 % of a Cortex-M4F at 168 MHz while there is
/// work.
const WORK_UNITS_PER_SECOND: u32 = 160_000;

/// A step of time over this many nominal periods is a gap.
pub const GAP_PERIODS: u32 = 3;

/// A longer gap is believed when two stamps in a row say so, microseconds. It leaves nothing of the attitude
/// (half a turn at the 0.3 rad/s that are assumed where no rate is read), so the sample that it takes costs
/// little; and a wrong stamp that is believed makes all samples old until it is reached, which so takes no
/// longer than this.
const UNCONFIRMED_GAP_US: u64 = 10_000_000;

/// The pipeline. All buffers are inside; [`Probe::new`] is all zero bytes, so that a `static` of it costs no flash.
pub struct Probe {
    configured: bool,
    samples_per_second: u32,
    config: Config,
    counters: Counters,
    /// Time of the last sample; 0 samples mean none.
    last_us: u64,
    /// Time of the sample before, which was too far ahead to be believed alone; 0: it was not.
    doubted_us: u64,
    /// Time of validity of the last output.
    last_valid_us: u64,
    last_raw_rad_s: [f32; 3],
    /// How long no rate has been read that can be believed, seconds.
    unread_s: f32,
    /// Gyro, accelerometer, magnetometer.
    staleness: [Staleness; 3],
    gyro_rails: [Rail; 3],
    filter: AttitudeFilter,
    identifier: Identifier,
    library: Option<&'static [&'static dyn Effect]>,
    /// Compensated rate of the sample before, for the angular acceleration.
    last_rate_rad_s: Option<Vector3<f32>>,
    square_force_m2_s4: f32,
    /// Specific force and temperature over the effects' reference of the last sample.
    last_force_m_s2: Vector3<f32>,
    last_warming_k: f32,
    /// What is taken out of the readings for the attitude.
    attitude_effects: ActiveEffects,
    watch: HardIronWatch,
    /// Of the last sample, for surveys.
    calibrated: Calibrated,
}

impl Probe {
    /// An unconfigured probe.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            configured: false,
            samples_per_second: 0,
            config: Config::UNSET,
            counters: Counters {
                samples: 0,
                out_of_order: 0,
                gaps: 0,
                clipped: 0,
                gyro_missing: 0,
                overruns: 0,
                reports_lost: 0,
                diagnoses_lost: 0,
                increments_lost: 0,
            },
            last_us: 0,
            doubted_us: 0,
            last_valid_us: 0,
            last_raw_rad_s: [0.0; 3],
            unread_s: 0.0,
            staleness: [Staleness::zero(); 3],
            gyro_rails: [Rail::zero(); 3],
            filter: AttitudeFilter::new(),
            identifier: Identifier::zero(),
            library: None,
            last_rate_rad_s: None,
            square_force_m2_s4: 0.0,
            last_force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            last_warming_k: 0.0,
            attitude_effects: ActiveEffects::none(),
            watch: HardIronWatch::zero(),
            calibrated: Calibrated::NONE,
        }
    }

    /// Checks the configuration and starts afresh from it.
    ///
    /// # Errors
    /// The field that cannot be used; the probe then stays as it was.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = *config;
        self.samples_per_second = 1_000_000_u32.checked_div(config.sample_period_us).unwrap_or(0);
        self.counters = Counters::default();
        self.doubted_us = 0;
        self.last_valid_us = 0;
        self.last_raw_rad_s = config.gyro.b_rad_s;
        self.unread_s = 0.0;
        self.staleness = [Staleness::zero(); 3];
        self.gyro_rails = [Rail::zero(); 3];
        self.filter.start(&config.attitude, &config.earth);
        self.filter.mag_delay_known(self.mag_delay_sigma_s());
        self.filter.gyro_delay_known(config.latency.gyro_s.is_some());
        self.identifier.configure(config, self.library());
        self.last_rate_rad_s = None;
        self.attitude_effects = ActiveEffects::none();
        (self.last_force_m_s2, self.last_warming_k) = (Vector3::zeros(), 0.0);
        self.square_force_m2_s4 = config.earth.gravity_m_s2 * config.earth.gravity_m_s2;
        self.watch.configure(config);
        self.configured = true;
        Ok(())
    }

    /// Takes one sample. `None`: not configured, or a sample that is not taken (counted): its time does not
    /// increase, or is more than ten seconds after that of the last, and the sample before said nothing of
    /// the kind. Of two such stamps in a row, ten seconds apart at most, the later begins a new time base,
    /// after a gap. A clock that goes back for good needs [`Probe::configure`].
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        self.mark_clipped(&mut sample);
        let first = self.counters.samples == 0;
        if !first && sample.t_us <= self.last_us {
            count(&mut self.counters.out_of_order);
            return None;
        }
        let step_us = sample.t_us - if first { sample.t_us } else { self.last_us };
        let doubted_us = core::mem::replace(&mut self.doubted_us, 0);
        let is_confirmed = doubted_us > 0 && doubted_us < sample.t_us && sample.t_us - doubted_us <= UNCONFIRMED_GAP_US;
        if step_us > UNCONFIRMED_GAP_US && !is_confirmed {
            self.doubted_us = sample.t_us;
            count(&mut self.counters.out_of_order);
            return None;
        }
        let gap = step_us > u64::from(GAP_PERIODS * self.config.sample_period_us);
        if first {
            self.identifier.start(sample.t_us);
            self.watch.start(sample.t_us);
        } else if gap {
            count(&mut self.counters.gaps);
            self.identifier.gap(self.last_us, sample.t_us);
            self.watch.gap(sample.t_us);
        }
        self.last_us = sample.t_us;
        self.counters.samples += 1;

        self.take_effect(sample.t_us);
        let mut flags = self.flags(&sample);
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        if !missing {
            self.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let gyro = if missing {
            Reading::Missing
        } else if sample.flags.contains(SampleFlags::GYRO_CLIPPED) || self.is_stale(0, STALE_INERTIAL_PART) {
            Reading::Clipped
        } else {
            Reading::Good(raw)
        };
        let vectors = [self.vector(1, &sample), self.vector(2, &sample)];
        let [accel, mut mag] = self.at_gyro_time(vectors, &raw, step_us as f32 * 1e-6);
        self.watch(sample.t_us, [gyro, accel], &mut mag);
        let compensated = self.identifier.flown().compensate(raw.into());
        let before = self.last_rate_rad_s.unwrap_or(compensated);
        let moment = self.corrected(&sample, &compensated, [accel, mag], step_us as f32 * 1e-6);
        let rate = moment.rate_rad_s;

        let step_s = step_us as f32 * 1e-6;
        if gap {
            self.filter.gap(step_s);
            flags.insert(AttitudeFlags::AFTER_GAP);
            self.unread_s = 0.0;
        } else {
            // Between readings whose time is known the rate changes linearly. Others are taken for means over the interval that
            // they end: see `Latency::gyro_s`. A delay that was found is the whole of it.
            let is_found = self.effects().gyro_delay_s(self.library()) != 0.0;
            let held = if is_found || self.config.latency.gyro_s.is_some() { 0.5 } else { 0.0 };
            self.filter.propagate(step_s, &(rate + (before - compensated) * held));
        }
        if let Reading::Good(_) = gyro {
            self.unread_s = 0.0;
        } else if !gap {
            self.unread_s += step_s;
            self.filter.unread(step_s, self.unread_s);
        }
        let if_good = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Good(_)).then_some(v);
        self.filter.observe(if_good(&accel, moment.force_m_s2).as_ref(), if_good(&mag, moment.field_ut).as_ref());
        self.calibrated = Calibrated::of(&sample, [gyro, accel, mag], &moment);
        let is_warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let warming_k = is_warm.then_some(sample.temperature_c - REFERENCE_TEMPERATURE_C);
        // As they were read: the estimator takes out by itself what it has found.
        self.identifier.push(sample.t_us, [gyro, accel, mag], warming_k);

        let delay_s = self.effects().gyro_delay_s(self.library()) + self.config.latency.gyro_s.unwrap_or(0.0);
        // A gyro before its time is two late vector sensors: no output is valid later than its sample.
        let t_us = sample.t_us.saturating_sub((delay_s * 1e6) as u64);
        // A delay that has just been found must not turn time back.
        let t_us = if first || t_us > self.last_valid_us { t_us } else { self.last_valid_us.saturating_add(1) };
        self.last_valid_us = t_us;
        Some(Output { t_us, rate_rad_s: rate.into(), attitude: self.filter.attitude(flags) })
    }

    /// Does about `budget` units of identification work (a unit is some 300 instructions; the last piece may overshoot by
    /// 500) and hands out the report of a window whose result has taken effect, or of one that has none. Results do not depend on how the
    /// work is sliced, only on whether it is done when the result is due. Else the update is a counted overrun, and what flies stays.
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

    /// Sets the effects that are looked for from the next [`Probe::configure`] on; without a call they are those of [`LIBRARY`](crate::compensation::effects::LIBRARY).
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.library = Some(library);
    }

    /// The oldest diagnosis that nobody has taken, since it took effect.
    pub fn take_diagnosis(&mut self) -> Option<DiagnosisReport> {
        self.identifier.take_diagnosis()
    }

    /// The budget that every host and firmware loop gives [`Probe::poll`] after each sample, so that every result is ready when it is due.
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
