//! Checks of a sample's readings: missing, clipped, stale or dead ones are not used.

use super::{Probe, output::count};
use crate::{
    attitude::AttitudeFlags,
    compensation::VectorModel,
    sample::{Reading, Sample, SampleFlags, Sensor},
};

/// Share of full scale at which a reading counts as clipped. Data sheets round full scales, and a saturated
/// 16-bit word can stand for as little as 99.9 % of them (2,000 deg/s at 16.4 LSB per deg/s saturate at
/// 1,998.0: MPU-9250 PS section 3.1).
pub const CLIPPED_SHARE: f32 = 0.998;

/// Fraction of a second after which a gyro or accelerometer that repeats itself on all axes is stale. A live
/// one has noise, and readings of a dead one are believed until it is found out. A gyro that reads no
/// rotation twice in a row gets the whole second, because the noise of a quiet one is below its resolution
/// (ICM-42688-P: 20 mdps in 50 Hz against 61 mdps).
const STALE_INERTIAL_PART: u32 = 20;

/// Fraction of a second after which a magnetometer is stale: some are read only 8 to 10 times a second.
const STALE_MAG_PART: u32 = 4;

/// A value for each of the three vector sensors.
pub(super) struct BySensor<T> {
    pub gyro: T,
    pub accel: T,
    pub mag: T,
}

impl<T> BySensor<T> {
    pub const fn of(&self, sensor: Sensor) -> &T {
        match sensor {
            Sensor::Gyro => &self.gyro,
            Sensor::Accelerometer => &self.accel,
            Sensor::Magnetometer => &self.mag,
        }
    }

    pub const fn of_mut(&mut self, sensor: Sensor) -> &mut T {
        match sensor {
            Sensor::Gyro => &mut self.gyro,
            Sensor::Accelerometer => &mut self.accel,
            Sensor::Magnetometer => &mut self.mag,
        }
    }
}

impl Probe {
    /// Flags the sensors of a sample that are at full scale, and a gyro that is at its rail.
    pub(super) fn mark_clipped(&mut self, sample: &mut Sample) {
        let full_scale = &self.config.full_scale;
        let limits = BySensor { gyro: full_scale.gyro_rad_s, accel: full_scale.accel_m_s2, mag: full_scale.mag_ut };
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        let rails = self.session.gyro_rails.iter_mut().zip(sample.gyro_rad_s);
        if !missing && rails.fold(false, |railed, (rail, x)| rail.observe(x) || railed) {
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

    /// Counts the sample's faults and translates them into the attitude's flags.
    pub(super) fn flags(&mut self, sample: &Sample) -> AttitudeFlags {
        let clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        let mut flags = AttitudeFlags::empty();
        if sample.flags.intersects(clipped) {
            count(&mut self.session.counters.clipped);
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            count(&mut self.session.counters.gyro_missing);
            flags.insert(AttitudeFlags::GYRO_HELD);
        }
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        let limit = self.config.identification.max_bias_rad_s;
        let turning = sample.gyro_rad_s.iter().any(|rate| libm::fabsf(*rate) >= limit);
        for sensor in Sensor::ALL {
            if !sample.flags.contains(SampleFlags::missing(sensor)) {
                let staleness = self.session.staleness.of_mut(sensor);
                staleness.observe(sample.vector(sensor), turning);
                if staleness.same > self.samples_per_second {
                    flags.insert(AttitudeFlags::FROZEN_SENSOR);
                }
            }
        }
        flags
    }

    /// Returns true if a sensor has repeated its reading for its part of a second.
    pub(super) fn is_stale(&self, sensor: Sensor) -> bool {
        let staleness = self.session.staleness.of(sensor);
        let part = match sensor {
            Sensor::Gyro if staleness.is_still(self.config.identification.max_bias_rad_s) => 1,
            Sensor::Gyro | Sensor::Accelerometer => STALE_INERTIAL_PART,
            Sensor::Magnetometer => STALE_MAG_PART,
        };
        staleness.same > self.samples_per_second.checked_div(part).unwrap_or(0)
    }

    /// Returns the calibrated reading of a vector sensor. A stale reading, one with a dead axis, or exact
    /// zeros are not used.
    pub(super) fn vector(&self, sensor: Sensor, model: &VectorModel, sample: &Sample) -> Reading {
        let raw = sample.vector(sensor);
        let is_dead = || self.session.staleness.of(sensor).has_dead_axis();
        if sample.flags.contains(SampleFlags::missing(sensor)) || raw == [0.0; 3] {
            Reading::Missing
        } else if sample.flags.contains(SampleFlags::clipped(sensor)) || self.is_stale(sensor) || is_dead() {
            Reading::Unusable
        } else {
            Reading::Usable(model.calibrate(raw))
        }
    }
}
