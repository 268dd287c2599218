//! Directions of the earth in tool axes at one station, and how the angles change with the readings.

use nalgebra::Vector3;

/// Least gravity, m/s^2, half of the true one: below it the accelerometer is broken.
pub(super) const LEAST_GRAVITY_M_S2: f32 = 4.9;
/// Least field, microtesla, under half of the weakest on earth (22).
pub(super) const LEAST_FIELD_UT: f32 = 10.0;
/// Least horizontal share of the field: one within 0.6 deg of the vertical gives no azimuth.
const LEAST_HORIZONTAL: f32 = 0.01;
/// Least sine of the inclination, the rounding of a unit vector in single precision: below it the azimuth is not
/// defined.
const LEAST_SINE: f32 = 1e-6;

/// Directions of the earth in tool axes, from one pair of vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub(super) north: Vector3<f32>,
    pub(super) east: Vector3<f32>,
    pub(super) down: Vector3<f32>,
    pub(super) gravity_m_s2: f32,
    pub(super) field_ut: f32,
    /// Horizontal field, microtesla.
    pub(super) horizontal_ut: f32,
    /// Vertical field, positive down, microtesla.
    pub(super) vertical_ut: f32,
    /// Dip, radians.
    pub(super) dip_rad: f32,
}

/// Derivative of one angle, radians per m/s^2 of force and per microtesla of field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gradient {
    pub(super) force: Vector3<f32>,
    pub(super) field: Vector3<f32>,
}

impl Axes {
    /// Directions from specific force and field; `None` if a vector is too short, or the field too near the vertical.
    pub(super) fn of(force_m_s2: &Vector3<f32>, field_ut: &Vector3<f32>) -> Option<Self> {
        let (gravity, field) = (length(force_m_s2), length(field_ut));
        if !(gravity.is_finite() && field.is_finite() && gravity > LEAST_GRAVITY_M_S2 && field > LEAST_FIELD_UT) {
            return None;
        }
        let down = force_m_s2 / -gravity;
        let vertical = down.dot(field_ut);
        let across = field_ut - down * vertical;
        let horizontal = length(&across);
        if horizontal < LEAST_HORIZONTAL * field {
            return None;
        }
        let north = across / horizontal;
        Some(Self {
            north,
            east: down.cross(&north),
            down,
            gravity_m_s2: gravity,
            field_ut: field,
            horizontal_ut: horizontal,
            vertical_ut: vertical,
            dip_rad: libm::atan2f(vertical, horizontal),
        })
    }

    /// Cosine and sine of the azimuth, and the sine of the inclination, not below [`LEAST_SINE`]; below that the
    /// azimuth is taken as 0.
    fn level(&self) -> [f32; 3] {
        let sine = libm::hypotf(self.north.z, self.east.z);
        if sine > LEAST_SINE { [self.north.z / sine, self.east.z / sine, sine] } else { [1.0, 0.0, LEAST_SINE] }
    }

    /// Sine of the inclination, not below [`LEAST_SINE`].
    pub(super) fn sine(&self) -> f32 {
        let [.., sine] = self.level();
        sine
    }

    /// Inclination, radians, 0 to pi.
    pub(super) fn inclination_rad(&self) -> f32 {
        libm::atan2f(libm::hypotf(self.north.z, self.east.z), self.down.z)
    }

    /// Magnetic azimuth of the tool axis, radians, -pi to pi.
    pub(super) fn azimuth_rad(&self) -> f32 {
        libm::atan2f(self.east.z, self.north.z)
    }

    /// Derivative of the azimuth. A change of force tilts the horizon: that moves north by the dip's tangent, and the
    /// tool axis over the horizon.
    pub(super) fn azimuth_gradient(&self) -> Gradient {
        let (n, e, [cos, sin, sine]) = (self.north, self.east, self.level());
        let tangent = self.vertical_ut / self.horizontal_ut;
        let tilt = (e * cos - n * sin) * (self.down.z / sine);
        Gradient { force: (tilt - e * tangent) / self.gravity_m_s2, field: e / -self.horizontal_ut }
    }

    /// Derivative of the inclination.
    pub(super) fn inclination_gradient(&self) -> Gradient {
        let [cos, sin, _] = self.level();
        let force = (self.north * cos + self.east * sin) / self.gravity_m_s2;
        Gradient { force, field: Vector3::zeros() }
    }

    /// Derivative of the dip: the horizon tilts along north, and the field turns in the meridian.
    pub(super) fn dip_gradient(&self) -> Gradient {
        let deeper = self.down * self.horizontal_ut - self.north * self.vertical_ut;
        Gradient { force: self.north / -self.gravity_m_s2, field: deeper / (self.field_ut * self.field_ut) }
    }
}

fn length(v: &Vector3<f32>) -> f32 {
    libm::sqrtf(v.norm_squared())
}
