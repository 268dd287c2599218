//! The whole pipeline behind two calls: [`Probe::push`] for every sample, [`Probe::poll`] whenever there is time.

use crate::{
    attitude::{Attitude, AttitudeFilter, AttitudeFlags},
    compensation::GyroModel,
    config::{Config, ConfigError},
    identification::{Identifier, WindowReport},
    sample::{Sample, SampleFlags},
    window::Reading,
};
use nalgebra::Vector3;

/// Units of work that every host and firmware loop gives [`Probe::poll`] after each sample: a window at 30 Hz is ready in
/// time, and a slice is about 50,000 instructions (a third of a millisecond at 168 MHz).
pub const POLL_BUDGET: u32 = 128;

/// A step of time over this many nominal periods is a gap.
const GAP_PERIODS: u32 = 3;

/// Share of full scale from which a reading counts as clipped: a saturated 16-bit word can stand for as little as 99.9 % of
/// the nominal range (2,000 deg/s at 16.4 LSB per deg/s saturate at 1,998.0).
const CLIPPED_SHARE: f32 = 0.998;

/// What one sample gives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Compensated body rate relative to the earth, rad/s; the last one, where the gyro gave no reading.
    pub rate_rad_s: [f32; 3],
    /// Attitude; `None` until the first gravity reading has aligned it.
    pub attitude: Option<Attitude>,
}

/// Events counted since the start; nothing is lost without being counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counters {
    /// Samples taken.
    pub samples: u64,
    /// Samples refused because their time did not increase.
    pub out_of_order: u32,
    /// Steps in time over 3 nominal periods.
    pub gaps: u32,
    /// Samples with a clipped sensor.
    pub clipped: u32,
    /// Samples without a gyro reading (the last rate was held).
    pub gyro_missing: u32,
    /// Windows whose result was not ready in time.
    pub overruns: u32,
    /// Window reports dropped because nobody polled them.
    pub reports_lost: u32,
}

/// Counts how long a sensor has given the same reading.
#[derive(Clone, Copy)]
struct Staleness {
    last: [f32; 3],
    same: u32,
}

impl Staleness {
    const fn zero() -> Self {
        Self { last: [0.0; 3], same: 0 }
    }

    /// Whether the reading has been the same, on all axes, for more than `limit` samples.
    fn is_frozen(&mut self, reading: [f32; 3], limit: u32) -> bool {
        self.same = if reading == self.last { self.same.saturating_add(1) } else { 0 };
        self.last = reading;
        self.same > limit
    }
}

/// The pipeline. All buffers are inside; [`Probe::new`] is all zero bytes, so that a `static` of it costs no flash.
pub struct Probe {
    configured: bool,
    samples_per_second: u32,
    config: Config,
    counters: Counters,
    /// Time of the last sample; 0 samples mean none.
    last_us: u64,
    last_raw_rad_s: [f32; 3],
    frozen: [Staleness; 3],
    filter: AttitudeFilter,
    identifier: Identifier,
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
            },
            last_us: 0,
            last_raw_rad_s: [0.0; 3],
            frozen: [Staleness::zero(); 3],
            filter: AttitudeFilter::new(),
            identifier: Identifier::zero(),
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
        self.last_raw_rad_s = config.gyro.b_rad_s;
        self.frozen = [Staleness::zero(); 3];
        self.filter.start(&config.attitude, &config.earth);
        self.identifier.configure(config);
        self.configured = true;
        Ok(())
    }

    /// Takes one sample. `None`: not configured, or a sample whose time does not increase (counted).
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        self.mark_clipped(&mut sample);
        let first = self.counters.samples == 0;
        if !first && sample.t_us <= self.last_us {
            self.counters.out_of_order += 1;
            return None;
        }
        let step_us = sample.t_us - if first { sample.t_us } else { self.last_us };
        let gap = step_us > u64::from(GAP_PERIODS * self.config.sample_period_us);
        if first {
            self.identifier.start(sample.t_us);
        } else if gap {
            self.counters.gaps += 1;
            self.identifier.gap(self.last_us, sample.t_us);
        }
        self.last_us = sample.t_us;
        self.counters.samples += 1;

        if self.identifier.take_effect(sample.t_us) {
            self.filter.model_changed();
        }
        let mut flags = self.flags(&sample);
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        if !missing {
            self.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let rate = self.identifier.flown().compensate(raw.into());

        let step_s = step_us as f32 * 1e-6;
        if gap {
            self.filter.gap(step_s);
            flags.insert(AttitudeFlags::AFTER_GAP);
        } else {
            self.filter.propagate(step_s, &rate);
        }
        let suspect =
            missing || sample.flags.contains(SampleFlags::GYRO_CLIPPED) || flags.contains(AttitudeFlags::FROZEN_SENSOR);
        let accel = self.reading(&sample, SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED);
        let mag = self.reading(&sample, SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED);
        let good = |reading: &Reading| if let Reading::Good(v) = reading { Some(*v) } else { None };
        self.filter.observe(good(&accel).as_ref(), good(&mag).as_ref());
        // Gravity is what specific force at rest points away from.
        let gravity = if let Reading::Good(force) = accel { Reading::Good(-force) } else { accel };
        self.identifier.push(sample.t_us, raw, suspect, gravity, mag);

        Some(Output { t_us: sample.t_us, rate_rad_s: rate.into(), attitude: self.filter.attitude(flags) })
    }

    /// Does about `budget` units of identification work (a unit is about one pre-integrated segment's evaluation, some
    /// hundred instructions; the last piece may overshoot by 300) and hands out the report of a window whose result has taken
    /// effect, or of one that has none. Results do not depend on how the work is sliced, only on whether it is done in time.
    pub fn poll(&mut self, budget: u32) -> Option<WindowReport> {
        let mut spent = 0;
        while spent < budget {
            let units = self.identifier.step();
            if units == 0 {
                break;
            }
            spent += units;
        }
        self.identifier.take_report()
    }

    /// What has been counted since the start.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        Counters { overruns: self.identifier.overruns, reports_lost: self.identifier.reports_lost, ..self.counters }
    }

    /// The gyro model in use.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        self.identifier.flown()
    }

    fn mark_clipped(&mut self, sample: &mut Sample) {
        let at_full_scale = |reading: &[f32; 3], full_scale: Option<f32>| {
            full_scale.is_some_and(|limit| reading.iter().any(|x| libm::fabsf(*x) >= CLIPPED_SHARE * limit))
        };
        let full_scale = &self.config.full_scale;
        if at_full_scale(&sample.gyro_rad_s, full_scale.gyro_rad_s) {
            sample.flags.insert(SampleFlags::GYRO_CLIPPED);
        }
        if at_full_scale(&sample.accel_m_s2, full_scale.accel_m_s2) {
            sample.flags.insert(SampleFlags::ACCEL_CLIPPED);
        }
        if at_full_scale(&sample.mag_ut, full_scale.mag_ut) {
            sample.flags.insert(SampleFlags::MAG_CLIPPED);
        }
    }

    /// Counts what is wrong with a sample and turns it into the attitude's flags.
    fn flags(&mut self, sample: &Sample) -> AttitudeFlags {
        let clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        let mut flags = AttitudeFlags::empty();
        if sample.flags.intersects(clipped) {
            self.counters.clipped += 1;
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            self.counters.gyro_missing += 1;
            flags.insert(AttitudeFlags::GYRO_HELD);
        }
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        let readings = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
        let missing = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        for ((stale, reading), missing) in self.frozen.iter_mut().zip(readings).zip(missing) {
            if stale.is_frozen(reading, self.samples_per_second) && !sample.flags.contains(missing) {
                flags.insert(AttitudeFlags::FROZEN_SENSOR);
            }
        }
        flags
    }

    /// A vector sensor's calibrated reading. A sensor that has not changed for a second, or reads exact zeros, gives none.
    fn reading(&self, sample: &Sample, missing: SampleFlags, clipped: SampleFlags) -> Reading {
        let (raw, model, stale) = if missing == SampleFlags::ACCEL_MISSING {
            (sample.accel_m_s2, &self.config.accel, &self.frozen[1])
        } else {
            (sample.mag_ut, &self.config.mag, &self.frozen[2])
        };
        let frozen = stale.same > self.samples_per_second;
        if sample.flags.contains(missing) || frozen || raw == [0.0; 3] {
            Reading::Missing
        } else if sample.flags.contains(clipped) {
            Reading::Clipped
        } else {
            Reading::Good(model.calibrate(raw))
        }
    }
}

impl Default for Probe {
    fn default() -> Self {
        Self::new()
    }
}
