//! Burst: the second with the worst vibration, and its transmission.

use crate::{
    survey::{BurstRecorder, SurveyInput},
    telemetry::BurstPart,
};
use heapless::Vec;

/// Samples of a burst: a second at 200 Hz.
pub const BURST_SAMPLES: usize = 200;

/// Recorder of the worst second since the start. All zero at first, so that a `static` of it costs no flash.
pub struct Burst {
    recorder: BurstRecorder<BURST_SAMPLES>,
    /// Next sample to be sent; `None` while no burst is being sent.
    next: Option<usize>,
}

impl Burst {
    /// Creates a recorder without a burst.
    #[must_use]
    pub const fn new() -> Self {
        Self { recorder: BurstRecorder::new(), next: None }
    }

    /// Takes a sample; drops it while a burst is being sent, which begins at rest alone. No burst reaches across the
    /// samples that were dropped.
    pub(super) fn push(&mut self, input: &SurveyInput) {
        if self.next.is_none() {
            self.recorder.push(input);
        } else {
            self.recorder.begin_anew();
        }
    }

    /// Sends the burst from its beginning.
    pub(super) const fn send(&mut self) {
        self.next = Some(0);
    }

    /// Takes the next part of a burst that is being sent.
    #[inline(never)]
    pub(super) fn take_part(&mut self) -> Option<BurstPart> {
        let first = self.next?;
        let Some(rms_m_s2) = self.recorder.worst_rms_m_s2().filter(|_| first < BURST_SAMPLES) else {
            self.next = None;
            return None;
        };
        let mut samples = Vec::new();
        for sample in self.recorder.worst().skip(first).take(BurstPart::SAMPLES) {
            // No more are taken than there is room for.
            let _ = samples.push(*sample);
        }
        self.next = Some(first + BurstPart::SAMPLES);
        Some(BurstPart { first: first as u16, of: BURST_SAMPLES as u16, rms_m_s2, samples })
    }
}

impl Default for Burst {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
