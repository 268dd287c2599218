//! Attitude filter: the order of the work in a filter step. Its parts (tilt, heading, motion, agreement) are one file
//! each.

mod estimated;
mod stated;

use super::{
    agreement::Agreement,
    error_state::{BIAS, VELOCITY},
    filter_step::FilterStep,
    gyro_scale,
    heading::{Conditions, Heading, LOST_RAD},
    motion::Motion,
    report::Report,
    rest::RestTracker,
    sensor_errors::SensorErrors,
    settings::Settings,
    state::State,
    tilt::Tilt,
    turned_field::TurnedField,
};
use crate::{
    change::{Change, FORCE_M_S3, RATE_RAD_S2, UNREAD_RATE_TIME_S, UNSEEN_RATE_RAD_S},
    config::{self, AttitudeConfig, Earth},
    rotation::rotate_back,
};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Vector3};

/// Duration of one filter step, seconds: half the shortest correlation time among the modelled errors (0.1 s).
/// Shorter steps add no information, because rotation within a step is removed sample by sample.
const STEP_S: f32 = 0.05;

/// Longest gap that inflations count, seconds: after it nothing of the attitude before is known.
const LONGEST_GAP_S: f32 = 100.0;

const fn limited_s(gap_s: f32) -> f32 {
    if gap_s < LONGEST_GAP_S { gap_s } else { LONGEST_GAP_S }
}

/// Attitude filter: strapdown integration at the sample rate, corrected 20 times a second.
///
/// An error-state Kalman filter over attitude, residual gyro bias and horizontal velocity. The accelerometer is
/// integrated to a velocity, and the filter assumes only that velocity is bounded: a wrong tilt makes the
/// integral of gravity run away; vibration, shocks and a moving hand do not. So no single reading counts as
/// gravity, and the averaging is as long as the gyro allows. The field corrects the heading and the bias, never
/// the tilt, and only while its norm and dip agree with an undisturbed reference. Errors correlated in time
/// enter as white noise of the same density at low frequency; by hand the gyro's scale factors and couplings are
/// states of their own.
///
/// All zero until [`AttitudeFilter::start`], so that a `static` of it takes no flash.
pub struct AttitudeFilter {
    // No `Option` of the fields below: its `None` would be stored in a niche that is not zero.
    started: bool,
    settings: Settings,
    sensors: SensorErrors,
    state: State,
    motion: Motion,
    tilt: Tilt,
    heading: Heading,
    agreement: Agreement,
    turned_field: TurnedField,
    /// Filter step in progress.
    step: FilterStep,
    sample: LastSample,
    /// Change of the rate and of specific force in the earth frame, for gaps.
    change: Change,
    force_change: Change,
    /// True from a swap that showed the former gyro model wrong, until the estimator's attitude has been compared.
    is_doubted: bool,
    report: Report,
}

/// Readings of the last sample.
struct LastSample {
    rate_rad_s: Vector3<f32>,
    /// Interval that the sample ends, seconds; 0 after a gap.
    step_s: f32,
    accel_seen: bool,
    mag_seen: bool,
    after_gap: bool,
}

impl LastSample {
    const NONE: Self = Self {
        rate_rad_s: Vector3::new(0.0, 0.0, 0.0),
        step_s: 0.0,
        accel_seen: false,
        mag_seen: false,
        after_gap: false,
    };
}

impl AttitudeFilter {
    /// Returns a filter that has not been started.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            started: false,
            settings: Settings::UNSET,
            sensors: SensorErrors::ZERO,
            state: State::zero(),
            motion: Motion::new(),
            tilt: Tilt::zero(),
            heading: Heading::zero(),
            agreement: Agreement::new(),
            turned_field: TurnedField::zero(),
            step: FilterStep::new(),
            sample: LastSample::NONE,
            change: Change::ZERO,
            force_change: Change::ZERO,
            is_doubted: false,
            report: Report::ZERO,
        }
    }

    /// Starts anew from a configuration that [`crate::Config::validate`] has accepted.
    pub fn start(&mut self, config: &AttitudeConfig, earth: &Earth, motion: config::Motion) {
        *self = Self {
            started: true,
            settings: Settings::new(config, earth, motion),
            sensors: SensorErrors::new(config),
            state: State::new(config),
            tilt: Tilt::new(),
            heading: Heading::new(earth),
            turned_field: TurnedField::new(),
            change: Change::of_at_least(RATE_RAD_S2),
            force_change: Change::of_at_least(FORCE_M_S3),
            report: Report::new(),
            ..Self::new()
        };
        self.sensors.scale_sigma = gyro_scale::start(&mut self.state, &self.settings);
    }

    /// Rotation of the earth in the body frame at the last sample, rad/s, to subtract from the gyro's reading.
    /// Zero without a latitude or before the alignment; its vertical part alone while there is no heading.
    #[must_use]
    pub fn earth_rate_rad_s(&self) -> Vector3<f32> {
        let rate = self.settings.earth_rate_ned_rad_s;
        let known = if self.heading.is_observed() { rate } else { Vector3::new(0.0, 0.0, rate.z) };
        if self.tilt.aligned { rotate_back(&self.state.propagation.q, &known) } else { Vector3::zeros() }
    }

    /// Residual gyro bias that the filter found, body frame, rad/s, to subtract from the compensated rate.
    #[must_use]
    pub const fn residual_bias_rad_s(&self) -> Vector3<f32> {
        self.state.bias_rad_s
    }

    /// 1-sigma of [`AttitudeFilter::residual_bias_rad_s`], body frame, rad/s.
    #[must_use]
    pub fn residual_bias_sigma_rad_s(&self) -> Vector3<f32> {
        Vector3::from_fn(|axis, _| libm::sqrtf(self.state.errors.variance(BIAS + axis)))
    }

    /// Returns true if the readings have stayed the same for so long that the probe counts as at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.motion.rest.detected()
    }

    /// Advances over the `dt_s` seconds that end with this sample, by its compensated body rate relative to the
    /// earth (or the last rate held).
    pub fn propagate(&mut self, dt_s: f32, rate_rad_s: &Vector3<f32>) {
        if !self.started {
            return;
        }
        // Beyond any gyro (57,000 deg/s): a defective reading, which is not used.
        let plausible = rate_rad_s.norm_squared() < 1e6;
        self.sample.rate_rad_s = if plausible { *rate_rad_s } else { Vector3::zeros() };
        self.sample.step_s = dt_s;
        if !self.tilt.aligned {
            return;
        }
        if !plausible {
            self.stop();
            self.inflate(PI);
        }
        let rate = self.state.corrected(&self.sample.rate_rad_s);
        self.change.update(&rate, dt_s);
        self.state.advance(dt_s, &rate);
        self.step.add_rotation(&self.state.rotation, &rate, dt_s);
    }

    /// Inflates the attitude for `dt_s` seconds of an unread rate (held, clipped or frozen), the last of the `unread_s`
    /// seconds for which no rate was read. The rate's error grows from nothing to the rate itself and
    /// `UNSEEN_RATE_RAD_S` more; the angle's grows with the square of time, then linearly.
    pub fn unread(&mut self, dt_s: f32, unread_s: f32) {
        let rate_rad_s = libm::sqrtf(self.sample.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S;
        let angle_rad = |s: f32| {
            let late = s > UNREAD_RATE_TIME_S;
            rate_rad_s * if late { s - 0.5 * UNREAD_RATE_TIME_S } else { 0.5 * s * s / UNREAD_RATE_TIME_S }
        };
        let (before, now) = (angle_rad(unread_s - dt_s), angle_rad(unread_s));
        self.inflate(libm::sqrtf(now * now - before * before));
        self.tilt.interrupt(unread_s);
    }

    /// Passes over a gap of `dt_s` seconds, from the body rate before it (compensated, relative to the earth) to the
    /// one after: the rate is taken to have changed steadily, and the uncertainty grows by what it may have done
    /// instead. Returns false, and does nothing, where the attitude would be no more certain than by
    /// [`AttitudeFilter::gap`]. Call [`AttitudeFilter::propagate`] next.
    pub fn bridge(&mut self, dt_s: f32, before_rad_s: &Vector3<f32>, after_rad_s: &Vector3<f32>) -> bool {
        let variance = self.change.unread_variance(before_rad_s, after_rad_s, dt_s);
        let blind_rad = self.blind_rad(dt_s);
        // A NaN variance is refused.
        let is_better = variance < blind_rad * blind_rad && variance < LOST_RAD * LOST_RAD;
        if !self.started || !self.tilt.aligned || !is_better {
            return false;
        }
        let rate = self.state.corrected(&((before_rad_s + after_rad_s) * 0.5));
        self.state.propagation.break_off();
        self.state.advance(dt_s, &rate);
        self.state.propagation.break_off();
        self.step.add_rotation(&self.state.rotation, &rate, dt_s);
        self.inflate(libm::sqrtf(variance));
        self.walk_bias(dt_s);
        // The step's mean force stands for the gap, too: it is read up to this long from the gap's middle.
        let far_s = 0.5 * dt_s + STEP_S;
        let speed = self.settings.config.velocity_sigma_m_s;
        for k in 0..2 {
            self.state.errors.inflate(
                VELOCITY + k,
                self.force_change.square() * (far_s * far_s * dt_s * dt_s),
                speed * speed,
            );
        }
        self.change.interrupt();
        self.force_change.interrupt();
        self.tilt.interrupt(dt_s);
        true
    }

    /// Passes over `dt_s` seconds without samples. The attitude stays; its uncertainty grows by the turn that
    /// may have happened, and if that is large, gravity and field give the attitude anew. Call
    /// [`AttitudeFilter::observe`] next, without [`AttitudeFilter::propagate`].
    pub fn gap(&mut self, dt_s: f32) {
        if !self.started {
            return;
        }
        let angle_rad = self.blind_rad(dt_s);
        self.inflate(if angle_rad < PI { angle_rad } else { PI });
        self.walk_bias(dt_s);
        self.stop();
        self.change.interrupt();
        self.force_change.interrupt();
        self.state.propagation.interrupt();
        self.motion.rest = RestTracker::new();
        // A change in the gap is no change of the rate.
        self.motion.slow_turn.interrupt(dt_s);
        self.tilt.lost = self.tilt.lost || angle_rad > LOST_RAD;
        self.tilt.interrupt(dt_s);
        self.sample.after_gap = true;
        self.sample.step_s = 0.0;
    }

    /// Angle that may have been turned in a gap of which only the rate before it is known, radians.
    fn blind_rad(&self, dt_s: f32) -> f32 {
        (libm::sqrtf(self.sample.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S) * limited_s(dt_s)
    }

    /// Inflates the bias by its random walk over a gap.
    fn walk_bias(&mut self, dt_s: f32) {
        let config = &self.settings.config;
        let walk = config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * limited_s(dt_s);
        let most = config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s;
        for k in 0..3 {
            self.state.errors.inflate(BIAS + k, walk, most);
        }
    }

    /// Takes the sample's calibrated vectors in the body frame: specific force (m/s^2, up at rest) and field
    /// (microtesla); `None` for one that is missing, clipped or known to be wrong. Call it after every
    /// [`AttitudeFilter::propagate`].
    pub fn observe(&mut self, accel_m_s2: Option<&Vector3<f32>>, mag_ut: Option<&Vector3<f32>>) {
        if !self.started {
            return;
        }
        // Accelerometers end at some 200 g, magnetometers at some 5 mT.
        let accel = accel_m_s2.filter(|a| a.norm_squared() < 1e8);
        let mag = mag_ut.filter(|m| (1e-2..1e8).contains(&m.norm_squared()));
        (self.sample.accel_seen, self.sample.mag_seen) = (accel.is_some(), mag.is_some());
        self.motion.rest.update(&self.sample.rate_rad_s, accel, self.sample.step_s);
        if !self.tilt.aligned || self.tilt.lost {
            // Free fall has no direction.
            let gravity_m_s2 = self.settings.earth.gravity_m_s2;
            let least = 0.01 * gravity_m_s2 * gravity_m_s2;
            if let Some(force) = accel.filter(|a| a.norm_squared() > least) {
                self.align(force, mag);
                return;
            }
            if !self.tilt.aligned {
                return;
            }
        }
        if let Some(force) = accel {
            let force = self.state.rotation * force;
            self.force_change.update(&force, self.sample.step_s);
            self.step.add_force(&force);
        }
        self.turned_field.pass(self.sample.step_s);
        if let Some(field) = mag {
            let field = self.state.rotation * field;
            self.step.add_field(&field);
            self.report.is_stale |= self.turned_field.update(&field);
        }
        if self.step.time_s + 0.5 * self.sample.step_s >= STEP_S {
            self.close_step();
        }
    }

    /// Aligns the attitude to one reading of force and field: the first, or one after the attitude was lost.
    fn align(&mut self, force: &Vector3<f32>, field: Option<&Vector3<f32>>) {
        let first = !self.tilt.aligned;
        let force_ned = self.state.rotation * force;
        self.tilt.align_anew(&mut self.state, &mut self.heading, &force_ned, &self.settings);
        self.step = FilterStep::new();
        self.report.is_stale = true;
        if first && let Some(field) = field {
            Heading::face_north(&mut self.state, field, &self.settings.earth);
        }
    }

    /// Closes a filter step: predicts over it, then updates by its force, by rest and by its field.
    fn close_step(&mut self) {
        let Self { settings, sensors, state, motion, tilt, heading, agreement, turned_field, .. } = self;
        let step = core::mem::replace(&mut self.step, FilterStep::new());
        let gravity_m_s2 = settings.earth.gravity_m_s2;
        let (read, field) = (step.mean_force(), step.mean_field());
        let force = if tilt.force_is_sound(&step, heading.agrees(), gravity_m_s2) { read } else { None };

        let (step_s, scale) = (self.sample.step_s, sensors.scale_sigma);
        let mut noise = motion.process_noise(&step, force.is_some(), step_s, scale, settings);
        if state.scale.by_data_sheet {
            // Constants, while two priors of them are compared: after a walk an old estimate would look like a new one.
            noise.scale = 0.0;
        }
        // Scale and coupling errors act on a sustained rotation as a bias does.
        noise.bias += scale * scale * motion.sustained.update(&step);
        noise.attitude += Matrix3::from_diagonal_element(agreement.process_noise(step.time_s));
        tilt.note_force(force.is_some(), step.time_s);
        motion.shaking.update(force.as_ref(), step.time_s);
        let gravity_time = if force.is_some() { gravity_m_s2 * step.time_s } else { 0.0 };
        let rate = step.angle_rad / step.time_s;
        state.errors.predict(&step.rotation_time, gravity_time, &rate, &noise);

        tilt.update_velocity(state, force, &motion.rest, step.time_s, settings);
        motion.slow_turn.update(state, &step, motion.rest.detected());
        if motion.rest.detected() && motion.slow_turn.is_none() {
            state.update_at_rest(&step);
        }
        if let Some(field) = &field {
            let conditions = Conditions {
                sustained: &motion.sustained,
                tilt_is_settled: tilt.is_settled(),
                force_seen: tilt.force_seen_lately(),
                timing_variance_s2: sensors.mag_timing_variance_s2,
                offset_variance_ut2: sensors.mag_offset_variance_ut2,
            };
            let used = heading.update(state, field, &step, &conditions, settings);
            heading.note_field(used, step.time_s);
            if used {
                turned_field.agree(field);
            }
        }
        let agreed = heading.field_used && field.is_some();
        if let Some(force) = read {
            agreement.update(&force, field.as_ref(), step.time_s);
            if !agreed && heading.is_observed() {
                agreement.contradict(state, heading, turned_field, field.as_ref(), settings);
            }
        }
        heading.note_agreement(agreed, step.time_s);

        let estimates_scale = state.errors.estimates_scale();
        if !state.correct(&settings.config) && estimates_scale {
            sensors.scale_sigma = gyro_scale::start(state, settings);
        }
        gyro_scale::check(state, settings);
        gyro_scale::compare_priors(state, step.time_s, settings);
        tilt.check(state, heading, read, motion.shaking.density(), step.time_s, settings);
        state.refresh_rotation();
        self.report.is_stale = true;
    }

    /// Resets the velocity, and drops the filter step in progress.
    fn stop(&mut self) {
        self.state.reset_velocity(&self.settings.config);
        self.step = FilterStep::new();
    }

    fn inflate(&mut self, angle_rad: f32) {
        self.state.inflate_attitude(angle_rad * angle_rad);
        self.report.is_stale = true;
    }

    /// Restarts the average of the field's reference, after a change of the effects taken out of the field.
    pub const fn field_changed(&mut self) {
        self.heading.relearn_reference();
    }

    /// Sets whether the gyro's delay is known. If not, the attitude is uncertain by the turn of half a sample
    /// period either way, uniform.
    pub const fn gyro_delay_known(&mut self, known: bool) {
        self.sensors.gyro_timing_variance = if known { 0.0 } else { 1.0 / 12.0 };
    }

    /// Sets the deviation of the magnetometer's delay against the gyro, seconds, after it is taken out; `None`: the
    /// delay is not known.
    pub fn mag_delay_known(&mut self, sigma_s: Option<f32>) {
        if self.started {
            self.sensors.set_mag_delay(sigma_s, &self.settings.config);
        }
    }

    /// Deviation of the magnetometer's delay against the gyro, seconds, after it is taken out.
    pub(crate) fn mag_delay_sigma_s(&self) -> f32 {
        libm::sqrtf(self.sensors.mag_timing_variance_s2)
    }

    /// Sets the variance on an axis of what effects and magnets take out of the field, microtesla^2.
    pub(crate) const fn field_offset_known(&mut self, variance_ut2: f32) {
        self.sensors.mag_offset_variance_ut2 = variance_ut2;
    }
}

impl Default for AttitudeFilter {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
