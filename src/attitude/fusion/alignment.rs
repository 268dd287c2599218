//! Alignment: the attitude taken from one specific force.

use super::{ALIGNMENT_SIGMA_RAD, AttitudeFilter, HEADING, LOST_RAD, PI, ToolAngles};
use crate::{
    config::{AttitudeConfig, Earth},
    rotation::{exp_matrix, matrix, renormalised},
};
use nalgebra::{Quaternion, Vector3};

impl AttitudeFilter {
    /// Takes the tilt from a specific force (NED as far as the attitude is known) and resets its uncertainty.
    /// At the first alignment the heading counts from the tool axis; near the vertical, from the sum of
    /// azimuth and toolface.
    pub(super) fn align(&mut self, force_ned_m_s2: &Vector3<f32>, config: &AttitudeConfig, earth: &Earth) {
        let norm = libm::sqrtf(force_ned_m_s2.norm_squared());
        self.propagation.q = renormalised(&(to_upright(&(force_ned_m_s2 / norm)) * self.propagation.q));
        if !self.aligned {
            let angles = ToolAngles::of(&matrix(&self.propagation.q));
            let vertical = angles.inclination_rad < config.near_vertical_rad;
            self.turn_heading(-if vertical { angles.magnetic_toolface_rad } else { angles.azimuth_rad });
        }
        self.rotation = matrix(&self.propagation.q);
        self.sigmas_stale = true;
        let off_gravity = norm / earth.gravity_m_s2 - 1.0;
        let sigma = ALIGNMENT_SIGMA_RAD + off_gravity.abs();
        // A third of the shaking acts along each direction.
        let shaken = if self.mean_square_force > 1.0 { (self.mean_square_force - 1.0) / 3.0 } else { 0.0 };
        let variance = sigma * sigma + shaken;
        let heading = self.errors.variance(HEADING);
        for state in 0..HEADING {
            self.errors.open(state, if variance < PI * PI { variance } else { PI * PI });
        }
        self.errors.open(HEADING, heading);
        if heading > LOST_RAD * LOST_RAD && self.heading_blocks > 1 {
            // A heading that was known before is taken from the next field.
            self.heading_blocks = 1;
        }
        self.stop(config);
        self.smooth_force_m_s2 = Vector3::new(0.0, 0.0, -norm);
        (self.aligned, self.lost, self.accel_used) = (true, false, true);
    }

    /// Turns the first attitude's heading to magnetic north by one field reading. Whether that field is
    /// undisturbed is judged later.
    pub(super) fn face_north(&mut self, field_ut: &Vector3<f32>) {
        let field = self.rotation * field_ut;
        let north_rad = self.earth.declination_rad.unwrap_or(0.0);
        self.turn_heading(north_rad - libm::atan2f(field.y, field.x));
        self.rotation = matrix(&self.propagation.q);
    }

    pub(super) fn turn_heading(&mut self, angle_rad: f32) {
        let turn = Vector3::new(0.0, 0.0, angle_rad);
        self.propagation.correct(&turn);
        let velocity = exp_matrix(&turn) * self.velocity_m_s.push(0.0);
        self.velocity_m_s = velocity.xy();
    }
}

/// Shortest rotation of a unit vector to straight up, (0, 0, -1).
fn to_upright(up: &Vector3<f32>) -> Quaternion<f32> {
    // Half-way quaternion between a vector u and its image v: (1 + u.v, u x v), not yet normalised.
    let w = 1.0 - up.z;
    let squared = w * w + up.x * up.x + up.y * up.y;
    if squared > 1e-6 {
        Quaternion::new(w, -up.y, up.x, 0.0) * (1.0 / libm::sqrtf(squared))
    } else {
        Quaternion::new(0.0, 1.0, 0.0, 0.0)
    }
}
