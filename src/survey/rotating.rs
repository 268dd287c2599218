//! Rotating survey: a survey from mean readings over whole turns.
//!
//! Readings across the axis are turned back by the gyro's angle and averaged with the axial ones, weighted by the angle
//! of each sample, over whole turns. A bias across the axis cancels even where the speed varies, and so does the
//! centrifugal force of a sensor off the axis unless the speed varies once per turn; gravity and field do not turn and
//! stay. (Azimuth from a turning string is old: see US
//! 5,012,412, Helm.) An error of the gyro, bias or scale, turns force and field alike from block to block: each whole
//! turn is turned onto the first one, else the mean were shortened by sinc(n pi s), with n turns and a scale error s,
//! and the inclination too low. The magnetometer's delay against the accelerometer turns the azimuth.

use super::{
    SixAxisAverages, SurveyInput, SurveyKind, SurveyReport,
    means::{BlockMean, MeanOfBlocks},
    record::ToolfaceSwitch,
    sensor_errors::{CorrectionVariances, turned_covariance},
    six_axis::SixAxisCovariance,
    turn::Turn,
};
use crate::config::{Earth, SurveyConfig};
use core::f32::consts::TAU;
use nalgebra::{Matrix3, Vector3};

/// Smoothing of the axial rate that decides on rotation, seconds: a stuck string still counts as rotating for
/// some seconds.
const SMOOTHING_S: f32 = 2.0;
/// Largest turn between two samples in use, radians: readings between them are interpolated linearly.
const LONGEST_STEP_RAD: f32 = 0.5;
/// Pause that ends the survey in progress, microseconds.
const LONGEST_PAUSE_US: u64 = 100_000;

/// Computes surveys while the tool rotates, sample by sample.
pub(crate) struct RotatingSurvey {
    rotating: bool,
    smooth_rad_s: f32,
    last_us: Option<u64>,
    start_us: u64,
    samples: u32,
    /// Angle since the start.
    turn: Turn,
    /// Angle in the turn in progress, radians, signed.
    angle_rad: f32,
    /// Last sample whose rate, force and field were usable.
    last: Option<Used>,
    force_angle: Vector3<f32>,
    field_angle: Vector3<f32>,
    force: MeanOfBlocks,
    field: MeanOfBlocks,
    field_whole: bool,
    corrections: CorrectionVariances,
    warmth: BlockMean,
}

/// Sample in use: its readings, and its angle in the turn.
#[derive(Clone, Copy)]
struct Used {
    angle_rad: f32,
    force: Vector3<f32>,
    field: Vector3<f32>,
    /// Force, m/s^2, and field, microtesla, with the tool's rotation taken out.
    force_back: Vector3<f32>,
    field_back: Vector3<f32>,
}

impl RotatingSurvey {
    pub(crate) const fn new() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            rotating: false,
            smooth_rad_s: 0.0,
            last_us: None,
            start_us: 0,
            samples: 0,
            turn: Turn::NONE,
            angle_rad: 0.0,
            last: None,
            force_angle: zero,
            field_angle: zero,
            force: MeanOfBlocks::new(),
            field: MeanOfBlocks::new(),
            field_whole: true,
            corrections: CorrectionVariances::NONE,
            warmth: BlockMean::new(),
        }
    }

    /// Returns true if the tool turns about its axis.
    pub(crate) const fn is_rotating(&self) -> bool {
        self.rotating
    }

    /// Takes a sample. Returns the report when the configured number of turns is complete.
    pub(crate) fn push(
        &mut self,
        input: &SurveyInput,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<SurveyReport> {
        // A sample without a rate is skipped: the next rate then covers both intervals.
        let [.., rate] = input.rate_rad_s?;
        let step_us = self.last_us.map_or(0, |last| input.t_us.saturating_sub(last));
        self.last_us = Some(input.t_us);
        if step_us > LONGEST_PAUSE_US {
            self.begin(input.t_us);
            return None;
        }
        let step_s = step_us as f32 * 1e-6;
        self.smooth_rad_s += (rate - self.smooth_rad_s) * (step_s / (SMOOTHING_S + step_s));
        let limit = config.rotating_rad_s * if self.rotating { 0.5 } else { 1.0 };
        let rotating = self.smooth_rad_s.abs() >= limit;
        if rotating != self.rotating {
            self.rotating = rotating;
            self.begin(input.t_us);
        }
        if !rotating {
            return None;
        }
        self.turn.by(rate * step_s);
        self.angle_rad += rate * step_s;
        self.add(input);
        if self.force.count() < config.rotating_turns {
            return None;
        }
        let report = self.report(input, toolface, (earth, config));
        self.begin(input.t_us);
        report
    }

    /// Restarts at an angle of zero, without readings.
    fn begin(&mut self, t_us: u64) {
        *self = Self {
            rotating: self.rotating,
            smooth_rad_s: self.smooth_rad_s,
            last_us: self.last_us,
            start_us: t_us,
            ..Self::new()
        };
    }

    fn add(&mut self, input: &SurveyInput) {
        let Some(force) = input.force_m_s2.filter(|_| !input.accel_clipped) else { return };
        // A short loss of the field is bridged, as one of the force is; after a long one the survey has no field.
        if input.field_ut.is_none() && self.field_whole {
            let since = self.angle_rad - self.last.map_or(0.0, |last| last.angle_rad);
            if since.abs() < 0.5 * LONGEST_STEP_RAD {
                return;
            }
            self.field_whole = false;
        }
        let (force, field) = (Vector3::from(force), Vector3::from(input.field_ut.unwrap_or_default()));
        let (force_back, field_back) = (self.turn.back(&force), self.turn.back(&field));
        let now = Used { angle_rad: self.angle_rad, force, field, force_back, field_back };
        if let Some(temperature) = input.temperature_c {
            self.warmth.add(&Vector3::new(temperature, 0.0, 0.0));
        }
        self.corrections.include(input);
        self.samples = self.samples.saturating_add(1);
        let Some(last) = self.last.replace(now) else {
            self.begin_turn(now, 0.0);
            return;
        };
        let step_rad = now.angle_rad - last.angle_rad;
        if step_rad.abs() > LONGEST_STEP_RAD {
            self.begin_turn(now, 0.0);
        } else if now.angle_rad.abs() < TAU {
            self.force_angle += (last.force_back + force_back) * (0.5 * step_rad);
            self.field_angle += (last.field_back + field_back) * (0.5 * step_rad);
        } else {
            self.close_turn(&last, now);
        }
    }

    /// Closes a turn that became whole between two samples. Each of the two turns gets its part of the step,
    /// by linearly interpolated readings.
    fn close_turn(&mut self, last: &Used, now: Used) {
        let step_rad = now.angle_rad - last.angle_rad;
        let over_rad = now.angle_rad - if now.angle_rad > 0.0 { TAU } else { -TAU };
        let (before_rad, share) = (step_rad - over_rad, over_rad / step_rad);
        let mut turn = self.turn;
        turn.by(-over_rad);
        let between = |last: &Vector3<f32>, now: &Vector3<f32>| turn.back(&(now + (last - now) * share));
        let force = between(&last.force, &now.force);
        let field = between(&last.field, &now.field);
        let whole = now.angle_rad - over_rad;
        let force_mean = (self.force_angle + (last.force_back + force) * (0.5 * before_rad)) / whole;
        let field_mean = (self.field_angle + (last.field_back + field) * (0.5 * before_rad)) / whole;
        // One of both says the turn, so that their scatter against each other stays: the field, which does not vibrate.
        let onto_first = Turn::between(self.field.first(), &field_mean)
            .or_else(|| Turn::between(self.force.first(), &force_mean))
            .unwrap_or(Turn::NONE);
        self.force.add(&onto_first.back(&force_mean));
        self.field.add(&onto_first.back(&field_mean));
        self.begin_turn(now, over_rad);
        self.force_angle = (force + now.force_back) * (0.5 * over_rad);
        self.field_angle = (field + now.field_back) * (0.5 * over_rad);
    }

    fn begin_turn(&mut self, now: Used, angle_rad: f32) {
        self.angle_rad = angle_rad;
        self.last = Some(Used { angle_rad, ..now });
        (self.force_angle, self.field_angle) = (Vector3::zeros(), Vector3::zeros());
    }

    fn report(
        &self,
        input: &SurveyInput,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<SurveyReport> {
        let errors = &config.errors;
        let (force, field) = (self.force.mean(), self.field.mean());
        let time_s = input.t_us.saturating_sub(self.start_us) as f32 * 1e-6;
        let rate_rad_s = TAU * f32::from(self.force.count()) / if time_s > 0.0 { time_s } else { 1.0 };
        let (unknown_s, known_s) = (input.mag_delay_sigma_s, errors.mag_timing_s);
        let delay_s = if unknown_s > known_s { unknown_s } else { known_s };
        let late = Vector3::new(-field.y, field.x, 0.0) * (rate_rad_s * delay_s);
        let interference = errors.axial_interference_ut;
        let axial = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, interference * interference));
        let mut covariance = SixAxisCovariance {
            gravity: turned_covariance(&force, errors.accel_bias_m_s2, errors.accel_scale) + self.force.covariance(),
            field: turned_covariance(&field, errors.mag_bias_ut, errors.mag_scale)
                + late * late.transpose()
                + axial
                + self.field.covariance(),
        };
        self.corrections.inflate_turned(&mut covariance);
        let averages = SixAxisAverages {
            samples: self.samples,
            raw_accel_m_s2: [0.0; 3],
            raw_mag_ut: None,
            force_m_s2: force.into(),
            field_ut: self.field_whole.then(|| field.into()),
            rate_rad_s: [0.0, 0.0, self.smooth_rad_s],
        };
        let span_us = [self.start_us, input.t_us];
        SurveyReport::of(SurveyKind::Rotating, span_us, averages, &covariance, &self.warmth, toolface, (earth, config))
    }
}

#[cfg(test)]
mod tests;
