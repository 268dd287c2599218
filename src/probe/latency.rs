//! Delays of the vector sensors behind the gyro, as configured, and the uncertainty of the magnetometer's delay.

use crate::{
    compensation::{ActiveEffects, Effect, effect::Sensor},
    config::Latency,
    sample::Reading,
};
use nalgebra::Vector3;

/// Turns a vector sensor's reading to the time at which the gyro's was true, `behind_s` seconds later. Rate and
/// acceleration are those of the gyro's time, rad/s and rad/s^2.
pub(super) fn at_gyro_time(
    reading: Reading,
    behind_s: f32,
    rate_rad_s: &Vector3<f32>,
    acceleration_rad_s2: &Vector3<f32>,
) -> Reading {
    let Reading::Usable(v) = reading else { return reading };
    // Rate at the middle of the delay.
    let turn = (rate_rad_s - acceleration_rad_s2 * (0.5 * behind_s)) * behind_s;
    Reading::Usable(later(&v, &turn))
}

/// Standard deviation of the magnetometer's delay, seconds, without the attitude filter's own floor: the sigma of a
/// delay found among the effects, or 0 for a configured delay. `None`: the delay is unknown.
pub(super) fn mag_delay_sigma_s(effects: &ActiveEffects, library: &[&dyn Effect], configured: &Latency) -> Option<f32> {
    let found = effects.iter().find_map(|found| {
        let effect = library.get(usize::from(found.index))?;
        let of_field = effect.is_delay() && effect.sensor() == Sensor::Magnetometer;
        let of_gyro = effect.gyro_delay_s(&found.parameters) != 0.0;
        found.sigma.first().copied().filter(|_| of_field || of_gyro)
    });
    found.or(configured.mag_s.map(|_| 0.0))
}

/// Reading of an earth-fixed vector after the body has turned by a rotation vector, to second order: the error is
/// within 6e-4 of the vector's length at 0.15 rad (10 ms at 860 deg/s).
#[inline(never)]
fn later(v: &Vector3<f32>, turn_rad: &Vector3<f32>) -> Vector3<f32> {
    let halfway = v - turn_rad.cross(v) * 0.5;
    v - turn_rad.cross(&halfway)
}

#[cfg(test)]
mod tests;
