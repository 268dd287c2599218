//! Path of a sample from its readings to the attitude, with a gyro model that the caller supplies.

use super::{
    Output,
    corrector::{Corrector, TakenOut},
    latency::at_gyro_time,
    reading_checks::ReadingChecks,
    survey::{Calibrated, input_of},
};
use crate::{
    attitude::{AttitudeFilter, AttitudeFlags},
    compensation::{Effect, GyroModel},
    config::Config,
    magnet::{HardIronWatch, UsableField},
    sample::{Reading, Sample, SampleFlags, Sensor},
    survey::SurveyInput,
};
use nalgebra::Vector3;

/// Stages of a sample: checks, compensation, vectors turned to the gyro's time, magnets, effects `T`, attitude filter.
pub(super) struct Pipeline<T> {
    pub last_raw_rad_s: [f32; 3],
    /// Time since the last usable rate, seconds.
    unread_s: f32,
    pub checks: ReadingChecks,
    pub corrector: Corrector<T>,
    /// Readings of the last sample, for surveys.
    calibrated: Calibrated,
    pub filter: AttitudeFilter,
    pub watch: HardIronWatch,
}

/// Model and settings that a sample is flown with.
pub(super) struct With<'a> {
    pub config: &'a Config,
    pub model: &'a GyroModel,
    pub library: &'static [&'static dyn Effect],
    /// True if the gyro's delay is declared, or was found.
    pub gyro_delay_known: bool,
    /// Time since the sample before, seconds.
    pub step_s: f32,
    /// Length of a gap before the sample, seconds.
    pub gap_s: Option<f32>,
}

/// Result of one sample.
pub(super) struct Stepped {
    /// Raw rate less the earth's, calibrated force, and calibrated field less magnets; effects are not taken out.
    pub readings: [Reading; 3],
    pub rate_rad_s: Vector3<f32>,
    /// Variances on the body's axes of what is taken out of the force, (m/s^2)^2.
    pub force_variances_m2_s4: Vector3<f32>,
    pub flags: AttitudeFlags,
}

impl<T: TakenOut> Pipeline<T> {
    /// All-zero value for a static before it is configured.
    pub const fn zero() -> Self {
        Self {
            last_raw_rad_s: [0.0; 3],
            unread_s: 0.0,
            checks: ReadingChecks::ZERO,
            corrector: Corrector::ZERO,
            calibrated: Calibrated::NONE,
            filter: AttitudeFilter::new(),
            watch: HardIronWatch::zero(),
        }
    }

    /// Starts anew. Until the gyro's first reading the raw rate is the factory bias, that of a probe at rest. The
    /// caller sets the magnetometer's delay in the filter.
    pub fn start(&mut self, config: &Config) {
        self.last_raw_rad_s = config.gyro.b_rad_s;
        self.unread_s = 0.0;
        self.checks = ReadingChecks::new(config);
        self.corrector.start(config);
        self.calibrated = Calibrated::NONE;
        self.watch.configure(config);
        self.filter.start(&config.attitude, &config.earth, config.identification.motion);
        self.filter.gyro_delay_known(config.latency.gyro_s.is_some());
    }

    /// Computes rate and attitude of one sample, in which clipped readings are already flagged.
    pub fn step(&mut self, sample: &Sample, with: &With<'_>) -> Stepped {
        let With { config, model, library, step_s, .. } = *with;
        let mut flags = AttitudeFlags::empty();
        flags.set(AttitudeFlags::GYRO_HELD, sample.flags.contains(SampleFlags::GYRO_MISSING));
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        flags.set(AttitudeFlags::FROZEN_SENSOR, self.checks.update(sample, step_s));
        flags.set(AttitudeFlags::AFTER_GAP, with.gap_s.is_some());
        if !sample.flags.contains(SampleFlags::GYRO_MISSING) {
            self.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let compensated = model.compensate(raw.into());
        let gyro = self.checks.rate(raw, sample);
        let before = self.corrector.rate_before(model, compensated);
        let acceleration = if step_s > 0.0 { (compensated - before) / step_s } else { Vector3::zeros() };
        let motion = [&compensated, &acceleration];
        let [accel, mag] = self.vectors(config, sample, motion);
        let mag = self.without_magnets(config, sample.t_us, [gyro, accel, mag]);
        let corrected = self.corrector.correct(library, sample, (raw, motion), [accel, mag], step_s);
        let rate = corrected.rate_rad_s;

        let period_s = config.sample_period_us as f32 * 1e-6;
        let is_read = self.unread_s == 0.0 && matches!(gyro, Reading::Usable(_));
        let unread_s = with.gap_s.unwrap_or(step_s) - period_s;
        let corrected_before = before + (rate - compensated);
        // Rate at the end of the unread part. A reading of known time is that of its instant, one period later; one of
        // unknown time counts as the mean over that period.
        let last = if with.gyro_delay_known { period_s / (unread_s + period_s) } else { 0.0 };
        let unread_end = rate - (rate - corrected_before) * last;
        let is_bridged =
            is_read && unread_s > 0.5 * period_s && self.filter.bridge(unread_s, &corrected_before, &unread_end);
        if is_bridged {
            self.filter.propagate(period_s, &((unread_end + rate) * 0.5));
        } else if let Some(gap_s) = with.gap_s {
            self.filter.gap(gap_s);
        } else {
            // The rate changes linearly between readings of known time. A reading of unknown time counts as the mean
            // over the interval that it ends (see `Latency::gyro_s`). A delay found among the effects includes that
            // half period.
            let held = if with.gyro_delay_known { 0.5 } else { 0.0 };
            self.filter.propagate(step_s, &(rate + (before - compensated) * held));
        }
        if with.gap_s.is_some() {
            self.unread_s = 0.0;
        }
        if let Reading::Usable(_) = gyro {
            self.unread_s = 0.0;
        } else if with.gap_s.is_none() {
            self.unread_s += step_s;
            self.filter.unread(step_s, self.unread_s);
        }
        let taken_out =
            self.taken_out_variances(library, [corrected.rate_rad_s, corrected.force_m_s2, corrected.field_ut]);
        self.filter.field_offset_known(taken_out[1].sum() / 3.0);
        let if_usable = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Usable(_)).then_some(v);
        self.filter
            .observe(if_usable(&accel, corrected.force_m_s2).as_ref(), if_usable(&mag, corrected.field_ut).as_ref());
        let readings = [gyro, accel, mag];
        self.calibrated = Calibrated::of(sample, readings, &corrected);
        Stepped { readings, rate_rad_s: rate, force_variances_m2_s4: taken_out[0], flags }
    }

    /// Survey's input of the last sample, which gave `output`.
    // Not inlined: its stack frame would else lie under that of the surveys.
    #[inline(never)]
    pub fn survey_input(&self, library: &[&dyn Effect], sample: &Sample, output: &Output) -> SurveyInput {
        let kept = &self.calibrated;
        let readings = [output.rate_rad_s, kept.force_m_s2, kept.field_ut].map(Vector3::from);
        let taken_out = self.taken_out_variances(library, readings);
        let known = (&self.filter.residual_bias_rad_s(), self.filter.mag_delay_sigma_s());
        input_of(kept, known, taken_out, (sample, output))
    }

    /// Variances on the body's axes of what effects and magnets take out of force and field, (m/s^2)^2 and
    /// microtesla^2, at these corrected readings of rate, force and field.
    fn taken_out_variances(&self, library: &[&dyn Effect], readings: [Vector3<f32>; 3]) -> [Vector3<f32>; 2] {
        let [of_force, of_field] = self.corrector.taken_out.vector_variances(library, readings);
        [of_force, of_field + self.watch.offset_variances_ut2()]
    }

    /// Returns the calibrated readings of accelerometer and magnetometer at the gyro's time, by the compensated rate
    /// and the angular acceleration.
    fn vectors(&self, config: &Config, sample: &Sample, [rate, acceleration]: [&Vector3<f32>; 2]) -> [Reading; 2] {
        let accel = self.checks.vector(Sensor::Accelerometer, &config.accel, sample);
        let mag = self.checks.vector(Sensor::Magnetometer, &config.mag, sample);
        let [accel_s, mag_s] = config.latency.behind_gyro_s();
        if accel_s == 0.0 && mag_s == 0.0 {
            return [accel, mag];
        }
        let rate = rate - self.filter.residual_bias_rad_s();
        [(accel, accel_s), (mag, mag_s)].map(|(reading, behind_s)| at_gyro_time(reading, behind_s, &rate, acceleration))
    }

    /// Returns the field less that of a magnet on the probe; the field is missing while a magnet is suspected, not
    /// decided.
    fn without_magnets(&mut self, config: &Config, t_us: u64, readings: [Reading; 3]) -> Reading {
        let [.., mag] = readings;
        if !config.effects {
            return mag;
        }
        self.watch.push(t_us, readings);
        match (mag, self.watch.usable_field()) {
            (Reading::Usable(field), UsableField::Less(offset)) => Reading::Usable(field - offset),
            (_, UsableField::Withheld) => Reading::Missing,
            _ => mag,
        }
    }
}
