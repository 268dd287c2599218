//! Attitude from one pair of mean vectors, gravity and field, with its error propagation.

use crate::attitude::{ToolAngleSigmas, ToolAngles};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Vector3};

/// Least gravity, m/s^2, half of the true one: below it the accelerometer is in free fall or broken.
const LEAST_GRAVITY_M_S2: f32 = 4.9;
/// Least horizontal share of the field: one within 0.6 deg of the vertical gives no azimuth.
const LEAST_HORIZONTAL: f32 = 0.01;

/// Attitude by two vectors: gravity is down, the field has no east component.
pub(crate) struct SixAxis {
    /// Rotation from tool to magnetic NED; without a field north is arbitrary.
    c: Matrix3<f32>,
    gravity_m_s2: f32,
    /// Field in north, (zero) east and down.
    field_ut: Option<Vector3<f32>>,
}

/// Covariances of the two mean vectors, tool axes.
pub(crate) struct SixAxisCovariance {
    /// Covariance of gravity, (m/s^2)^2.
    pub(crate) gravity: Matrix3<f32>,
    /// Covariance of the field, microtesla^2.
    pub(crate) field: Matrix3<f32>,
}

impl SixAxis {
    /// Computes the attitude of gravity (positive down, m/s^2) and, if there is one, field (microtesla), both
    /// in tool axes; `None` without gravity.
    ///
    /// The rows of the matrix are north, east and down in tool axes: down along G, east along G x B, north
    /// along east x down. Its angles are the textbook's: azimuth atan2((Gx By - Gy Bx) |G|, Bz (Gx^2 + Gy^2)
    /// - Gz (Gx Bx + Gy By)), inclination atan2(hypot(Gx, Gy), Gz), gravity toolface atan2(Gy, -Gx).
    pub(crate) fn of(gravity_m_s2: &Vector3<f32>, field_ut: Option<&Vector3<f32>>) -> Option<Self> {
        let gravity = libm::sqrtf(gravity_m_s2.norm_squared());
        if !(gravity.is_finite() && gravity > LEAST_GRAVITY_M_S2) {
            return None;
        }
        let down = gravity_m_s2 / gravity;
        // False for a NaN too.
        let level =
            |b: &&Vector3<f32>| down.cross(b).norm_squared() > LEAST_HORIZONTAL * LEAST_HORIZONTAL * b.norm_squared();
        let field = field_ut.filter(level);
        let arbitrary = if down.x * down.x < 0.5 { Vector3::x() } else { Vector3::z() };
        let east = down.cross(field.unwrap_or(&arbitrary));
        let east = east / libm::sqrtf(east.norm_squared());
        let north = east.cross(&down);
        let c = Matrix3::new(north.x, north.y, north.z, east.x, east.y, east.z, down.x, down.y, down.z);
        Some(Self { c, gravity_m_s2: gravity, field_ut: field.map(|b| c * b) })
    }

    /// Angles; azimuth and magnetic toolface count from magnetic north, or an arbitrary one without a field.
    pub(crate) fn angles(&self) -> ToolAngles {
        ToolAngles::of(&self.c)
    }

    /// Direction of gravity in tool axes.
    fn down(&self) -> Vector3<f32> {
        Vector3::new(self.c.m31, self.c.m32, self.c.m33)
    }

    pub(crate) const fn gravity_m_s2(&self) -> f32 {
        self.gravity_m_s2
    }

    /// Total and horizontal field, microtesla, and dip, radians.
    pub(crate) fn field(&self) -> Option<Field> {
        let b = self.field_ut?;
        Some(Field { total_ut: libm::sqrtf(b.norm_squared()), horizontal_ut: b.x, dip_rad: libm::atan2f(b.z, b.x) })
    }

    /// Standard deviations of the angles.
    ///
    /// With the attitude's error phi (NED, `C_true = exp(phi) C`) and the vectors' errors in NED, e of
    /// gravity and f of the field: phi = (-e_east, e_north, -tan(dip) e_east) / |G| + (0, 0, f_east /
    /// B_horizontal).
    pub(crate) fn angle_sigmas(&self, covariance: &SixAxisCovariance) -> ToolAngleSigmas {
        let g = 1.0 / self.gravity_m_s2;
        let of_gravity = |tangent: f32| Matrix3::new(0.0, -g, 0.0, g, 0.0, 0.0, 0.0, -g * tangent, 0.0) * self.c;
        let attitude = match self.field_ut {
            Some(b) => {
                let from_gravity = of_gravity(b.z / b.x);
                let from_field = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0 / b.x, 0.0) * self.c;
                from_gravity * covariance.gravity * from_gravity.transpose()
                    + from_field * covariance.field * from_field.transpose()
            }
            None => {
                let from_gravity = of_gravity(0.0);
                from_gravity * covariance.gravity * from_gravity.transpose()
                    + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, PI * PI))
            }
        };
        ToolAngleSigmas::of(&self.c, &attitude)
    }

    /// Standard deviation of |G|, m/s^2.
    pub(crate) fn gravity_sigma_m_s2(&self, covariance: &SixAxisCovariance) -> f32 {
        sigma(&self.down(), &covariance.gravity)
    }

    /// Standard deviations of |B|, microtesla, and of the dip, radians: gravity's error along north tilts the
    /// horizon.
    pub(crate) fn field_sigmas(&self, covariance: &SixAxisCovariance) -> Option<(f32, f32)> {
        let b = self.field_ut?;
        let total = libm::sqrtf(b.norm_squared());
        let (north, down) = (Vector3::new(self.c.m11, self.c.m12, self.c.m13), self.down());
        let along = (north * b.x + down * b.z) / total;
        let deeper = (down * b.x - north * b.z) / (total * total);
        let of_field = sigma(&deeper, &covariance.field);
        let of_gravity = sigma(&north, &covariance.gravity) / self.gravity_m_s2;
        let dip = libm::sqrtf(of_field * of_field + of_gravity * of_gravity);
        Some((sigma(&along, &covariance.field), dip))
    }
}

/// Measured field of the earth.
pub(crate) struct Field {
    pub(crate) total_ut: f32,
    pub(crate) horizontal_ut: f32,
    pub(crate) dip_rad: f32,
}

fn sigma(direction: &Vector3<f32>, covariance: &Matrix3<f32>) -> f32 {
    let variance = direction.dot(&(covariance * direction));
    libm::sqrtf(if variance > 0.0 { variance } else { 0.0 })
}

#[cfg(test)]
mod tests;
