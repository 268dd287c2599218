//! Bound on how much quantisation may change the attitude.

use crate::flight::Flight;
use meerkat_mwd::{
    Config,
    attitude::{Attitude, AttitudeFlags},
};

/// Sensitivities of the adapters' ranges: 70 mdps, 0.488 mg (ISM330DHCX at 2000 dps and 16 g), 1/75
/// microtesla (RM3100 at 200 cycles).
const GYRO_DEG_S: f64 = 0.070;
const ACCEL_G: f64 = 0.488e-3;
const MAG_UT: f64 = 1.0 / 75.0;
/// Horizontal field where none is configured: that of 75 deg of dip in 58 microtesla.
const HORIZONTAL_UT: f64 = 15.0;
/// Radius in deviations that a random walk about three axes exceeds once in 10,000 (chi-square with three
/// degrees of freedom: 4.6).
const DEVIATIONS: f64 = 4.6;
/// Time for which a constant rate error acts before vectors and bias have corrected it, seconds.
const MEMORY_S: f64 = 10.0;

/// Bound on the attitude difference between a recording as it is and the same recording through the sensor
/// models, degrees.
///
/// A reading is rounded to the nearest code: its error e is within half a code q on each axis.
///
/// * **gyro, moving.** Where the rate changes by a code or more from sample to sample, or has that much
///   noise, e is white and uniform: variance q^2/12. Integrated over a time T in steps of dt it makes a walk
///   about each axis with variance q^2/12 T dt. Nothing that corrects the attitude is counted on: T is the
///   whole flight, and 4.6 deviations are taken.
/// * **gyro, at rest.** Where the rate stands within a code, e is a constant of up to q/2 on each axis,
///   sqrt(3) q/2 together. The filter takes it for bias; when the probe moves again e is white, and the bias
///   is wrong by that much until the vectors have said so, within 10 s.
/// * **accelerometer.** Gravity's direction is off by at most sqrt(3)/2 q/g.
/// * **magnetometer.** The heading is off by at most sqrt(3)/2 q/H, H the horizontal field. The gain's error
///   is common to the axes and turns nothing.
///
/// The parts are added as if all pointed the same way. The bound holds for flights with one and the same
/// model: an identification on other codes is not bounded by it. It holds while both flights decide the same:
/// a reading at a threshold is over it in one code and under it in the next, and a rest that is seen a few
/// filter steps earlier corrects the attitude that much earlier ([`Difference::undecided`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantisationBound {
    /// Part of the gyro in motion: a random walk, degrees.
    pub gyro_walk_deg: f64,
    /// Part of the gyro at rest: a constant taken for bias, degrees.
    pub gyro_rest_deg: f64,
    /// Part of the accelerometer, degrees.
    pub accel_deg: f64,
    /// Part of the magnetometer, degrees.
    pub mag_deg: f64,
}

impl QuantisationBound {
    /// The bound of a flight over this many samples.
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

    /// Sum of all parts, degrees.
    #[must_use]
    pub const fn total_deg(&self) -> f64 {
        self.gyro_walk_deg + self.gyro_rest_deg + self.accel_deg + self.mag_deg
    }
}

/// Difference between the attitudes of two flights over the same times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Largest angle, degrees.
    pub largest_deg: f64,
    /// Root mean square of the angles, degrees.
    pub rms_deg: f64,
    /// Outputs at which only one flight has decided something, such as that the probe rests: their sigmas
    /// differ, and the angle shows how far the attitude was off before. They are left out of the numbers
    /// above.
    pub undecided: usize,
    /// Largest angle at those outputs, degrees.
    pub undecided_deg: f64,
    /// Largest angle at those outputs, over the larger of the two stated deviations.
    pub undecided_deviations: f64,
}

/// Relative difference of sigmas above which the flights decided differently. Sigmas depend on decisions, and
/// on readings only through the attitude, here by less than a thousandth.
const SAME_SIGMA: f64 = 0.01;

impl Difference {
    /// Compares two flights.
    #[must_use]
    pub fn between(a: &Flight, b: &Flight) -> Self {
        let mut difference = Self::default();
        let (mut squares, mut decided) = (0.0, 0_usize);
        for (a, b) in a.outputs.iter().zip(&b.outputs) {
            let (Some(a), Some(b)) = (a.attitude, b.attitude) else { continue };
            let angle_deg = angle_deg(&a, &b);
            let (least, most) =
                (rotation_sigma(&a).min(rotation_sigma(&b)), rotation_sigma(&a).max(rotation_sigma(&b)));
            let tilts = (f64::from(a.sigma_inclination_rad), f64::from(b.sigma_inclination_rad));
            let same = |a: f64, b: f64| (a - b).abs() <= SAME_SIGMA * a.max(b);
            if same(least, most) && same(tilts.0, tilts.1) {
                decided += 1;
                squares += angle_deg * angle_deg;
                difference.largest_deg = difference.largest_deg.max(angle_deg);
            } else {
                difference.undecided += 1;
                difference.undecided_deg = difference.undecided_deg.max(angle_deg);
                let deviations = angle_deg.to_radians() / most;
                difference.undecided_deviations = difference.undecided_deviations.max(deviations);
            }
        }
        difference.rms_deg = (squares / decided.max(1) as f64).sqrt();
        difference
    }
}

/// Angle of the rotation from one attitude to the other, degrees.
fn angle_deg(a: &Attitude, b: &Attitude) -> f64 {
    let dot: f64 = a.q.iter().zip(b.q).map(|(x, y)| f64::from(*x) * f64::from(y)).sum();
    // Angle by its sine: the cosine loses a small angle of unit quaternions to f32.
    let norm: f64 = a.q.iter().zip(b.q).map(|(x, y)| (f64::from(*x) - dot.signum() * f64::from(y)).powi(2)).sum();
    (4.0 * (norm.sqrt() / 2.0).min(1.0).asin()).to_degrees()
}

/// Stated deviation of the whole rotation, radians: two tilts and a heading (near the vertical, the
/// toolface).
fn rotation_sigma(attitude: &Attitude) -> f64 {
    let near_vertical = attitude.flags.contains(AttitudeFlags::NEAR_VERTICAL);
    let heading = if near_vertical { attitude.sigma_toolface_rad } else { attitude.sigma_azimuth_rad };
    (2.0 * f64::from(attitude.sigma_inclination_rad).powi(2) + f64::from(heading).powi(2)).sqrt()
}
