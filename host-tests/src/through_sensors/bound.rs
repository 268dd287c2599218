//! How much quantisation may change the attitude.

use crate::flight::Flight;
use meerkat_mwd::Config;

/// Sensitivities of the adapters' ranges: 70 mdps, 0.488 mg (ISM330DHCX at 2000 dps and 16 g), 1/75 microtesla (RM3100 at 200 cycles).
const GYRO_DEG_S: f64 = 0.070;
const ACCEL_G: f64 = 0.488e-3;
const MAG_UT: f64 = 1.0 / 75.0;
/// Horizontal field where none is configured: that of 75 deg of dip in 58 microtesla.
const HORIZONTAL_UT: f64 = 15.0;
/// Deviations of a walk about three axes that one in 10,000 walks exceeds (chi-square with three degrees of freedom: 4.6).
const DEVIATIONS: f64 = 4.6;
/// How long a constant error of the rate acts before the vectors and the bias have made up for it, seconds.
const MEMORY_S: f64 = 10.0;

/// A bound of the difference of attitude between a recording that is handed over and the same recording through the models, degrees.
///
/// A reading is rounded to the nearest code: its error e is within half a code q on each axis.
///
/// * **gyro, moving.** Where the rate changes by a code or more from sample to sample, or has that much noise, e is white and uniform: variance
///   q^2/12. Integrated over a time T in steps of dt it makes a walk about each axis with variance q^2/12 T dt. Nothing that corrects the attitude
///   is counted on: T is the whole flight, and 4.6 deviations are taken.
/// * **gyro, at rest.** Where the rate stands within a code, e is a constant of up to q/2 on each axis, sqrt(3) q/2 together. The filter takes it for
///   bias; when the probe moves again e is white, and the bias is wrong by that much until the vectors have said so, within 10 s.
/// * **accelerometer.** Gravity's direction is off by at most sqrt(3)/2 q/g.
/// * **magnetometer.** The heading is off by at most sqrt(3)/2 q/H, H the horizontal field. The gain's error is common to the axes and
///   turns nothing.
///
/// All of them add up in the same direction. It holds for flights with one and the same model: what an identification makes of other
/// codes is not bounded by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantisationBound {
    /// The gyro's walk, degrees.
    pub gyro_walk_deg: f64,
    /// The gyro's constant, degrees.
    pub gyro_rest_deg: f64,
    /// The accelerometer's part, degrees.
    pub accel_deg: f64,
    /// The magnetometer's part, degrees.
    pub mag_deg: f64,
}

impl QuantisationBound {
    /// For a flight of so many samples.
    #[must_use]
    pub fn new(config: &Config, samples: usize) -> Self {
        let dt_s = f64::from(config.sample_period_us) * 1e-6;
        let flight_s = samples as f64 * dt_s;
        let earth = &config.earth;
        let horizontal_ut = match (earth.magnetic_field_ut, earth.dip_rad) {
            (Some(field_ut), Some(dip_rad)) => f64::from(field_ut) * f64::from(dip_rad).cos(),
            _ => HORIZONTAL_UT,
        };
        let half_diagonal = 3.0_f64.sqrt() / 2.0;
        Self {
            gyro_walk_deg: DEVIATIONS * GYRO_DEG_S / 12.0_f64.sqrt() * (flight_s * dt_s).sqrt(),
            gyro_rest_deg: half_diagonal * GYRO_DEG_S * MEMORY_S,
            accel_deg: (half_diagonal * ACCEL_G).to_degrees(),
            mag_deg: (half_diagonal * MAG_UT / horizontal_ut).to_degrees(),
        }
    }

    /// All of it, degrees.
    #[must_use]
    pub const fn total_deg(&self) -> f64 {
        self.gyro_walk_deg + self.gyro_rest_deg + self.accel_deg + self.mag_deg
    }
}

/// Largest and root-mean-square angle between the attitudes of two flights over the same times, degrees.
#[must_use]
pub fn largest_difference_deg(a: &Flight, b: &Flight) -> (f64, f64) {
    let angles: Vec<f64> = (a.outputs.iter().zip(&b.outputs))
        .filter_map(|(a, b)| {
            let dot: f64 = a.attitude?.q.iter().zip(b.attitude?.q).map(|(x, y)| f64::from(*x) * f64::from(y)).sum();
            // Of unit quaternions to f32: a small angle from its sine, which the cosine loses.
            let norm: f64 = a
                .attitude?
                .q
                .iter()
                .zip(b.attitude?.q)
                .map(|(x, y)| (f64::from(*x) - dot.signum() * f64::from(y)).powi(2))
                .sum();
            Some((4.0 * (norm.sqrt() / 2.0).min(1.0).asin()).to_degrees())
        })
        .collect();
    let rms = (angles.iter().map(|x| x * x).sum::<f64>() / angles.len().max(1) as f64).sqrt();
    (angles.iter().copied().fold(0.0, f64::max), rms)
}
