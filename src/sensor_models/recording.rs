//! A recording through the models and the adapters on them: one sample out for each one in, at its time.

use super::{ModelledPair, ModelledParts, Periods};
use crate::{
    sample::{Sample, SampleFlags},
    sensors::{Counters, Trigger},
};
use heapless::{Deque, Vec};

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

/// Truths after which a sample is not waited for any more: where the recording lacks a sensor, half a frame waits in the part's FIFO.
const LAG: usize = 3;

/// Plays a recording.
pub struct RecordingPlayer<'a, const WORDS: usize> {
    pair: ModelledPair<'a, WORDS>,
    recording: Recording,
    truth_us: u64,
    /// Truths whose samples are waited for, and what came of them.
    waiting: Deque<(u64, Option<Sample>), { LAG + 1 }>,
    counts: PlayedCounts,
}

impl<'a, const WORDS: usize> RecordingPlayer<'a, WORDS> {
    /// Over parts that convert with every sample.
    #[must_use]
    pub fn new(parts: &'a ModelledParts<WORDS>, recording: Recording) -> Self {
        let periods = Periods { inertial_us: Some(recording.inertial_us), magnetic_us: Some(recording.magnetic_us) };
        let pair = ModelledPair::new(parts, periods, 1, Trigger::Interrupt);
        Self { pair, recording, truth_us: 0, waiting: Deque::new(), counts: PlayedCounts::default() }
    }

    /// Time passes in the parts to the next truth: what hardware does.
    pub fn pass_to(&mut self, truth: &Sample) {
        self.truth_us = truth.t_us;
        self.pair.pass_to(truth);
    }

    /// What the adapters make of that: the sample of some truths ago, at the time it was recorded at, with everything flagged missing where none
    /// came. `None` while the parts settle, and at the beginning.
    pub fn service(&mut self) -> Option<Sample> {
        let mut out = Vec::<Sample, 16>::new();
        self.pair.service(&mut out);
        let _ = self.waiting.push_back((self.truth_us, None));
        let half_us = u64::from(self.recording.inertial_us / 2);
        for (truth_us, came) in self.waiting.iter_mut().filter(|(_, came)| came.is_none()) {
            *came = out.iter().rfind(|sample| sample.t_us.abs_diff(*truth_us) <= half_us).copied();
        }
        if self.waiting.len() > LAG { self.oldest() } else { None }
    }

    /// When the recording is over: the samples that are still to come, one at a call.
    pub fn finish(&mut self) -> Option<Sample> {
        while !self.waiting.is_empty() {
            if let Some(sample) = self.oldest() {
                return Some(sample);
            }
        }
        None
    }

    fn oldest(&mut self) -> Option<Sample> {
        let (truth_us, came) = self.waiting.pop_front()?;
        if self.recording.settling > 0 {
            self.recording.settling -= 1;
            return None;
        }
        self.counts.samples = self.counts.samples.saturating_add(1);
        let t_us = truth_us.saturating_sub(self.recording.later_us);
        let Some(came) = came else {
            self.counts.lost = self.counts.lost.saturating_add(1);
            let flags = SampleFlags::GYRO_MISSING
                | SampleFlags::ACCEL_MISSING
                | SampleFlags::MAG_MISSING
                | SampleFlags::TEMPERATURE_MISSING;
            return Some(Sample { t_us, flags, ..Sample::default() });
        };
        self.counts.stamp_error_us = self.counts.stamp_error_us.max(came.t_us.abs_diff(truth_us));
        Some(Sample { t_us, ..came })
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
