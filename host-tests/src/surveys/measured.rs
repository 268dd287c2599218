//! Measurement of a tool at a station, and the angles that follow.

use nalgebra::Vector3;

/// Standard gravity, m/s^2.
pub(super) const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Measurement of the tool at a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Specific force, m/s^2, and field, microtesla, tool axes (z down-hole, right-handed).
    SixAxis {
        /// Points up at rest.
        force_m_s2: Vector3<f64>,
        /// Field.
        field_ut: Vector3<f64>,
    },
    /// Inclination and azimuth from magnetic north, radians.
    Angles {
        /// From the vertical.
        inclination_rad: f64,
        /// From magnetic north.
        magnetic_azimuth_rad: f64,
    },
}

impl Measured {
    /// Inclination and magnetic azimuth, radians; `None` if the readings give none.
    pub(super) fn angles(&self) -> Option<[f64; 2]> {
        match self {
            Self::Angles { inclination_rad, magnetic_azimuth_rad } => Some([*inclination_rad, *magnetic_azimuth_rad]),
            Self::SixAxis { force_m_s2, field_ut } => {
                let down = -force_m_s2.try_normalize(1.0)?;
                let east = down.cross(field_ut).try_normalize(1e-3)?;
                let north = east.cross(&down);
                let across = libm::hypot(north.z, east.z);
                Some([libm::atan2(across, down.z), libm::atan2(east.z, north.z)])
            }
        }
    }

    /// Why readings give no angles.
    pub(super) fn why_unusable(&self) -> String {
        match self {
            Self::SixAxis { force_m_s2, field_ut } => {
                let [gravity, field] = [force_m_s2.norm(), field_ut.norm()];
                let which = if gravity < 0.5 * STANDARD_GRAVITY_M_S2 { "gravity" } else { "field" };
                format!(
                    "gravity of {gravity:.4} m/s^2 and a field of {field:.4} microtesla give no direction: check the unit and the values \
                     of the {which} columns"
                )
            }
            Self::Angles { .. } => "no angles".to_owned(),
        }
    }
}
