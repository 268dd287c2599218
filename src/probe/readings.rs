//! Which readings of a sample are to be believed: clipped, stale and missing ones are not.

use super::{Probe, output::count, staleness::Staleness};
use crate::{
    attitude::AttitudeFlags,
    sample::{Reading, Sample, SampleFlags},
};

/// Share of full scale from which a reading counts as clipped: data sheets name full scales in round figures, and a saturated 16-bit
/// word can stand for as little as 99.9 % of them (2,000 deg/s at 16.4 LSB per deg/s saturate at 1,998.0: MPU-9250 PS section 3.1).
pub const CLIPPED_SHARE: f32 = 0.998;

/// Part of a second after which a gyro or an accelerometer that reads the same on all axes is not used: a live one has noise, and
/// what is read until a dead one is found out is wrong and believed. A gyro that reads no rotation, and read none before, gets the
/// whole second: the noise of a quiet one is below its resolution (ICM-42688-P: 20 mdps in 50 Hz against 61 mdps).
pub(super) const STALE_INERTIAL_PART: u32 = 20;

/// The same for a magnetometer, of which some read only 8 to 10 times a second.
const STALE_MAG_PART: u32 = 4;

impl Probe {
    pub(super) fn mark_clipped(&mut self, sample: &mut Sample) {
        let at_full_scale = |reading: &[f32; 3], full_scale: Option<f32>| {
            full_scale.is_some_and(|limit| reading.iter().any(|x| libm::fabsf(*x) >= CLIPPED_SHARE * limit))
        };
        let full_scale = &self.config.full_scale;
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        let rails = self.gyro_rails.iter_mut().zip(sample.gyro_rad_s);
        let railed = !missing && rails.fold(false, |railed, (rail, x)| rail.observe(x) || railed);
        if railed || at_full_scale(&sample.gyro_rad_s, full_scale.gyro_rad_s) {
            sample.flags.insert(SampleFlags::GYRO_CLIPPED);
        }
        if at_full_scale(&sample.accel_m_s2, full_scale.accel_m_s2) {
            sample.flags.insert(SampleFlags::ACCEL_CLIPPED);
        }
        if at_full_scale(&sample.mag_ut, full_scale.mag_ut) {
            sample.flags.insert(SampleFlags::MAG_CLIPPED);
        }
    }

    /// Counts what is wrong with a sample and turns it into the attitude's flags.
    pub(super) fn flags(&mut self, sample: &Sample) -> AttitudeFlags {
        let clipped = SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        let mut flags = AttitudeFlags::empty();
        if sample.flags.intersects(clipped) {
            count(&mut self.counters.clipped);
        }
        if sample.flags.contains(SampleFlags::GYRO_MISSING) {
            count(&mut self.counters.gyro_missing);
            flags.insert(AttitudeFlags::GYRO_HELD);
        }
        flags.set(AttitudeFlags::GYRO_CLIPPED, sample.flags.contains(SampleFlags::GYRO_CLIPPED));
        flags.set(AttitudeFlags::FAULT, sample.flags.contains(SampleFlags::FAULT));
        let readings = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
        let missing = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        let limit = self.config.identification.max_bias_rad_s;
        let turning = sample.gyro_rad_s.iter().any(|rate| libm::fabsf(*rate) >= limit);
        for ((stale, reading), missing) in self.staleness.iter_mut().zip(readings).zip(missing) {
            if !sample.flags.contains(missing) {
                stale.observe(reading, turning);
                if stale.same > self.samples_per_second {
                    flags.insert(AttitudeFlags::FROZEN_SENSOR);
                }
            }
        }
        flags
    }

    /// Whether a sensor (0 gyro, 1 accelerometer, 2 magnetometer) has read the same for one `part`-th of a second.
    pub(super) fn is_stale(&self, sensor: usize, part: u32) -> bool {
        let limit = self.config.identification.max_bias_rad_s;
        self.staleness.get(sensor).is_some_and(|stale| {
            let part = if sensor == 0 && stale.is_still(limit) { 1 } else { part };
            stale.same > self.samples_per_second.checked_div(part).unwrap_or(0)
        })
    }

    fn has_dead_axis(&self, sensor: usize) -> bool {
        self.staleness.get(sensor).is_some_and(Staleness::has_dead_axis)
    }

    /// The calibrated reading of the accelerometer (1) or the magnetometer (2). A stale one, one with a dead axis, or exact zeros, are none.
    pub(super) fn vector(&self, sensor: usize, sample: &Sample) -> Reading {
        let (raw, model, missing, clipped, part) = if sensor == 1 {
            let flags = (SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED);
            (sample.accel_m_s2, &self.config.accel, flags.0, flags.1, STALE_INERTIAL_PART)
        } else {
            let flags = (SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED);
            (sample.mag_ut, &self.config.mag, flags.0, flags.1, STALE_MAG_PART)
        };
        if sample.flags.contains(missing) || raw == [0.0; 3] {
            Reading::Missing
        } else if sample.flags.contains(clipped) || self.is_stale(sensor, part) || self.has_dead_axis(sensor) {
            Reading::Clipped
        } else {
            Reading::Good(model.calibrate(raw))
        }
    }
}
