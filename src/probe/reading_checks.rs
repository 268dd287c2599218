//! Checks of a sample's readings: missing, clipped, stale or dead ones are not used.

use super::{
    rail::Rail,
    staleness::{LONGEST_INTERVAL_S, Staleness},
};
use crate::{
    compensation::VectorModel,
    config::{Config, FullScale},
    sample::{Reading, Sample, SampleFlags, Sensor},
};
use nalgebra::Vector3;

/// Share of full scale at which a reading counts as clipped. Data sheets round full scales, and a saturated
/// 16-bit word can stand for as little as 99.9 % of them (2,000 deg/s at 16.4 LSB per deg/s saturate at
/// 1,998.0: MPU-9250 PS section 3.1).
pub const CLIPPED_SHARE: f32 = 0.998;

/// Time after which a gyro or accelerometer that repeats itself on all axes is stale, seconds. A live sensor has noise;
/// a dead sensor's readings are used until it is detected. A gyro whose last two different readings show no rotation
/// gets [`FROZEN_S`], because its noise can be below its resolution (ICM-42688-P: 20 mdps in 50 Hz against 61 mdps).
const STALE_INERTIAL_S: f32 = 0.05;
/// Time after which a magnetometer is stale, seconds: some magnetometers are read only 8 to 10 times a second.
const STALE_MAG_S: f32 = LONGEST_INTERVAL_S;
/// Time after which a sensor that repeats itself is flagged as frozen, seconds.
const FROZEN_S: f32 = 1.0;

/// Sine of the angle, 20 deg, by which force and field must turn in the body about an axis of the gyro to show that the
/// axis is dead. It is the turn of a second at the least rate that counts as turning (`TURNING_RAD_S`).
const SINE_TURNED: f32 = 0.342;
/// Least square of a unit vector's part across an axis about which it can show a turn: 10 deg, half of such a turn.
const LEAST_ACROSS: f32 = 0.03;
/// Length of a unit vector in a byte for each axis.
const UNIT: f32 = 127.0;

/// A value for each of the three vector sensors.
struct BySensor<T> {
    gyro: T,
    accel: T,
    mag: T,
}

impl<T> BySensor<T> {
    const fn of(&self, sensor: Sensor) -> &T {
        match sensor {
            Sensor::Gyro => &self.gyro,
            Sensor::Accelerometer => &self.accel,
            Sensor::Magnetometer => &self.mag,
        }
    }

    const fn of_mut(&mut self, sensor: Sensor) -> &mut T {
        match sensor {
            Sensor::Gyro => &mut self.gyro,
            Sensor::Accelerometer => &mut self.accel,
            Sensor::Magnetometer => &mut self.mag,
        }
    }
}

/// Checks of readings against full scales, rails, repeats and dead axes.
pub(super) struct ReadingChecks {
    /// Rate below which a gyro that repeats its reading may be at rest, rad/s.
    still_rad_s: f32,
    staleness: BySensor<Staleness>,
    gyro_rails: [Rail; 3],
    /// Directions of force and field in the body, in units of [`UNIT`], when an axis of the gyro began to repeat
    /// itself; zero: not read then.
    began: [[i8; 3]; 2],
    /// Axes of the gyro that have repeated themselves since, a bit each.
    repeating: u8,
}

impl ReadingChecks {
    /// All-zero value for a static before it is configured.
    pub const ZERO: Self = Self {
        still_rad_s: 0.0,
        staleness: BySensor { gyro: Staleness::zero(), accel: Staleness::zero(), mag: Staleness::zero() },
        gyro_rails: [Rail::zero(); 3],
        began: [[0; 3]; 2],
        repeating: 0,
    };

    pub fn new(config: &Config) -> Self {
        Self { still_rad_s: config.identification.max_bias_rad_s, ..Self::ZERO }
    }

    /// Flags the sensors of a sample that are at full scale, and a gyro that is at its rail.
    pub fn mark_clipped(&mut self, sample: &mut Sample, full_scale: &FullScale) {
        let limits = BySensor { gyro: full_scale.gyro_rad_s, accel: full_scale.accel_m_s2, mag: full_scale.mag_ut };
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        let rails = self.gyro_rails.iter_mut().zip(sample.gyro_rad_s);
        if !missing && rails.fold(false, |railed, (rail, x)| rail.update(x) || railed) {
            sample.flags.insert(SampleFlags::GYRO_CLIPPED);
        }
        for sensor in Sensor::ALL {
            let reading = sample.vector(sensor);
            let reaches = |limit: &f32| reading.iter().any(|x| libm::fabsf(*x) >= CLIPPED_SHARE * limit);
            if limits.of(sensor).as_ref().is_some_and(reaches) {
                sample.flags.insert(SampleFlags::clipped(sensor));
            }
        }
    }

    /// Takes a sample's readings, `step_s` seconds after those of the sample before. Returns true if one of the
    /// sensors, when it was last read, had repeated its reading for a second.
    pub fn update(&mut self, sample: &Sample, step_s: f32) -> bool {
        let turning = sample.gyro_rad_s.iter().any(|rate| libm::fabsf(*rate) >= self.still_rad_s);
        let unseen = !sample.flags.contains(SampleFlags::GYRO_MISSING) && self.has_turned_unseen(sample);
        let mut frozen = false;
        for sensor in Sensor::ALL {
            let is_gyro = matches!(sensor, Sensor::Gyro);
            let staleness = self.staleness.of_mut(sensor);
            staleness.pass(step_s);
            if !sample.flags.contains(SampleFlags::missing(sensor)) {
                staleness.update(sample.vector(sensor), turning || is_gyro && unseen);
            }
            frozen |= staleness.has_repeated_for(FROZEN_S) || (is_gyro && staleness.has_dead_turning_axis());
        }
        frozen
    }

    /// Returns true if force and field have turned in the body about an axis of the gyro since it began to repeat
    /// itself. One of them alone may have been moved by a magnet, or by a hand.
    #[inline(never)]
    fn has_turned_unseen(&mut self, sample: &Sample) -> bool {
        let axes = self.staleness.gyro.repeats(sample.gyro_rad_s);
        let going_on = self.repeating & axes;
        self.repeating = if going_on > 0 { going_on } else { axes };
        if axes == 0 {
            return false;
        }
        let mut turned = going_on;
        for (began, read) in self.began.iter_mut().zip([sample.accel_m_s2, sample.mag_ut]) {
            let read = Vector3::from(read);
            // A missing reading is zero, and NaN here: it has not turned, and begins as zero.
            let read = read * (UNIT / libm::sqrtf(read.norm_squared()));
            if going_on > 0 {
                let began = Vector3::from(began.map(f32::from));
                let turn = began.cross(&read);
                // About an axis that it lies along a vector shows no turn.
                turned &= turn.iter().zip(began.iter()).fold(0, |axes, (turn, along)| {
                    let across = UNIT * UNIT - along * along;
                    let has_turned = across > LEAST_ACROSS * UNIT * UNIT && libm::fabsf(*turn) > SINE_TURNED * across;
                    axes << 1 | u8::from(has_turned)
                });
            } else {
                *began = read.map(|x| x as i8).into();
            }
        }
        turned > 0
    }

    /// Returns true if a sensor has repeated its reading for the time after which it is stale.
    fn is_stale(&self, sensor: Sensor) -> bool {
        let staleness = self.staleness.of(sensor);
        staleness.has_repeated_for(match sensor {
            Sensor::Gyro if !staleness.is_lively() && staleness.is_still() => FROZEN_S,
            Sensor::Gyro | Sensor::Accelerometer => STALE_INERTIAL_S,
            Sensor::Magnetometer => STALE_MAG_S,
        })
    }

    /// Returns the gyro's reading with this raw rate, rad/s. A clipped or stale one is unusable.
    pub fn rate(&self, raw_rad_s: Vector3<f32>, sample: &Sample) -> Reading {
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            Reading::Missing
        } else if sample.flags.contains(SampleFlags::GYRO_CLIPPED)
            || self.is_stale(Sensor::Gyro)
            || self.staleness.of(Sensor::Gyro).has_dead_turning_axis()
        {
            Reading::Unusable
        } else {
            Reading::Usable(raw_rad_s)
        }
    }

    /// Returns the calibrated reading of a vector sensor. A clipped one is unusable, and so is a field that is stale or
    /// has a dead axis. Such a force counts as missing, for an unusable one is a blow beyond the full scale. So do
    /// three exact zeros.
    pub fn vector(&self, sensor: Sensor, model: &VectorModel, sample: &Sample) -> Reading {
        let raw = sample.vector(sensor);
        let is_dead = || self.staleness.of(sensor).has_dead_axis();
        if sample.flags.contains(SampleFlags::missing(sensor)) || raw == [0.0; 3] {
            Reading::Missing
        } else if sample.flags.contains(SampleFlags::clipped(sensor)) {
            Reading::Unusable
        } else if self.is_stale(sensor) || is_dead() {
            if matches!(sensor, Sensor::Accelerometer) { Reading::Missing } else { Reading::Unusable }
        } else {
            Reading::Usable(model.calibrate(raw))
        }
    }
}

#[cfg(test)]
mod tests;
