//! Filter step: samples of 0.05 s, summed before the filter updates.

use nalgebra::{Matrix3, Vector3};

/// Samples of one filter step, summed in the earth frame. Rotation within the step is removed sample by
/// sample as the gyro saw it, so that the means lose nothing while the probe turns.
#[derive(Clone, Copy)]
pub(crate) struct FilterStep {
    /// Length of the step, seconds.
    pub(crate) time_s: f32,
    /// Integral of C (body to NED), seconds.
    pub(crate) rotation_time: Matrix3<f32>,
    /// Integral of the body rate, radians.
    pub(crate) angle_rad: Vector3<f32>,
    /// Integral of the squared rate, rad^2/s.
    squared_rate_time: f32,
    force_sum: Vector3<f32>,
    square_force_sum: f32,
    force_count: u16,
    field_sum: Vector3<f32>,
    field_count: u16,
}

impl FilterStep {
    pub(crate) const fn new() -> Self {
        const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
        Self {
            time_s: 0.0,
            rotation_time: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            angle_rad: ZERO,
            squared_rate_time: 0.0,
            force_sum: ZERO,
            square_force_sum: 0.0,
            force_count: 0,
            field_sum: ZERO,
            field_count: 0,
        }
    }

    /// Adds the interval that a sample ends, by its rate and C at its end.
    pub(crate) fn add_rotation(&mut self, c: &Matrix3<f32>, rate_rad_s: &Vector3<f32>, dt_s: f32) {
        self.time_s += dt_s;
        self.rotation_time += c * dt_s;
        self.angle_rad += rate_rad_s * dt_s;
        self.squared_rate_time += rate_rad_s.norm_squared() * dt_s;
    }

    /// Adds a specific force, NED, m/s^2.
    pub(crate) fn add_force(&mut self, force_ned_m_s2: &Vector3<f32>) {
        self.force_sum += force_ned_m_s2;
        self.square_force_sum += force_ned_m_s2.norm_squared();
        self.force_count += 1;
    }

    /// Adds a field, NED, microtesla.
    pub(crate) fn add_field(&mut self, field_ned_ut: &Vector3<f32>) {
        self.field_sum += field_ned_ut;
        self.field_count += 1;
    }

    /// Mean specific force, NED, m/s^2.
    pub(crate) fn mean_force(&self) -> Option<Vector3<f32>> {
        (self.force_count > 0).then(|| self.force_sum / f32::from(self.force_count))
    }

    /// Mean square of the specific force, (m/s^2)^2.
    pub(crate) fn mean_square_force(&self) -> Option<f32> {
        (self.force_count > 0).then(|| self.square_force_sum / f32::from(self.force_count))
    }

    /// Mean field, NED, microtesla.
    pub(crate) fn mean_field(&self) -> Option<Vector3<f32>> {
        (self.field_count > 0).then(|| self.field_sum / f32::from(self.field_count))
    }

    /// Mean square of the rate, (rad/s)^2.
    pub(crate) fn squared_rate(&self) -> f32 {
        self.squared_rate_time / self.time_s
    }
}
