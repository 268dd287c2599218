use heapless::Deque;

use crate::{
    sample::{Sample, SampleFlags},
    sensors::{InertialReading, MagneticReading},
};

/// Magnetic readings that wait for the inertial reading of their time.
const WAITING: usize = 8;

/// Makes samples of the readings of an inertial and a magnetic source.
///
/// Each inertial reading makes one sample, at once. A magnetic reading goes to the next inertial one, at its time or after it; the samples between
/// have [`SampleFlags::MAG_MISSING`]. So the field of a sample is half a sample period older in the mean, which belongs into the
/// configured latency of the magnetometer ([`mean_delay_s`](Self::mean_delay_s)). One that is more than one and a half periods old comes too
/// late. Read the magnetic source first, then the inertial one.
#[derive(Clone, Debug)]
pub struct Combiner {
    period_us: u64,
    waiting: Deque<MagneticReading, WAITING>,
    last_t_us: Option<u64>,
    lost_magnetic: u32,
    lost_inertial: u32,
}

impl Combiner {
    /// For an inertial source with this output period, microseconds.
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

    /// Takes an inertial reading and gives its sample; none if its time is not after the last one's.
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
            // A fault of the magnetometer's is not the inertial sensors'.
            if !magnetic.flags.intersects(SampleFlags::MAG_MISSING | SampleFlags::FAULT) {
                sample.mag_ut = magnetic.mag_ut;
                sample.flags.remove(SampleFlags::MAG_MISSING);
                sample.flags |= magnetic.flags & SampleFlags::MAG_CLIPPED;
            }
        }
        Some(sample)
    }

    /// The newest waiting reading of this time or before; older ones are lost, and itself when it is too old.
    fn newest(&mut self, t_us: u64) -> Option<MagneticReading> {
        let mut newest: Option<MagneticReading> = None;
        while self.waiting.front().is_some_and(|magnetic| magnetic.t_us <= t_us) {
            let lost = newest.is_some();
            newest = self.waiting.pop_front();
            self.lost_magnetic = self.lost_magnetic.saturating_add(lost.into());
        }
        let in_time = newest.filter(|magnetic| t_us - magnetic.t_us <= self.period_us * 3 / 2);
        if newest.is_some() && in_time.is_none() {
            self.lost_magnetic = self.lost_magnetic.saturating_add(1);
        }
        in_time
    }

    /// How much older than its sample a magnetic reading is in the mean, seconds.
    #[must_use]
    pub fn mean_delay_s(&self) -> f32 {
        0.5e-6 * self.period_us as f32
    }

    /// Magnetic readings that no sample has: they came too late, or two in one sample period, or the inertial source stood still.
    #[must_use]
    pub fn lost_magnetic(&self) -> u32 {
        self.lost_magnetic
    }

    /// Inertial readings that made no sample, for their time was not after the last one's.
    #[must_use]
    pub fn lost_inertial(&self) -> u32 {
        self.lost_inertial
    }
}
