//! Playback of a recording through the models and their adapters: one sample out for each one in, at its time.

use super::{ModelledPair, ModelledParts, Periods};
use crate::{
    sample::{Sample, SampleFlags},
    sensors::{Counters, Trigger},
};
use heapless::Vec;

/// Playback of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Recording {
    /// Time from conversion to conversion of gyro and accelerometer, microseconds: each sample is one conversion.
    pub inertial_us: u32,
    /// Time from conversion to conversion of the magnetometer, microseconds: each sample with a field is one
    /// conversion.
    pub magnetic_us: u32,
}

/// Counters of the playback.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct PlayedCounts {
    /// Samples of the recording.
    pub samples: u32,
    /// Samples of the recording that the adapters did not put out.
    pub lost: u32,
    /// Largest difference between the adapters' stamps and the recording's times, microseconds.
    pub stamp_error_us: u64,
}

/// Time by which the parts are switched on before the recording, microseconds, so that they have settled when it
/// begins; the parts' time is the recording's plus this.
pub const WARM_UP_US: u64 = 1_000_000;
/// Samples, before the recording, in which the parts settle.
const SETTLING: u32 = 48;
/// Least noise of a part at rest with which its adapter does not take it for frozen: some codes either way, of the
/// ISM330DHCX's gyro and accelerometer, rad/s and m/s^2, and of the RM3100, microtesla.
pub const DITHER: [f32; 3] = [0.005, 0.02, 0.1];

/// Room for the samples of one call: a conversion gives one; another may come with it after a pause.
const SAMPLES: usize = 2;

/// Player of a recording.
///
/// A part with a FIFO always puts out gyro and accelerometer together. Where the recording has one of them flagged
/// missing, its values are still played (a truth between those before and after), and the sample that comes out is
/// flagged, too.
pub struct RecordingPlayer<'a, const WORDS: usize> {
    pair: ModelledPair<'a, WORDS>,
    recording: Recording,
    truth_us: u64,
    /// Missing flags of gyro and accelerometer in the truth being played.
    lacks: SampleFlags,
    counts: PlayedCounts,
}

impl<'a, const WORDS: usize> RecordingPlayer<'a, WORDS> {
    /// Creates a player over parts that convert with every sample.
    #[must_use]
    pub fn new(parts: &'a ModelledParts<WORDS>, recording: Recording) -> Self {
        let periods = Periods { inertial_us: Some(recording.inertial_us), magnetic_us: Some(recording.magnetic_us) };
        let pair = ModelledPair::new(parts, periods, 1, Trigger::Interrupt);
        Self { pair, recording, truth_us: 0, lacks: SampleFlags::empty(), counts: PlayedCounts::default() }
    }

    /// Switches the parts on before the first truth, about which they settle.
    pub fn settle(&mut self, first: &Sample) {
        let period_us = u64::from(self.recording.inertial_us);
        for k in 0..SETTLING {
            let t_us = (first.t_us + WARM_UP_US).saturating_sub(u64::from(SETTLING - k) * period_us);
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let dithered = |[x, y, z]: [f32; 3], by: f32| [x + side * by, y + side * by, z + side * by];
            let [gyro, accel, mag] = DITHER;
            self.pair.pass_to(&Sample {
                t_us,
                gyro_rad_s: dithered(first.gyro_rad_s, gyro),
                accel_m_s2: dithered(first.accel_m_s2, accel),
                mag_ut: dithered(first.mag_ut, mag),
                flags: first.flags - INERTIAL_MISSING,
                ..*first
            });
            self.pair.service(&mut Vec::<Sample, SAMPLES>::new());
        }
    }

    /// Advances the parts to the next truth, as hardware does by itself; no adapter runs.
    pub fn pass_to(&mut self, truth: &Sample) {
        self.truth_us = truth.t_us + WARM_UP_US;
        self.lacks = truth.flags & INERTIAL_MISSING;
        self.pair.pass_to(&Sample { t_us: self.truth_us, flags: truth.flags - INERTIAL_MISSING, ..*truth });
    }

    /// Returns the sample that the adapters make, at the time at which it was recorded; all sensors are flagged
    /// missing if none came.
    pub fn service(&mut self) -> Sample {
        let mut out = Vec::<Sample, SAMPLES>::new();
        self.pair.service(&mut out);
        self.counts.samples = self.counts.samples.saturating_add(1);
        let t_us = self.truth_us.saturating_sub(WARM_UP_US);
        let half_us = u64::from(self.recording.inertial_us / 2);
        let Some(came) = out.iter().rfind(|sample| sample.t_us.abs_diff(self.truth_us) <= half_us) else {
            self.counts.lost = self.counts.lost.saturating_add(1);
            let flags = INERTIAL_MISSING | SampleFlags::MAG_MISSING | SampleFlags::TEMPERATURE_MISSING;
            return Sample { t_us, flags, ..Sample::default() };
        };
        self.counts.stamp_error_us = self.counts.stamp_error_us.max(came.t_us.abs_diff(self.truth_us));
        Sample { t_us, flags: came.flags | self.lacks, ..*came }
    }

    /// Returns the counters of the playback.
    #[must_use]
    pub const fn counts(&self) -> PlayedCounts {
        self.counts
    }

    /// Returns the adapters' counters of faults: gyro and accelerometer, magnetometer.
    #[must_use]
    pub fn counters(&self) -> [Counters; 2] {
        self.pair.counters()
    }
}

/// Missing flags of gyro and accelerometer, which a part with a FIFO puts out together.
const INERTIAL_MISSING: SampleFlags = SampleFlags::GYRO_MISSING.union(SampleFlags::ACCEL_MISSING);
