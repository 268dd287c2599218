//! Heading: its start from the field, its updates, and the field's contradiction.

use super::{
    consistency::Consistency,
    error_state::{Gain, HEADING},
    field_reference::FieldReference,
    filter_step::FilterStep,
    settings::Settings,
    state::State,
    sustained::SustainedRotation,
};
use crate::{change::TURNING_RAD_S, config::Earth};
use core::f32::consts::{PI, TAU};
use nalgebra::Vector3;

/// Attitude uncertainty beyond which gravity and field give the attitude anew, radians: there the linear equations err
/// by more than 1.5 %, the sine's third order.
pub(super) const LOST_RAD: f32 = 0.3;
/// Correlation time of the calibrated field's direction error, seconds. The error is fixed in the probe and
/// changes after a turn by a radian, which takes this long at the slowest rate that counts as turning.
const FIELD_CORRELATION_S: f32 = 1.0 / TURNING_RAD_S;
/// Correlation time of rate times delay, seconds: one radian of phase of a 0.5 Hz swing.
const TIMING_CORRELATION_S: f32 = 0.3;
/// Time for which a magnetometer holds a reading, seconds: 100 Hz (AK8963, mode 2). Each sample falls at another point
/// of it.
const HOLD_S: f32 = 0.01;
/// Time for which an agreement of the field holds, seconds: some magnetometers are read 8 to 10 times a
/// second.
const AGREEMENT_S: f32 = 0.5;
/// Gate of the field's heading, in sigmas: exceeded by chance once in 16,000.
const HEADING_GATE: f32 = 4.0;
/// Time after which an undisturbed field that contradicts the heading is believed, seconds: ten correlation times of
/// the field's error.
const CONTRADICTION_S: f32 = 30.0;
/// Filter steps whose fields the first heading averages: 1 s.
const ALIGNMENT_STEPS: u16 = 20;

/// Heading as the field gives it or contradicts it.
pub(super) struct Heading {
    reference: FieldReference,
    /// Filter steps averaged in the first heading, at most [`ALIGNMENT_STEPS`]; 0: no heading has been observed, 1: the
    /// next field that is more certain than the heading gives it.
    steps: u16,
    /// True if the last step's field was used.
    pub field_used: bool,
    /// Time since the field agreed with the attitude, seconds.
    disagreed_s: f32,
    contradiction_s: f32,
    /// Time for which the field has yet to agree before it counts as used again, seconds.
    returning_s: f32,
    /// Variance of the heading that averaging does not reduce, rad^2.
    floor: f32,
    /// Squared angle between the heading and an undisturbed field that is not used, rad^2.
    doubt: f32,
}

/// Conditions of a heading update beside the field itself.
pub(super) struct Conditions<'a> {
    pub sustained: &'a SustainedRotation,
    /// True once the tilt is good enough to read a dip against.
    pub tilt_is_settled: bool,
    /// True if a usable force was read lately, so that gravity bounds the gyro's bias.
    pub force_seen: bool,
    /// Variance of the magnetometer's delay, s^2.
    pub timing_variance_s2: f32,
    /// Variance on an axis of a magnet's offset that was taken out of the field, microtesla^2.
    pub offset_variance_ut2: f32,
}

impl Heading {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self {
            reference: FieldReference::new(),
            steps: 0,
            field_used: false,
            disagreed_s: 0.0,
            contradiction_s: 0.0,
            returning_s: 0.0,
            floor: 0.0,
            doubt: 0.0,
        }
    }

    /// Creates a heading that has not been observed.
    pub fn new(earth: &Earth) -> Self {
        Self { reference: FieldReference::start(earth), ..Self::zero() }
    }

    /// Returns true once a field has given the heading.
    pub const fn is_observed(&self) -> bool {
        self.steps > 0
    }

    /// Marks the first heading as fully averaged, and not contradicted.
    pub const fn settle(&mut self) {
        (self.steps, self.contradiction_s, self.doubt) = (ALIGNMENT_STEPS, 0.0, 0.0);
    }

    /// Returns true if the field recently agreed with the attitude, so that the tilt cannot be far off.
    pub const fn agrees(&self) -> bool {
        self.disagreed_s < AGREEMENT_S && self.steps >= ALIGNMENT_STEPS
    }

    /// Time since the field agreed with the attitude, seconds.
    pub const fn disagreed_s(&self) -> f32 {
        self.disagreed_s
    }

    /// Returns true if the last field was used, and those of the half second before it: an attitude that a faulty gyro
    /// turns round agrees with the field in passing.
    pub const fn is_corrected(&self) -> bool {
        self.field_used && self.returning_s <= 0.0
    }

    /// Notes if a step's field was used.
    pub fn note_field(&mut self, used: bool, time_s: f32) {
        self.field_used = used;
        self.returning_s = if !used {
            AGREEMENT_S
        } else if self.returning_s > 0.0 {
            self.returning_s - time_s
        } else {
            0.0
        };
    }

    /// Notes if a step's field agreed with the attitude.
    pub fn note_agreement(&mut self, agreed: bool, time_s: f32) {
        self.disagreed_s = if agreed { 0.0 } else { self.disagreed_s + time_s };
    }

    /// Reference of the undisturbed field.
    pub const fn reference(&self) -> &FieldReference {
        &self.reference
    }

    /// Restarts the average of the reference field.
    pub const fn relearn_reference(&mut self) {
        self.reference.relearn();
    }

    /// Variance of the heading that averaging does not reduce, rad^2.
    pub const fn constant_variance(&self) -> f32 {
        self.floor
    }

    /// Squared angle between the heading and an undisturbed field that is not used, rad^2.
    pub const fn doubt(&self) -> f32 {
        self.doubt
    }

    /// Has the next field give a heading that was known before and whose variance, rad^2, is now too large.
    pub fn realign(&mut self, variance: f32) {
        if variance > LOST_RAD * LOST_RAD {
            self.restart();
        }
    }

    /// Resets a heading carried by a gyro worse than assumed; the next field gives it again.
    pub fn reset(&mut self, state: &mut State) {
        if self.steps > 1 {
            state.errors.reset(HEADING, PI * PI);
            state.consistency = Consistency::new();
            self.restart();
        }
    }

    fn restart(&mut self) {
        if self.steps > 1 {
            self.steps = 1;
        }
    }

    /// Turns the first attitude's heading to magnetic north by one field reading. A later step judges if that field is
    /// undisturbed.
    pub fn face_north(state: &mut State, field_ut: &Vector3<f32>, earth: &Earth) {
        let field = state.rotation * field_ut;
        let north_rad = earth.declination_rad.unwrap_or(0.0);
        state.turn_heading(north_rad - libm::atan2f(field.y, field.x));
        state.refresh_rotation();
    }

    /// Updates the heading by a step's mean field. Returns true if the field was used.
    pub fn update(
        &mut self,
        state: &mut State,
        field: &Vector3<f32>,
        step: &FilterStep,
        conditions: &Conditions<'_>,
        settings: &Settings,
    ) -> bool {
        let config = &settings.config;
        let horizontal_squared = field.x * field.x + field.y * field.y;
        let norm_squared = field.norm_squared();
        if !conditions.tilt_is_settled {
            // A dip read against a wrong tilt would become the reference.
            return false;
        }
        // Field within 3 deg of the vertical, as near a magnetic pole, or no field.
        if norm_squared < 0.01 || horizontal_squared < 0.0025 * norm_squared {
            return false;
        }
        let dip_rad = libm::atan2f(field.z, libm::sqrtf(horizontal_squared));
        let squared_rate = step.squared_rate();
        let (north_tilt, east_tilt) = (state.errors.variance(0), state.errors.variance(1));
        let tilt_variance = if north_tilt > east_tilt { north_tilt } else { east_tilt };
        let (norm_ut, rate_rad_s) = (libm::sqrtf(norm_squared), libm::sqrtf(squared_rate));
        // On a drill string the tilt is known better than a dip, and excuses nothing.
        let excused = if settings.goes_round { 0.0 } else { tilt_variance };
        let with = (config, &settings.earth);
        let compared = self.reference.compare([norm_ut, dip_rad], rate_rad_s, step.time_s, excused, with);
        let Some(deviation) = compared else { return false };
        let north_rad = settings.earth.declination_rad.unwrap_or(0.0);
        let innovation = libm::remainderf(north_rad - libm::atan2f(field.y, field.x), TAU);
        // An error of the field's direction turns the heading the more, the steeper the dip. A disturbance seen in norm
        // and dip is taken to be as large across the field, where it is not seen.
        let steepness = norm_squared / horizontal_squared;
        let offset = conditions.offset_variance_ut2 / norm_squared;
        let direction = (config.mag_sigma_rad * config.mag_sigma_rad + deviation + offset) * steepness;
        // Half of the error, and all of an offset's, is constant in the probe or in the place, and does not average out
        // while the attitude stays.
        let floor = (0.25 * config.mag_sigma_rad * config.mag_sigma_rad + offset) * steepness;
        // A tilt error about the field's horizontal direction turns the field's heading by this slope.
        let slope = field.xy() * (-field.z / horizontal_squared);
        if self.steps < ALIGNMENT_STEPS {
            let tilt = (steepness - 1.0) * tilt_variance;
            let (given, carried, lost) = (direction + tilt, state.errors.variance(HEADING), LOST_RAD * LOST_RAD);
            if given < lost || given < carried {
                let settled = tilt < 4.0 * direction && carried < lost;
                self.steps = if settled { self.steps + 1 } else { 1 };
                state.errors.reset(HEADING, given);
                state.turn_heading(innovation / f32::from(self.steps));
                self.floor = floor;
                return true;
            }
            // The heading that the gyro carries is more certain than one that this field would give: the update below
            // weighs both.
            if carried < lost {
                self.steps = ALIGNMENT_STEPS;
            }
        }
        let timing = conditions.timing_variance_s2 * squared_rate;
        let hold = HOLD_S * HOLD_S / 12.0 * squared_rate;
        let expected = state.errors.seen_heading_variance(&slope) + direction + 4.0 * (timing + hold);
        state.consistency.note_heading(innovation * innovation / expected, squared_rate, step.time_s);
        if innovation * innovation > HEADING_GATE * HEADING_GATE * expected {
            self.contradiction_s += step.time_s;
            self.doubt = innovation * innovation;
            if self.contradiction_s > CONTRADICTION_S {
                state.errors.reset(HEADING, innovation * innovation);
            }
            return false;
        }
        self.contradiction_s = 0.0;
        self.doubt = 0.0;
        // A sustained rotation carries an error of the probe's own axes around, so that it averages out.
        let carried = 1.0 + FIELD_CORRELATION_S * FIELD_CORRELATION_S * conditions.sustained.square();
        let correlated = direction * FIELD_CORRELATION_S / carried + timing * TIMING_CORRELATION_S;
        let variance = (2.0 * correlated + hold * HOLD_S) / step.time_s;
        state.errors.update_heading(innovation, &slope, variance, Gain::Heading(conditions.biases()));
        self.floor = floor;
        true
    }
}

impl Conditions<'_> {
    /// Axes of the bias that the heading corrects. None without gravity; in a sustained rotation only the
    /// rotation's axis, because a field error that turns with the probe looks like a bias of the other axes.
    fn biases(&self) -> [bool; 3] {
        self.sustained.axes().unwrap_or([true; 3]).map(|axis| axis && self.force_seen)
    }
}
