//! The attitude at the end of a recording, and size and dip of what its vector sensors read there.

use meerkat_mwd::{Config, attitude::Attitude};

use super::toolface::{has_north, is_vertical, toolface_rad};
use crate::{diagnosis::Totals, number::fixed};
use testbed::flight::Flight;

/// Two lines: the angles with one standard deviation each; |G|, |B| and dip.
#[must_use]
pub fn lines(config: &Config, flight: &Flight, totals: &Totals) -> [String; 2] {
    let last = flight.outputs().filter_map(|output| Some((output.t_us, output.attitude?))).last();
    let angles = match last {
        Some((t_us, attitude)) => format!("{} at {:.1} s", angles(config, &attitude), 1e-6 * t_us as f64),
        None => "none: no gravity was read".to_owned(),
    };
    let total = |name: &str, value: Option<f64>, decimals: usize, unit: &str| match value {
        Some(value) => format!("{name} {} {unit}", fixed(value, decimals)),
        None => format!("{name} unknown"),
    };
    let totals = [
        total("|G|", totals.gravity_m_s2, 3, "m/s^2"),
        total("|B|", totals.field_ut, 2, "uT"),
        total("dip", totals.dip_deg, 2, "deg"),
    ];
    [angles, format!("{}: of the mean readings of the last second", totals.join(", "))]
}

fn angles(config: &Config, attitude: &Attitude) -> String {
    let angle = |radians: f32, sigma_rad: f32| {
        format!("{} +- {} deg", fixed(radians.to_degrees(), 2), fixed(sigma_rad.to_degrees(), 2))
    };
    let azimuth = match (has_north(attitude), config.earth.declination_rad) {
        (false, _) => "azimuth unknown".to_owned(),
        (true, declination) => {
            let north = if declination.is_some() { "true" } else { "magnetic" };
            format!("azimuth {} from {north} north", angle(attitude.azimuth_rad, attitude.sigma_azimuth_rad))
        }
    };
    let kind = if is_vertical(attitude) { "magnetic" } else { "gravity" };
    format!(
        "inclination {}, {azimuth}, {kind} toolface {}",
        angle(attitude.inclination_rad, attitude.sigma_inclination_rad),
        angle(toolface_rad(attitude), attitude.sigma_toolface_rad)
    )
}
