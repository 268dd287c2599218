//! The whole pipeline behind two calls: [`Probe::push`] for every sample, [`Probe::poll`] whenever there is time.

mod rail;
mod staleness;

use crate::{
    attitude::{Attitude, AttitudeFilter, AttitudeFlags},
    compensation::{ActiveEffects, Effect, GyroModel, Moment, effect::REFERENCE_TEMPERATURE_C, effects::LIBRARY},
    config::{Config, ConfigError},
    diagnosis::{DiagnosisReport, FieldUse, HardIronCounts, HardIronInterval, HardIronWatch},
    identification::{Identifier, WindowCost, WindowReport},
    sample::{Sample, SampleFlags},
    window::Reading,
};
use nalgebra::Vector3;
use rail::Rail;
use staleness::Staleness;

/// Units of work in a second (a unit is some 300 instructions): 29 % of a Cortex-M4F at 168 MHz while there is work. A window takes
/// some 16,000, one that is disturbed some 35,000; a diagnosis some 80,000 a pass. The dearest slice, with a piece that is not cut up, is
/// some 700,000 instructions (4 ms).
const WORK_UNITS_PER_SECOND: u32 = 160_000;

/// A step of time over this many nominal periods is a gap.
pub const GAP_PERIODS: u32 = 3;

/// Share of full scale from which a reading counts as clipped: data sheets name full scales in round figures, and a saturated 16-bit
/// word can stand for as little as 99.9 % of them (2,000 deg/s at 16.4 LSB per deg/s saturate at 1,998.0: MPU-9250 PS section 3.1).
pub const CLIPPED_SHARE: f32 = 0.998;

/// Over how long the shaking is averaged, seconds; as the diagnosis does.
const SHAKING_S: f32 = 0.2;

/// Part of a second after which a gyro or an accelerometer that reads the same on all axes is not used: a live one has noise, and
/// what is read until a dead one is found out is wrong and believed. A gyro that reads no rotation, and read none before, gets the
/// whole second: the noise of a quiet one is below its resolution (ICM-42688-P: 20 mdps in 50 Hz against 61 mdps).
const STALE_INERTIAL_PART: u32 = 20;

/// The same for a magnetometer, of which some read only 8 to 10 times a second.
const STALE_MAG_PART: u32 = 4;

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
    /// Diagnoses that were not ready in time.
    pub diagnosis_overruns: u32,
    /// Diagnoses' reports dropped because nobody took them.
    pub diagnoses_lost: u32,
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
    /// How long no rate has been read that can be believed, seconds.
    unread_s: f32,
    /// Gyro, accelerometer, magnetometer.
    staleness: [Staleness; 3],
    gyro_rails: [Rail; 3],
    filter: AttitudeFilter,
    identifier: Identifier,
    /// Compensated rate of the sample before, for the angular acceleration.
    last_rate_rad_s: Option<Vector3<f32>>,
    square_force_m2_s4: f32,
    /// What is taken out of the readings for the attitude.
    attitude_effects: ActiveEffects,
    watch: HardIronWatch,
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
                diagnosis_overruns: 0,
                diagnoses_lost: 0,
            },
            last_us: 0,
            last_raw_rad_s: [0.0; 3],
            unread_s: 0.0,
            staleness: [Staleness::zero(); 3],
            gyro_rails: [Rail::zero(); 3],
            filter: AttitudeFilter::new(),
            identifier: Identifier::zero(),
            last_rate_rad_s: None,
            square_force_m2_s4: 0.0,
            attitude_effects: ActiveEffects::none(),
            watch: HardIronWatch::zero(),
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
        self.unread_s = 0.0;
        self.staleness = [Staleness::zero(); 3];
        self.gyro_rails = [Rail::zero(); 3];
        self.filter.start(&config.attitude, &config.earth);
        self.identifier.configure(config);
        self.last_rate_rad_s = None;
        self.attitude_effects = ActiveEffects::none();
        self.square_force_m2_s4 = config.earth.gravity_m_s2 * config.earth.gravity_m_s2;
        if self.identifier.library().is_empty() {
            self.identifier.set_library(&LIBRARY);
        }
        self.watch.configure(config);
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
            count(&mut self.counters.out_of_order);
            return None;
        }
        let step_us = sample.t_us - if first { sample.t_us } else { self.last_us };
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

        if self.identifier.take_effect(sample.t_us) {
            self.filter.model_changed();
        }
        let [effects_changed, bias_stepped] = self.identifier.take_diagnosed(sample.t_us);
        if effects_changed {
            self.attitude_effects = self.effects().of_attitude(self.library());
        }
        if bias_stepped {
            self.filter.model_changed();
        }
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
        let accel = self.vector(1, &sample);
        let mut mag = self.vector(2, &sample);
        let withheld = self.watch(sample.t_us, gyro, &mut mag);
        let compensated = self.identifier.flown().compensate(raw.into());
        let moment = self.corrected(&sample, &compensated, [accel, mag], step_us as f32 * 1e-6);
        let rate = moment.rate_rad_s;

        let step_s = step_us as f32 * 1e-6;
        if gap {
            self.filter.gap(step_s);
            flags.insert(AttitudeFlags::AFTER_GAP);
            self.unread_s = 0.0;
        } else {
            self.filter.propagate(step_s, &rate);
        }
        if let Reading::Good(_) = gyro {
            self.unread_s = 0.0;
        } else if !gap {
            self.unread_s += step_s;
            self.filter.unread(step_s, self.unread_s);
        }
        let if_good = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Good(_)).then_some(v);
        self.filter.observe(if_good(&accel, moment.force_m_s2).as_ref(), if_good(&mag, moment.field_ut).as_ref());
        // Gravity is what specific force at rest points away from.
        let gravity = match accel {
            // Seconds in which gravity alone speaks would weigh its own errors into P.
            _ if withheld => Reading::Clipped,
            Reading::Good(force) => Reading::Good(-force),
            _ => accel,
        };
        let temperature = sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        self.identifier.push(sample.t_us, [gyro, gravity, mag], (!temperature).then_some(sample.temperature_c));

        let delay_us = self.effects().gyro_delay_s(self.library()) * 1e6;
        let t_us = sample.t_us.saturating_add_signed(-(delay_us as i64));
        Some(Output { t_us, rate_rad_s: rate.into(), attitude: self.filter.attitude(flags) })
    }

    /// Does about `budget` units of identification and diagnosis work (a unit is some 300 instructions; the last piece may overshoot by
    /// 500) and hands out the report of a window whose result has taken
    /// effect, or of one that has none. Results do not depend on how the work is sliced, only on whether it is done in time:
    /// begun within 1.9 s of the window's close, before its samples are overwritten, and done when the result is due. Else the
    /// window is a counted overrun.
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

    /// The sample's readings without the effects that have been found.
    fn corrected(&mut self, sample: &Sample, rate: &Vector3<f32>, [accel, mag]: [Reading; 2], step_s: f32) -> Moment {
        let reading = |reading: Reading| if let Reading::Good(v) = reading { v } else { Vector3::zeros() };
        let (force, field) = (reading(accel), reading(mag));
        let acceleration = match self.last_rate_rad_s {
            Some(last) if step_s > 0.0 => (rate - last) / step_s,
            _ => Vector3::zeros(),
        };
        self.last_rate_rad_s = Some(*rate);
        if let Reading::Good(force) = accel {
            let share = step_s / SHAKING_S;
            self.square_force_m2_s4 +=
                (force.norm_squared() - self.square_force_m2_s4) * if share < 1.0 { share } else { 1.0 };
        }
        let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let mut moment = Moment {
            rate_rad_s: *rate,
            acceleration_rad_s2: acceleration,
            force_m_s2: force,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: field,
            before_shock: 0.0,
            warming_k: if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { 0.0 },
        };
        self.attitude_effects.correct(self.library(), &mut moment);
        moment
    }

    /// Sets the effects that are looked for, and starts afresh with them; without a call they are those of [`LIBRARY`].
    pub const fn set_library(&mut self, library: &'static [&'static dyn Effect]) {
        self.identifier.set_library(library);
    }

    /// The effects that are looked for.
    #[must_use]
    pub fn library(&self) -> &'static [&'static dyn Effect] {
        self.identifier.library()
    }

    /// The effects that are taken out.
    #[must_use]
    pub const fn effects(&self) -> &ActiveEffects {
        self.identifier.effects()
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

    /// What has been counted since the start.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        let (diagnosis_overruns, diagnoses_lost) = self.identifier.diagnosis_losses();
        Counters {
            overruns: self.identifier.overruns,
            reports_lost: self.identifier.reports_lost,
            diagnosis_overruns,
            diagnoses_lost,
            ..self.counters
        }
    }

    /// The gyro model in use.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        self.identifier.flown()
    }

    /// What the search minimises on the window identified last, for other optimisers to be tried on; `None` before there is one
    /// and while the next one's innovations are being gathered.
    #[must_use]
    pub fn window_cost(&self) -> Option<WindowCost<'_>> {
        self.identifier.window_cost()
    }

    /// Body-fixed magnetic offsets that came while the probe ran, the oldest first: the last eight of
    /// [`Probe::hard_iron_counts`]. Empty when effects are switched off.
    pub fn hard_iron_intervals(&self) -> impl Iterator<Item = &HardIronInterval> {
        self.watch.intervals()
    }

    /// What the watch for them has counted since the start.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.watch.counts()
    }

    /// Takes from the calibrated field what a magnet on the probe adds to it; makes it missing while it is not to be believed and
    /// returns whether that is so.
    fn watch(&mut self, t_us: u64, gyro: Reading, mag: &mut Reading) -> bool {
        if !self.config.effects {
            return false;
        }
        let stream = &self.identifier.stream;
        if let (Some(rest_us), Some(bias)) = (stream.last_rest_us(), stream.rest_bias(t_us)) {
            self.watch.rest(rest_us, &bias);
        }
        self.watch.push(t_us, gyro, *mag);
        match (*mag, self.watch.field_use()) {
            (Reading::Good(field), FieldUse::Less(offset)) => {
                *mag = Reading::Good(field - offset);
                false
            }
            (_, FieldUse::Withheld) => {
                *mag = Reading::Missing;
                true
            }
            _ => false,
        }
    }

    fn mark_clipped(&mut self, sample: &mut Sample) {
        let at_full_scale = |reading: &[f32; 3], full_scale: Option<f32>| {
            full_scale.is_some_and(|limit| reading.iter().any(|x| libm::fabsf(*x) >= CLIPPED_SHARE * limit))
        };
        let full_scale = &self.config.full_scale;
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        let rails = self.gyro_rails.iter_mut().zip(sample.gyro_rad_s);
        let railed = !missing && rails.fold(false, |railed, (rail, x)| rail.observe(x) || railed);
        if railed || at_full_scale(&sample.gyro_rad_s, full_scale.gyro_rad_s) {
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
            count(&mut self.counters.clipped);
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            count(&mut self.counters.gyro_missing);
            flags.insert(AttitudeFlags::GYRO_HELD);
        }
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        let readings = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
        let missing = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        for ((stale, reading), missing) in self.staleness.iter_mut().zip(readings).zip(missing) {
            if !sample.flags.contains(missing) {
                stale.observe(reading);
                if stale.same > self.samples_per_second {
                    flags.insert(AttitudeFlags::FROZEN_SENSOR);
                }
            }
        }
        flags
    }

    /// Whether a sensor (0 gyro, 1 accelerometer, 2 magnetometer) has read the same for one `part`-th of a second.
    fn is_stale(&self, sensor: usize, part: u32) -> bool {
        let limit = self.config.identification.max_bias_rad_s;
        self.staleness.get(sensor).is_some_and(|stale| {
            let part = if sensor == 0 && stale.is_still(limit) { 1 } else { part };
            stale.same > self.samples_per_second.checked_div(part).unwrap_or(0)
        })
    }

    /// The calibrated reading of the accelerometer (1) or the magnetometer (2). A stale one, or exact zeros, are none.
    fn vector(&self, sensor: usize, sample: &Sample) -> Reading {
        let (raw, model, missing, clipped, part) = if sensor == 1 {
            let flags = (SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED);
            (sample.accel_m_s2, &self.config.accel, flags.0, flags.1, STALE_INERTIAL_PART)
        } else {
            let flags = (SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED);
            (sample.mag_ut, &self.config.mag, flags.0, flags.1, STALE_MAG_PART)
        };
        if sample.flags.contains(missing) || raw == [0.0; 3] {
            Reading::Missing
        } else if sample.flags.contains(clipped) || self.is_stale(sensor, part) {
            Reading::Clipped
        } else {
            Reading::Good(model.calibrate(raw))
        }
    }
}

/// Counts one more; a full counter stays.
const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl Default for Probe {
    fn default() -> Self {
        Self::new()
    }
}
