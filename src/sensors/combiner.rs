//! Combiner: readings of a pair of sources become samples.

use heapless::Deque;

use crate::{
    config::{FullScale, Latency},
    sample::{Sample, SampleFlags},
    sensors::{InertialData, InertialReading, MagneticData, MagneticReading},
};

/// Largest number of magnetic readings that wait for an inertial reading.
const WAITING: usize = 8;
/// Periods over this: error of stamps, as much as a [`SampleClock`](super::sample_clock::SampleClock) allows for the
/// bus.
const STAMP_ERROR: u64 = 16;

/// Combiner of an inertial and a magnetic source's readings into samples.
///
/// Each inertial reading makes one sample, at once. A magnetic reading goes into the sample of the first inertial
/// reading at its time or after it, or less than a sixteenth of a period before it: stamps err, and of two parts that
/// convert together a microsecond is not to make the field a whole period old. The samples between have
/// [`SampleFlags::MAG_MISSING`]. So a sample's field is half a sample period older in the mean; this delay is part of
/// the magnetometer's configured latency ([`Latency::of_parts`]). A magnetic reading more than one and a half periods
/// old is lost. Read the magnetic source first, then the inertial one.
#[derive(Clone, Debug)]
pub struct Combiner {
    period_us: u64,
    waiting: Deque<MagneticReading, WAITING>,
    last_t_us: Option<u64>,
    lost_magnetic: u32,
    lost_inertial: u32,
}

impl Combiner {
    /// Creates a combiner for an inertial source with this output period, microseconds.
    #[must_use]
    pub const fn new(sample_period_us: u32) -> Self {
        Self {
            period_us: sample_period_us as u64,
            waiting: Deque::new(),
            last_t_us: None,
            lost_magnetic: 0,
            lost_inertial: 0,
        }
    }

    /// Takes a magnetic reading.
    pub fn magnetic(&mut self, reading: MagneticReading) {
        if self.waiting.is_full() {
            self.waiting.pop_front();
            self.lost_magnetic = self.lost_magnetic.saturating_add(1);
        }
        let _ = self.waiting.push_back(reading);
    }

    /// Takes an inertial reading. Returns its sample, or `None` if its time is not after the last one's.
    pub fn inertial(&mut self, reading: &InertialReading) -> Option<Sample> {
        if self.last_t_us.is_some_and(|last| reading.t_us <= last) {
            self.lost_inertial = self.lost_inertial.saturating_add(1);
            return None;
        }
        self.last_t_us = Some(reading.t_us);
        let mut sample = Sample {
            t_us: reading.t_us,
            gyro_rad_s: reading.gyro_rad_s,
            accel_m_s2: reading.accel_m_s2,
            mag_ut: [0.0; 3],
            temperature_c: reading.temperature_c,
            flags: reading.flags | SampleFlags::MAG_MISSING,
        };
        if let Some(magnetic) = self.newest(reading.t_us) {
            // A fault of the magnetometer leaves the inertial readings usable.
            if !magnetic.flags.intersects(SampleFlags::MAG_MISSING | SampleFlags::FAULT) {
                sample.mag_ut = magnetic.mag_ut;
                sample.flags.remove(SampleFlags::MAG_MISSING);
                sample.flags |= magnetic.flags & SampleFlags::MAG_CLIPPED;
            }
        }
        Some(sample)
    }

    /// Takes the newest waiting magnetic reading of time `t_us`, but for the stamps' error, or before. Older ones are
    /// lost, and so is the newest if it is more than 1.5 periods old.
    fn newest(&mut self, t_us: u64) -> Option<MagneticReading> {
        let mut newest: Option<MagneticReading> = None;
        let until_us = t_us + self.period_us / STAMP_ERROR;
        while self.waiting.front().is_some_and(|magnetic| magnetic.t_us <= until_us) {
            let lost = newest.is_some();
            newest = self.waiting.pop_front();
            self.lost_magnetic = self.lost_magnetic.saturating_add(lost.into());
        }
        let in_time = newest.filter(|magnetic| t_us.saturating_sub(magnetic.t_us) <= self.period_us * 3 / 2);
        if newest.is_some() && in_time.is_none() {
            self.lost_magnetic = self.lost_magnetic.saturating_add(1);
        }
        in_time
    }

    /// Mean time from a magnetic reading to its sample, seconds.
    #[must_use]
    pub fn mean_delay_s(&self) -> f32 {
        mean_wait_s(self.period_us as u32)
    }

    /// Number of magnetic readings in no sample: they came too late, or two in one sample period, or the
    /// inertial source stood still.
    #[must_use]
    pub fn lost_magnetic(&self) -> u32 {
        self.lost_magnetic
    }

    /// Number of inertial readings without a sample: their time was not after the last one's.
    #[must_use]
    pub fn lost_inertial(&self) -> u32 {
        self.lost_inertial
    }
}

/// Mean wait of a magnetic reading for the next inertial one, seconds: half a period, since the two parts'
/// oscillators are independent.
fn mean_wait_s(inertial_period_us: u32) -> f32 {
    0.5e-6 * inertial_period_us as f32
}

impl Latency {
    /// Delays of the samples that a [`Combiner`] makes of two parts' readings: the parts' own, from their
    /// data sheets, and the mean wait of a magnetic reading for its sample.
    #[must_use]
    pub fn of_parts(inertial: &InertialData, magnetic: &MagneticData) -> Self {
        let ([gyro, accel], [mag]) = (&inertial.sensors, &magnetic.sensors);
        Self {
            gyro_s: Some(gyro.mean_latency_s()),
            accel_s: Some(accel.mean_latency_s()),
            mag_s: Some(mag.mean_latency_s() + mean_wait_s(inertial.period_us)),
        }
    }
}

impl FullScale {
    /// Full scales of two parts, from their data sheets.
    #[must_use]
    pub const fn of_parts(inertial: &InertialData, magnetic: &MagneticData) -> Self {
        let ([gyro, accel], [mag]) = (&inertial.sensors, &magnetic.sensors);
        Self { gyro_rad_s: Some(gyro.full_scale), accel_m_s2: Some(accel.full_scale), mag_ut: Some(mag.full_scale) }
    }
}

#[cfg(all(test, feature = "ism330dhcx", feature = "rm3100"))]
mod tests;
