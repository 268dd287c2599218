//! A recording through the models and the adapters on them: one sample out for each one in, at its time.

use super::{ModelledPair, ModelledParts, Periods};
use crate::{
    sample::{Sample, SampleFlags},
    sensors::{Counters, Trigger},
};
use heapless::Vec;

/// How a recording is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Recording {
    /// Time from conversion to conversion of gyro and accelerometer, microseconds: each sample is one.
    pub inertial_us: u32,
    /// The same of the magnetometer: each sample with a field is one.
    pub magnetic_us: u32,
    /// Truths that are played before the recording, so that the parts have settled when it begins.
    pub settling: u32,
    /// How much later than it was recorded a truth is played, microseconds.
    pub later_us: u64,
}

/// What came of it so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct PlayedCounts {
    /// Samples of the recording.
    pub samples: u32,
    /// Those that did not come through.
    pub lost: u32,
    /// Largest difference between the adapters' stamps and the recording's times, microseconds.
    pub stamp_error_us: u64,
}

/// Plays a recording.
pub struct RecordingPlayer<'a, const WORDS: usize> {
    pair: ModelledPair<'a, WORDS>,
    recording: Recording,
    truth_us: u64,
    counts: PlayedCounts,
}

impl<'a, const WORDS: usize> RecordingPlayer<'a, WORDS> {
    /// Over parts that convert with every sample.
    #[must_use]
    pub fn new(parts: &'a ModelledParts<WORDS>, recording: Recording) -> Self {
        let periods = Periods { inertial_us: Some(recording.inertial_us), magnetic_us: Some(recording.magnetic_us) };
        let pair = ModelledPair::new(parts, periods, 1, Trigger::Interrupt);
        Self { pair, recording, truth_us: 0, counts: PlayedCounts::default() }
    }

    /// Time passes in the parts to the next truth: what hardware does.
    pub fn pass_to(&mut self, truth: &Sample) {
        self.truth_us = truth.t_us;
        self.pair.pass_to(truth);
    }

    /// What the adapters make of that: the sample at the time it was recorded at, with everything flagged missing where none came.
    /// `None` while the parts settle.
    pub fn service(&mut self) -> Option<Sample> {
        let mut out = Vec::<Sample, 16>::new();
        self.pair.service(&mut out);
        if self.recording.settling > 0 {
            self.recording.settling -= 1;
            return None;
        }
        self.counts.samples = self.counts.samples.saturating_add(1);
        let t_us = self.truth_us.saturating_sub(self.recording.later_us);
        let off_us = |sample: &Sample| sample.t_us.abs_diff(self.truth_us);
        let came = out.iter().rfind(|sample| off_us(sample) <= u64::from(self.recording.inertial_us / 2));
        let Some(came) = came else {
            self.counts.lost = self.counts.lost.saturating_add(1);
            let flags = SampleFlags::GYRO_MISSING
                | SampleFlags::ACCEL_MISSING
                | SampleFlags::MAG_MISSING
                | SampleFlags::TEMPERATURE_MISSING;
            return Some(Sample { t_us, flags, ..Sample::default() });
        };
        self.counts.stamp_error_us = self.counts.stamp_error_us.max(off_us(came));
        Some(Sample { t_us, ..*came })
    }

    /// What came of it so far.
    #[must_use]
    pub const fn counts(&self) -> PlayedCounts {
        self.counts
    }

    /// What has gone wrong so far: gyro and accelerometer, magnetometer.
    #[must_use]
    pub fn counters(&self) -> [Counters; 2] {
        self.pair.counters()
    }
}
