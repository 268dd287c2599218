//! Telemetry queue: frames that wait for a line, in lanes by importance. It decides what goes over a slow line first,
//! and what is dropped.

mod counters;
mod lane;
mod line;
mod stream_config;

pub use counters::LineCounters;
pub use stream_config::{AttitudeFormat, StreamConfig};

use super::{AttitudeFrame, Kind, MAX_FRAME, Payload, RawSample, frame::encode_parts};
use crate::{config::ConfigError, probe::Output, sample::Sample};
use counters::count;
use lane::{Lane, Refused};
use line::Line;

/// Size of the lane of answers, bytes: a report of health, of 211 bytes at most, and the answer to a command.
const ANSWERS: usize = 256;

/// Reason for which a message was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum PushError {
    /// There is no room now; try again when the line has taken something.
    Full,
    /// The message is longer than its lane: it never fits.
    TooLong,
}

impl core::fmt::Display for PushError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Full => "the queue of results is full",
            Self::TooLong => "longer than the queue of results",
        })
    }
}

impl core::error::Error for PushError {}

/// Frames that wait for a line that may be slower than the messages. It has four lanes, with sizes in bytes; the first
/// lane below that holds a frame sends it:
///
/// - `RESULTS`: surveys, identifications, diagnoses, magnets, boots. None is dropped for another: a result that finds
///   no room stays with the caller ([`PushError::Full`]), and is counted.
/// - answers, of 256 bytes: [`Kind::Health`] and [`Kind::Acknowledgement`]. The requests of a host so never take the
///   room of results.
/// - `ATTITUDE`: the stream. The oldest is dropped when there is no room or when it is older than
///   [`StreamConfig::max_age_us`], and is counted.
/// - `SAMPLES`: a recording. The oldest is dropped when there is no room, and is counted. It goes last, because a host
///   without the key may ask for one: it takes what nothing else wants.
///
/// A result so waits for at most the bytes of results before it and one frame that is on the line: `(RESULTS +
/// MAX_FRAME) / bytes_per_s`. An attitude is never older than `max_age_us` when it leaves. Over any time T no more
/// than `bytes_per_s (T + 10 ms) + MAX_FRAME` bytes leave. Times are those of one clock that does not go back; a probe
/// that begins again at zero calls [`TelemetryQueue::clock_went_back`].
///
/// Each lane has at least one byte: 0 does not compile, so a lane that is not used is 1. A diagnosis takes up to 1,000
/// bytes of `RESULTS`, an attitude some 30 of `ATTITUDE`.
pub struct TelemetryQueue<const RESULTS: usize, const SAMPLES: usize, const ATTITUDE: usize> {
    config: StreamConfig,
    line: Line,
    results: Lane<RESULTS>,
    answers: Lane<ANSWERS>,
    samples: Lane<SAMPLES>,
    attitude: Lane<ATTITUDE>,
    /// Outputs since the last one that was queued.
    skipped: u16,
    sequence: u16,
    counters: LineCounters,
}

impl<const RESULTS: usize, const SAMPLES: usize, const ATTITUDE: usize> TelemetryQueue<RESULTS, SAMPLES, ATTITUDE> {
    /// Returns an empty queue, all zero bytes. It sends nothing until it is configured.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            config: StreamConfig::UNSET,
            line: Line::new(),
            results: Lane::new(),
            answers: Lane::new(),
            samples: Lane::new(),
            attitude: Lane::new(),
            skipped: 0,
            sequence: 0,
            counters: LineCounters::NONE,
        }
    }

    /// Sets bandwidth and decimation; waiting frames stay.
    ///
    /// # Errors
    /// Names the field that cannot be used; the old settings then stay.
    pub fn configure(&mut self, config: &StreamConfig) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = *config;
        self.skipped = 0;
        Ok(())
    }

    /// Frees the line at once, because the clock has gone back. Attitudes that wait may then count as too old.
    pub const fn clock_went_back(&mut self) {
        self.line.clock_went_back();
    }

    /// Configuration in force.
    #[must_use]
    pub const fn config(&self) -> &StreamConfig {
        &self.config
    }

    /// Returns the counters.
    #[must_use]
    pub const fn counters(&self) -> LineCounters {
        self.counters
    }

    /// Returns the free bytes of the lane of results; one result takes up to its payload and 7 more.
    #[must_use]
    pub fn results_room(&self) -> usize {
        self.results.room()
    }

    /// Returns true if a result or an answer waits.
    #[must_use]
    pub fn has_results_or_answers(&self) -> bool {
        !(self.results.is_empty() && self.answers.is_empty())
    }

    /// Returns true if an answer waits.
    #[must_use]
    pub fn has_answers(&self) -> bool {
        !self.answers.is_empty()
    }

    /// Returns true if nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.results.is_empty() && self.answers.is_empty() && self.samples.is_empty() && self.attitude.is_empty()
    }

    /// Takes a result or an answer.
    ///
    /// # Errors
    /// There is no room, or never will be; the caller keeps the message to try again, or gives it up. It is counted as
    /// refused.
    pub fn push_result<P: Payload>(&mut self, now_us: u64, result: &P) -> Result<(), PushError> {
        let written = match P::KIND {
            Kind::Health | Kind::Acknowledgement => self.answers.write(now_us, result),
            _ => self.results.write(now_us, result),
        };
        let pushed = match written {
            Ok(()) => return Ok(()),
            Err(Refused::NoRoom) => PushError::Full,
            Err(Refused::TooLong) => PushError::TooLong,
        };
        count(&mut self.counters.results_refused);
        Err(pushed)
    }

    /// Queues every [`StreamConfig::attitude_every`]th output for the stream.
    pub fn push_attitude(&mut self, now_us: u64, output: &Output) {
        self.skipped = self.skipped.saturating_add(1);
        if self.config.attitude_every == 0 || self.skipped < self.config.attitude_every {
            return;
        }
        self.skipped = 0;
        let dropped = &mut self.counters.attitude_dropped;
        match self.config.attitude_format {
            AttitudeFormat::Compact => self.attitude.write_over(now_us, &AttitudeFrame::of(output), dropped),
            AttitudeFormat::Exact => self.attitude.write_over(now_us, output, dropped),
        }
    }

    /// Takes a sample of a recording; `number` counts all samples since the start.
    pub fn push_sample(&mut self, now_us: u64, number: u32, sample: &Sample) {
        let dropped = &mut self.counters.samples_dropped;
        self.samples.write_over(now_us, &RawSample::of(number, sample), dropped);
    }

    /// Returns the next frame if the line is free for it; call again until there is none.
    pub fn pop<'a>(&mut self, now_us: u64, buffer: &'a mut [u8; MAX_FRAME]) -> Option<&'a [u8]> {
        if !self.line.is_free(now_us) {
            return None;
        }
        while self.attitude.oldest_is_over(now_us, self.config.max_age_us) {
            self.attitude.forget_oldest();
            count(&mut self.counters.attitude_dropped);
        }
        let sequence = self.sequence;
        let frame = if !self.results.is_empty() {
            self.results.take(sequence, buffer)
        } else if !self.answers.is_empty() {
            self.answers.take(sequence, buffer)
        } else if !self.attitude.is_empty() {
            self.attitude.take(sequence, buffer)
        } else {
            self.samples.take(sequence, buffer)
        }?;
        self.sequence = sequence.wrapping_add(1);
        self.line.send(now_us, frame.len(), self.config.bytes_per_s);
        count(&mut self.counters.frames);
        Some(frame)
    }
}

impl<const RESULTS: usize, const SAMPLES: usize, const ATTITUDE: usize> Default
    for TelemetryQueue<RESULTS, SAMPLES, ATTITUDE>
{
    fn default() -> Self {
        Self::new()
    }
}
