//! What the field says of the heading.

use super::{AttitudeFilter, LOST_RAD, gravity::ALIGNMENT_S};
use crate::{
    attitude::{
        block::Block,
        error_state::{Gain, HEADING},
        field_reference::TURNING_RAD_S,
    },
    config::{AttitudeConfig, Earth},
};
use core::f32::consts::TAU;
use nalgebra::Vector3;

/// Correlation time of the calibrated field's direction error, seconds. It is fixed in the probe, so it is another one after a turn by a
/// radian, which takes so long at the slowest rate that counts as turning.
const FIELD_CORRELATION_S: f32 = 1.0 / TURNING_RAD_S;
/// Correlation time of rate times delay, seconds: of a swing at half a hertz a radian.
const TIMING_CORRELATION_S: f32 = 0.3;
/// A reading of a magnetometer is held for so long, seconds, from reading to reading another part of it: one at 100 Hz (AK8963, mode 2).
const HOLD_S: f32 = 0.01;
/// The field says nothing of the bias when gravity has not been seen for so long, seconds: with 0.4 (m/s^2)^2/Hz the speed is then unknown by
/// more than the half metre a second that it is assumed to have.
const UNSEEN_FORCE_S: f32 = 1.0;
/// A field that agreed agrees for so long, seconds: some magnetometers are read 8 to 10 times a second.
const AGREEMENT_S: f32 = 0.5;
/// A field's heading beyond this many sigma is not used: by chance once in 16,000.
const HEADING_GATE: f32 = 4.0;
/// An undisturbed field that contradicts the heading for this long is believed, seconds: ten of its correlation times.
const HEADING_CONTRADICTION_S: f32 = 30.0;
/// The heading starts as the mean of this many blocks' fields (1 s).
const HEADING_ALIGNMENT_BLOCKS: u16 = 20;

impl AttitudeFilter {
    /// Whether the field was of late what the attitude makes of it, so that the tilt cannot be far off.
    pub(super) fn field_agrees(&self) -> bool {
        self.unagreed_s < AGREEMENT_S && self.heading_blocks >= HEADING_ALIGNMENT_BLOCKS
    }

    /// Which axes of the bias the heading tells: none without gravity, and in a sustained rotation that of the rotation only, since an
    /// error of the field that turns with the probe looks like a bias of the others.
    fn biases_in_heading(&self) -> [bool; 3] {
        let seen = self.unseen_force_s < UNSEEN_FORCE_S;
        self.sustained.axes().unwrap_or([true; 3]).map(|axis| axis && seen)
    }

    /// Whether the field was used for the heading.
    pub(super) fn observe_field(
        &mut self,
        field: &Vector3<f32>,
        block: &Block,
        config: &AttitudeConfig,
        earth: &Earth,
    ) -> bool {
        let horizontal_squared = field.x * field.x + field.y * field.y;
        let norm_squared = field.norm_squared();
        if self.aligned_s < ALIGNMENT_S {
            // a dip that is read against a wrong tilt would become the reference
            return false;
        }
        // within 3 deg of a magnetic pole, or no field
        if norm_squared < 0.01 || horizontal_squared < 0.0025 * norm_squared {
            return false;
        }
        let dip_rad = libm::atan2f(field.z, libm::sqrtf(horizontal_squared));
        let squared_rate = block.squared_rate();
        let compared =
            self.reference.compare(libm::sqrtf(norm_squared), dip_rad, libm::sqrtf(squared_rate), block.time_s, config);
        let Some(deviation) = compared else { return false };
        let north_rad = earth.declination_rad.unwrap_or(0.0);
        let innovation = libm::remainderf(north_rad - libm::atan2f(field.y, field.x), TAU);
        // an error of the field's direction turns the heading the more the steeper the field dips; what is seen of a disturbance
        // in norm and dip is there as much across, unseen
        let steepness = norm_squared / horizontal_squared;
        let direction = (config.mag_sigma_rad * config.mag_sigma_rad + deviation) * steepness;
        // a tilt about the field's horizontal direction turns its heading by so much
        let slope = field.xy() * (-field.z / horizontal_squared);
        if self.heading_blocks < HEADING_ALIGNMENT_BLOCKS {
            let (north_tilt, east_tilt) = (self.errors.variance(0), self.errors.variance(1));
            let tilt = (steepness - 1.0) * if north_tilt > east_tilt { north_tilt } else { east_tilt };
            let settled = tilt < 4.0 * direction && self.errors.variance(HEADING) < LOST_RAD * LOST_RAD;
            self.heading_blocks = if settled { self.heading_blocks + 1 } else { 1 };
            self.errors.open(HEADING, direction + tilt);
            self.turn_heading(innovation / f32::from(self.heading_blocks));
            self.heading_floor = 0.25 * config.mag_sigma_rad * config.mag_sigma_rad * steepness;
            return true;
        }
        let timing = self.timing_variance_s2 * squared_rate;
        let hold = HOLD_S * HOLD_S / 12.0 * squared_rate;
        let expected = self.errors.seen_heading_variance(&slope) + direction + 4.0 * (timing + hold);
        if innovation * innovation > HEADING_GATE * HEADING_GATE * expected {
            self.heading_contradiction_s += block.time_s;
            self.heading_doubt = innovation * innovation;
            if self.heading_contradiction_s > HEADING_CONTRADICTION_S {
                self.errors.open(HEADING, innovation * innovation);
            }
            return false;
        }
        self.heading_contradiction_s = 0.0;
        self.heading_doubt = 0.0;
        // a sustained rotation carries an error of the probe's own axes around, so that it averages out
        let carried = 1.0 + FIELD_CORRELATION_S * FIELD_CORRELATION_S * self.sustained.square();
        let correlated = direction * FIELD_CORRELATION_S / carried + timing * TIMING_CORRELATION_S;
        let variance = (2.0 * correlated + hold * HOLD_S) / block.time_s;
        self.errors.observe_heading(innovation, &slope, variance, Gain::Heading(self.biases_in_heading()));
        // an error that is constant in the probe does not average out while the probe keeps its attitude: half of it is of that kind
        self.heading_floor = 0.25 * config.mag_sigma_rad * config.mag_sigma_rad * steepness;
        true
    }
}
