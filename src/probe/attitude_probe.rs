//! The smallest probe: attitude with the factory's calibration, and the watch for magnets, without identification. For a
//! part with little memory; what it gives up stands in docs/new_board.md.

use super::{
    GAP_PERIODS, Output,
    corrector::Corrector,
    latency::at_gyro_time,
    reading_checks::ReadingChecks,
    survey::{Calibrated, input_of},
};
use crate::{
    attitude::{AttitudeFilter, AttitudeFlags},
    compensation::GyroModel,
    config::{Config, ConfigError},
    magnet::{FieldUse, HardIronCounts, HardIronWatch},
    sample::{Reading, Sample, SampleFlags, Sensor},
    survey::SurveyInput,
};
use nalgebra::Vector3;

/// Step back in time that is the clock's and not a sample's, microseconds.
const CLOCK_WENT_BACK_US: u64 = 10_000_000;

/// Probe without identification. It flies the gyro model that it is given: the factory's, or one that something else has
/// learnt ([`AttitudeProbe::fly`]). As [`Probe`](crate::Probe), [`AttitudeProbe::new`] is all zero bytes.
///
/// A sample that is later than the one before is taken, however far; one that goes back by more than ten seconds begins
/// afresh. `Probe` asks for a second sample before it believes either.
pub struct AttitudeProbe {
    configured: bool,
    config: Config,
    /// Model that flies.
    model: GyroModel,
    /// Time of the last sample; `None` before one.
    last_us: Option<u64>,
    last_raw_rad_s: [f32; 3],
    /// Time since the last believable rate, seconds.
    unread_s: f32,
    readings: [Reading; 3],
    checks: ReadingChecks,
    corrector: Corrector,
    calibrated: Calibrated,
    filter: AttitudeFilter,
    watch: HardIronWatch,
}

impl AttitudeProbe {
    /// Returns a probe without a configuration.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            configured: false,
            config: Config::UNSET,
            model: GyroModel::UNSET,
            last_us: None,
            last_raw_rad_s: [0.0; 3],
            unread_s: 0.0,
            readings: [const { Reading::Missing }; 3],
            checks: ReadingChecks::ZERO,
            corrector: Corrector::ZERO,
            calibrated: Calibrated::NONE,
            filter: AttitudeFilter::new(),
            watch: HardIronWatch::zero(),
        }
    }

    /// Checks a configuration and starts anew from it.
    ///
    /// # Errors
    /// Names the field that cannot be used; the probe then stays as it was.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = *config;
        self.begin();
        Ok(())
    }

    /// Starts anew from the present configuration.
    fn begin(&mut self) {
        let config = &self.config;
        self.model = config.gyro;
        self.last_us = None;
        self.last_raw_rad_s = config.gyro.b_rad_s;
        self.unread_s = 0.0;
        self.readings = [const { Reading::Missing }; 3];
        self.checks = ReadingChecks::new(config);
        self.corrector = Corrector::new(config);
        self.calibrated = Calibrated::NONE;
        self.filter.start(&config.attitude, &config.earth);
        self.filter.mag_delay_known(config.latency.mag_s.map(|_| 0.0));
        self.filter.gyro_delay_known(config.latency.gyro_s.is_some());
        self.watch.configure(config);
        self.configured = true;
    }

    /// Flies a gyro model from the next sample on, known with these deviations of P (row-major) and b, rad/s. Returns false
    /// for a model that is none, and before a configuration.
    pub fn fly(&mut self, model: &GyroModel, sigma: &[f32; 12]) -> bool {
        let can = self.configured && model.is_valid();
        if can {
            self.filter.model_changed(&self.model, model, sigma);
            self.model = *model;
        }
        can
    }

    /// Takes one sample. Returns `None` before a configuration, and for a sample whose time does not increase.
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        if !self.configured {
            return None;
        }
        let mut sample = sample.sanitised();
        if let Some(last_us) = self.last_us.filter(|last_us| sample.t_us <= *last_us) {
            if last_us - sample.t_us <= CLOCK_WENT_BACK_US {
                return None;
            }
            self.begin();
        }
        self.checks.mark_clipped(&mut sample, &self.config.full_scale);
        let step_us = self.last_us.map_or(0, |last_us| sample.t_us.saturating_sub(last_us));
        let gap = step_us > u64::from(GAP_PERIODS * self.config.sample_period_us);
        match self.last_us {
            None => self.watch.start(sample.t_us),
            Some(_) if gap => self.watch.gap(sample.t_us),
            Some(_) => {}
        }
        self.last_us = Some(sample.t_us);
        let step_s = step_us as f32 * 1e-6;

        let mut flags = AttitudeFlags::empty();
        flags.set(AttitudeFlags::GYRO_HELD, sample.flags.contains(SampleFlags::GYRO_MISSING));
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        flags.set(AttitudeFlags::FROZEN_SENSOR, self.checks.update(&sample));
        flags.set(AttitudeFlags::AFTER_GAP, gap);
        if !sample.flags.contains(SampleFlags::GYRO_MISSING) {
            self.last_raw_rad_s = sample.gyro_rad_s;
        }
        let raw = Vector3::from(self.last_raw_rad_s) - self.filter.earth_rate_rad_s();
        let compensated = self.model.compensate(raw.into());
        let gyro = self.checks.rate(raw, &sample);
        let [accel, mag] = self.vectors(&sample, &compensated, step_s);
        let mag = self.without_magnets(sample.t_us, [gyro, accel, mag]);
        self.readings = [gyro, accel, mag];
        let before = self.corrector.last_rate_or(compensated);
        let corrected = self.corrector.correct(&[], &sample, &compensated, [accel, mag], step_s);

        if gap {
            self.filter.gap(step_s);
            self.unread_s = 0.0;
        } else {
            // As in `Probe::push`: a reading of unknown time counts as the mean over the interval that it ends.
            let held = if self.config.latency.gyro_s.is_some() { 0.5 } else { 0.0 };
            self.filter.propagate(step_s, &(compensated + (before - compensated) * held));
        }
        if let Reading::Usable(_) = gyro {
            self.unread_s = 0.0;
        } else if !gap {
            self.unread_s += step_s;
            self.filter.unread(step_s, self.unread_s);
        }
        let if_usable = |reading: &Reading, v: Vector3<f32>| matches!(reading, Reading::Usable(_)).then_some(v);
        self.filter
            .observe(if_usable(&accel, corrected.force_m_s2).as_ref(), if_usable(&mag, corrected.field_ut).as_ref());
        self.calibrated = Calibrated::of(&sample, [gyro, accel, mag], &corrected);
        let delay_us = (self.config.latency.gyro_s.unwrap_or(0.0) * 1e6) as u64;
        let t_us = sample.t_us.saturating_sub(delay_us);
        Some(Output { t_us, rate_rad_s: compensated.into(), attitude: self.filter.attitude(flags) })
    }

    /// Readings of the last sample for an [`Estimator`](crate::estimator::Estimator): raw rate less the earth's, calibrated
    /// force and field.
    #[must_use]
    pub const fn readings(&self) -> [Reading; 3] {
        self.readings
    }

    /// Model that flies.
    #[must_use]
    pub const fn gyro_model(&self) -> &GyroModel {
        &self.model
    }

    /// Counters of the watch for magnets since the configuration.
    #[must_use]
    pub const fn hard_iron_counts(&self) -> HardIronCounts {
        self.watch.counts()
    }

    /// Returns the survey's input of a sample that was just pushed and gave `output`, for
    /// [`Surveyor::push`](crate::survey::Surveyor::push).
    #[must_use]
    pub fn survey_input(&self, sample: &Sample, output: &Output) -> SurveyInput {
        input_of(&self.calibrated, &self.filter.residual_bias_rad_s(), sample, output)
    }

    /// Returns the calibrated readings of accelerometer and magnetometer at the gyro's time.
    fn vectors(&self, sample: &Sample, rate: &Vector3<f32>, step_s: f32) -> [Reading; 2] {
        let accel = self.checks.vector(Sensor::Accelerometer, &self.config.accel, sample);
        let mag = self.checks.vector(Sensor::Magnetometer, &self.config.mag, sample);
        let [accel_s, mag_s] = self.config.latency.behind_gyro_s();
        if accel_s == 0.0 && mag_s == 0.0 {
            return [accel, mag];
        }
        let acceleration = self.corrector.acceleration_rad_s2(rate, step_s);
        let rate = rate - self.filter.residual_bias_rad_s();
        [(accel, accel_s), (mag, mag_s)]
            .map(|(reading, behind_s)| at_gyro_time(reading, behind_s, &rate, &acceleration))
    }

    /// Returns the field less that of a magnet on the probe; the field is missing while the magnet is undecided.
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
}

impl Default for AttitudeProbe {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::Probe;
    use std::boxed::Box;

    /// A turn about a tilted axis, with the vectors that it shows and a dozen readings that are missing.
    fn samples() -> impl Iterator<Item = Sample> {
        (1..4_000_u32).map(|k| {
            let angle = k as f32 * 0.004;
            let (sin, cos) = (libm::sinf(angle), libm::cosf(angle));
            // A little noise, so that no sensor counts as frozen.
            let noise = (k.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-6;
            Sample {
                t_us: 5_000 * u64::from(k),
                gyro_rad_s: [noise, 0.0 - noise, 0.8],
                accel_m_s2: [-3.0 * cos, 3.0 * sin, -9.3 + noise],
                mag_ut: [20.0 * cos, -20.0 * sin, 40.0 + noise],
                temperature_c: 25.0,
                flags: if k % 300 == 0 { SampleFlags::GYRO_MISSING } else { SampleFlags::empty() },
            }
        })
    }

    /// Before anything is learnt the pipeline flies the factory's model: the same attitude to the bit.
    #[test]
    fn attitude_is_the_pipelines_while_nothing_is_learnt() {
        let config = Config { effects: false, ..Config::default() };
        let (mut small, mut whole) = (Box::new(AttitudeProbe::new()), Box::new(Probe::new()));
        small.configure(&config).unwrap_or_default();
        whole.configure(&config).unwrap_or_default();
        let mut compared = 0;
        for sample in samples() {
            // Without work nothing is learnt.
            let (a, b) = (small.push(&sample), whole.push(&sample));
            assert_eq!(a, b, "{}", sample.t_us);
            compared += u32::from(a.is_some_and(|output| output.attitude.is_some()));
            if let Some(output) = a {
                assert_eq!(small.survey_input(&sample, &output), whole.survey_input(&sample, &output));
            }
        }
        assert!(compared > 3_900, "{compared}");
    }

    #[test]
    fn a_clock_that_goes_back_begins_afresh_and_an_old_sample_is_not_taken() {
        let mut probe = Box::new(AttitudeProbe::new());
        assert!(probe.push(&Sample::default()).is_none(), "not configured");
        probe.configure(&Config::default()).unwrap_or_default();
        let at = |t_us| Sample { t_us, accel_m_s2: [0.0, 0.0, -9.8], ..Sample::default() };
        assert!(probe.push(&at(20_000_000)).is_some());
        assert!(probe.push(&at(19_000_000)).is_none());
        assert!(probe.push(&at(1_000)).is_some(), "afresh");
        assert!(probe.push(&at(6_000)).is_some());
    }

    #[test]
    fn a_model_flies_from_the_next_sample_on() {
        let mut probe = Box::new(AttitudeProbe::new());
        let model = GyroModel { b_rad_s: [0.1, 0.0, 0.0], ..GyroModel::IDENTITY };
        assert!(!probe.fly(&model, &[0.01; 12]), "not configured");
        probe.configure(&Config::default()).unwrap_or_default();
        assert!(probe.fly(&model, &[0.01; 12]));
        let sample = Sample { gyro_rad_s: [0.1, 0.0, 0.0], ..Sample::default() };
        assert_eq!(probe.push(&sample).map(|output| output.rate_rad_s), Some([0.0; 3]));
        assert!(!probe.fly(&GyroModel { p: [[0.0; 3]; 3], ..model }, &[0.01; 12]));
    }
}
