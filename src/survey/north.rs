//! Conversion of magnetic azimuths to true and grid north.

use super::Uncertain;
use crate::{
    attitude::positive_angle,
    config::{Earth, SurveyConfig},
};
use core::f32::consts::PI;

/// Azimuths from true and grid north, of one magnetic azimuth.
pub(crate) struct Norths {
    /// Magnetic azimuth plus declination; `None` without a configured declination.
    pub(crate) true_azimuth_rad: Option<Uncertain>,
    /// True azimuth less grid convergence; `None` if either is not configured.
    pub(crate) grid_azimuth_rad: Option<Uncertain>,
}

impl Norths {
    /// Converts an azimuth in a horizontal field of `horizontal_ut`. The declination's error is the
    /// reference's: DEC, and DBH over the horizontal field.
    pub(crate) fn of(magnetic: Uncertain, horizontal_ut: f32, earth: &Earth, config: &SurveyConfig) -> Self {
        let errors = &config.errors;
        let of_field = if horizontal_ut > 0.0 { errors.declination_rad_ut / horizontal_ut } else { PI };
        let variance =
            magnetic.sigma * magnetic.sigma + errors.declination_rad * errors.declination_rad + of_field * of_field;
        let sigma = if variance < PI * PI { libm::sqrtf(variance) } else { PI };
        let turned = |azimuth: f32, by: f32| positive_angle(libm::remainderf(azimuth + by, 2.0 * PI));
        let true_azimuth_rad = earth.declination_rad.map(|by| Uncertain { value: turned(magnetic.value, by), sigma });
        let grid_azimuth_rad = true_azimuth_rad
            .zip(config.grid_convergence_rad)
            .map(|(azimuth, by)| Uncertain { value: turned(azimuth.value, -by), sigma });
        Self { true_azimuth_rad, grid_azimuth_rad }
    }
}

#[cfg(test)]
mod tests;
