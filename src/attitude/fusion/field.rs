//! Update of the heading by the field.

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

/// Correlation time of the calibrated field's direction error, seconds. The error is fixed in the probe and
/// changes after a turn by a radian: that long at the slowest rate that counts as turning.
const FIELD_CORRELATION_S: f32 = 1.0 / TURNING_RAD_S;
/// Correlation time of rate times delay, seconds: a radian of a swing at half a hertz.
const TIMING_CORRELATION_S: f32 = 0.3;
/// Hold of a magnetometer's reading, seconds: each sample sees another part of it at 100 Hz (AK8963, mode 2).
const HOLD_S: f32 = 0.01;
/// Time without gravity after which the field no longer corrects the bias, seconds: with 0.4 (m/s^2)^2/Hz the
/// speed is then less certain than the assumed half metre a second.
const UNSEEN_FORCE_S: f32 = 1.0;
/// Time for which an agreement of the field holds, seconds: some magnetometers are read 8 to 10 times a
/// second.
const AGREEMENT_S: f32 = 0.5;
/// Gate of the field's heading, in sigmas: exceeded by chance once in 16,000.
const HEADING_GATE: f32 = 4.0;
/// Time after which an undisturbed field that contradicts the heading is believed, seconds: ten of its
/// correlation times.
const HEADING_CONTRADICTION_S: f32 = 30.0;
/// Filter steps whose fields the first heading averages: 1 s.
const HEADING_ALIGNMENT_BLOCKS: u16 = 20;

impl AttitudeFilter {
    /// Returns true if the field recently agreed with the attitude, so that the tilt cannot be far off.
    pub(super) fn field_agrees(&self) -> bool {
        self.unagreed_s < AGREEMENT_S && self.heading_blocks >= HEADING_ALIGNMENT_BLOCKS
    }

    /// Axes of the bias that the heading corrects. None without gravity; in a sustained rotation only the
    /// rotation's axis, because a field error that turns with the probe looks like a bias of the others.
    fn biases_in_heading(&self) -> [bool; 3] {
        let seen = self.unseen_force_s < UNSEEN_FORCE_S;
        self.sustained.axes().unwrap_or([true; 3]).map(|axis| axis && seen)
    }

    /// Updates the heading by a step's mean field. Returns true if the field was used.
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
            // A dip read against a wrong tilt would become the reference.
            return false;
        }
        // Within 3 deg of a magnetic pole, or no field.
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
        // An error of the field's direction turns the heading the more, the steeper the dip. A disturbance
        // seen in norm and dip is as large across the field, unseen.
        let steepness = norm_squared / horizontal_squared;
        let direction = (config.mag_sigma_rad * config.mag_sigma_rad + deviation) * steepness;
        // A tilt about the field's horizontal direction turns its heading by this slope.
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
        // A sustained rotation carries an error of the probe's own axes around, so that it averages out.
        let carried = 1.0 + FIELD_CORRELATION_S * FIELD_CORRELATION_S * self.sustained.square();
        let correlated = direction * FIELD_CORRELATION_S / carried + timing * TIMING_CORRELATION_S;
        let variance = (2.0 * correlated + hold * HOLD_S) / block.time_s;
        self.errors.observe_heading(innovation, &slope, variance, Gain::Heading(self.biases_in_heading()));
        // Half of the error is constant in the probe and does not average out while the attitude stays.
        self.heading_floor = 0.25 * config.mag_sigma_rad * config.mag_sigma_rad * steepness;
        true
    }
}
