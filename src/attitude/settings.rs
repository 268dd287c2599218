//! Settings that the filter derives from its configuration and the earth.

use crate::{
    config::{AttitudeConfig, Earth, Motion},
    rotation::sine_and_cosine,
};
use nalgebra::Vector3;

/// Rotation of the earth, rad/s (WGS 84).
const EARTH_RATE_RAD_S: f32 = 7.292_115e-5;

/// Configuration of the attitude filter, from one start to the next.
pub(super) struct Settings {
    pub config: AttitudeConfig,
    pub earth: Earth,
    /// Rotation of the earth, NED, rad/s; zero if the latitude is unknown.
    pub earth_rate_ned_rad_s: Vector3<f32>,
    /// True if the probe turns with a drill string, false if it is moved by hand.
    pub goes_round: bool,
}

impl Settings {
    /// All zero, for a static.
    pub const UNSET: Self = Self {
        config: AttitudeConfig::UNSET,
        earth: Earth::UNSET,
        earth_rate_ned_rad_s: Vector3::new(0.0, 0.0, 0.0),
        goes_round: false,
    };

    pub fn new(config: &AttitudeConfig, earth: &Earth, motion: Motion) -> Self {
        let rate = earth.latitude_rad.map_or(Vector3::zeros(), |latitude_rad| {
            let (sine, cosine) = sine_and_cosine(latitude_rad);
            Vector3::new(cosine, 0.0, -sine) * EARTH_RATE_RAD_S
        });
        Self { config: *config, earth: *earth, earth_rate_ned_rad_s: rate, goes_round: motion == Motion::DrillString }
    }
}
