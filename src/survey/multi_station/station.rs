use crate::survey::station_axes::{Axes, LEAST_FIELD_UT, LEAST_GRAVITY_M_S2};
use nalgebra::Vector3;

/// Reference at one station.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StationReference {
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// Total magnetic field, microtesla.
    pub field_ut: f32,
    /// Dip below the horizon, radians.
    pub dip_rad: f32,
}

/// Mean readings at one station, tool axes (z down-hole), with the reference there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Station {
    /// Measured depth, metres, or any number that grows as the hole does: the drill string's magnetisation may grow
    /// along it.
    pub depth_m: f32,
    /// Calibrated specific force, m/s^2: at rest it points up.
    pub force_m_s2: [f32; 3],
    /// Calibrated field, microtesla.
    pub field_ut: [f32; 3],
    /// Reference at this station.
    pub reference: StationReference,
}

impl Station {
    /// Returns true if gravity and field are there and not parallel, and the reference is valid.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let StationReference { gravity_m_s2, field_ut, dip_rad } = self.reference;
        let reference = [gravity_m_s2, field_ut, dip_rad, self.depth_m].iter().all(|x| x.is_finite())
            && gravity_m_s2 > LEAST_GRAVITY_M_S2
            && field_ut > LEAST_FIELD_UT;
        reference && self.axes().is_some()
    }

    pub(super) fn axes(&self) -> Option<Axes> {
        Axes::of(&Vector3::from(self.force_m_s2), &Vector3::from(self.field_ut))
    }
}
