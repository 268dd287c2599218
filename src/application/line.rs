//! Line to the host: messages that go over it, and those that wait.

use super::{Board, Burst};
use crate::{
    Sample,
    config::ConfigError,
    diagnosis::DiagnosisReport,
    identification::WindowReport,
    magnet::HardIronInterval,
    probe::Output,
    survey::{SurveyNews, Surveyor},
    telemetry::{
        Acknowledgement, Boot, Health, Identification, LineCounters, MAX_FRAME, MAX_PAYLOAD, Payload, ProgramReport,
        StreamConfig, TelemetryQueue,
    },
};
use heapless::Vec;

/// Lanes of 1280 bytes for results (a diagnosis takes up to 1,000), 512 for a recording, 256 for attitudes.
type Queue = TelemetryQueue<1280, 512, 256>;

/// Room for a result, bytes: more than a window's report, a survey or a window of dynamics takes.
const RESULT: usize = 600;

/// Room for a boot, bytes: more than it takes with a stored model of as many effects as there can be.
const BOOT: usize = 1_200;

/// Sender of messages to the host. All zero at first, so that a `static` of it costs no flash.
pub struct Line {
    queue: Queue,
    /// The frame on its way into the transmitter.
    frame: [u8; MAX_FRAME],
    length: usize,
    sent: usize,
    /// The report of a window that waits for room.
    window: Vec<WindowReport, 1>,
    surveys: SurveyNews,
    /// True if the boot is to be sent. However often it was asked for, it is sent once.
    wants_boot: bool,
    recording: bool,
    results_lost: u32,
}

impl Line {
    /// Creates a line on which nothing waits.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            queue: Queue::new(),
            frame: [0; MAX_FRAME],
            length: 0,
            sent: 0,
            window: Vec::new(),
            surveys: SurveyNews::empty(),
            wants_boot: false,
            recording: false,
            results_lost: 0,
        }
    }

    /// # Errors
    /// The field that cannot be used.
    pub(super) fn configure(&mut self, stream: &StreamConfig) -> Result<(), ConfigError> {
        self.queue.configure(stream)
    }

    /// Notes that the clock has gone back.
    pub(super) const fn clock_went_back(&mut self) {
        self.queue.clock_went_back();
    }

    /// Sends raw samples, or stops.
    pub(super) const fn record(&mut self, recording: bool) {
        self.recording = recording;
    }

    /// Counts of frames sent and lost.
    #[must_use]
    pub const fn counters(&self) -> LineCounters {
        self.queue.counters()
    }

    /// Results that were pushed out by newer ones before they found room.
    #[must_use]
    pub const fn results_lost(&self) -> u32 {
        self.results_lost
    }

    /// Asks for the boot to be sent.
    pub(super) const fn want_boot(&mut self) {
        self.wants_boot = true;
    }

    /// Returns true if the boot is asked for and has room that no other result waits for.
    pub(super) fn takes_boot(&self) -> bool {
        self.wants_boot && self.window.is_empty() && self.surveys.is_empty() && self.queue.results_room() >= BOOT
    }

    /// Sends the boot; call it when [`Self::takes_boot`] returns true.
    #[inline(never)]
    pub(super) fn boot(&mut self, now_us: u64, boot: &Boot) {
        self.wants_boot = false;
        let sent = self.queue.push_result(now_us, boot);
        self.lost_unless(sent.is_ok());
    }

    /// Sends a sample's attitude, and the raw sample while recording.
    pub(super) fn sample(&mut self, now_us: u64, number: u32, sample: &Sample, output: Option<&Output>) {
        if self.recording {
            self.queue.push_sample(now_us, number, sample);
        }
        if let Some(output) = output {
            self.queue.push_attitude(now_us, output);
        }
    }

    /// Notes new surveys, to be sent; the surveyor keeps them.
    pub(super) fn surveys(&mut self, news: SurveyNews) {
        self.lost_unless(!self.surveys.intersects(news));
        self.surveys |= news;
    }

    /// Sends the last stationary survey again.
    pub(super) fn survey_again(&mut self) {
        self.surveys |= SurveyNews::STATIONARY;
    }

    /// Sends the vibration dose now.
    pub(super) fn dose(&mut self) {
        self.surveys |= SurveyNews::DOSE;
    }

    /// Sends the result of a window.
    pub(super) fn window(&mut self, report: WindowReport) {
        let before = self.window.pop();
        self.lost_unless(before.is_none());
        // Just emptied, so there is room.
        let _ = self.window.push(report);
    }

    /// Returns true if there is room for any diagnosis or magnet, which the pipeline keeps until then.
    pub(super) fn takes_finding(&self) -> bool {
        self.queue.results_room() > MAX_PAYLOAD
    }

    /// Sends the result of a diagnosis; call it when [`Self::takes_finding`] returns true.
    #[inline(never)]
    pub(super) fn diagnosis(&mut self, now_us: u64, report: &DiagnosisReport) {
        let taken = self.queue.push_result(now_us, report);
        self.lost_unless(taken.is_ok());
    }

    /// Sends when a magnet came, or left; call it when [`Self::takes_finding`] returns true.
    #[inline(never)]
    pub(super) fn magnet(&mut self, now_us: u64, interval: &HardIronInterval) {
        let taken = self.queue.push_result(now_us, interval);
        self.lost_unless(taken.is_ok());
    }

    /// Sends the answer to a command. An answer that finds no room is dropped: the command's sender asks again.
    #[inline(never)]
    pub(super) fn acknowledge(&mut self, now_us: u64, answer: &Acknowledgement) {
        let _ = self.queue.push_result(now_us, answer);
    }

    /// Returns true if no answer waits. Else a line that stands still would fill with reports of health, and the answer
    /// to a command would find no room.
    pub(super) fn takes_health(&self) -> bool {
        !self.queue.has_answers()
    }

    /// Sends the health; call it when [`Self::takes_health`] returns true.
    #[inline(never)]
    pub(super) fn health(&mut self, now_us: u64, health: &Health) {
        let _ = self.queue.push_result(now_us, health);
    }

    /// Sends which program runs. A report without room is no loss: the next one tells the same.
    #[inline(never)]
    pub(super) fn program(&mut self, now_us: u64, program: &ProgramReport) {
        let _ = self.queue.push_result(now_us, program);
    }

    /// Gives the board as many bytes as it takes, of one frame at most, so that the call's time is bounded.
    pub(super) fn transmit<B: Board>(&mut self, board: &mut B) {
        let now_us = board.now_us();
        if self.sent == self.length {
            self.sent = 0;
            self.length = self.queue.pop(now_us, &mut self.frame).map_or(0, <[u8]>::len);
        }
        let rest = self.frame.get(self.sent..self.length).unwrap_or_default();
        if !rest.is_empty() {
            self.sent += board.send(rest);
        }
    }

    /// Moves waiting results into the queue, where there is room.
    #[inline(never)]
    pub(super) fn queue_results(&mut self, now_us: u64, surveyor: &Surveyor, burst: &mut Burst) {
        // Once there is room for the longest of these results, none is refused.
        if self.queue.results_room() >= RESULT
            && let Some(report) = self.window.pop()
        {
            // The temperature is reported with the stored model.
            let _ = self.queue.push_result(now_us, &Identification { report, temperature_c: None });
        }
        self.queue_news(now_us, SurveyNews::STATIONARY, surveyor.stationary());
        self.queue_news(now_us, SurveyNews::ROTATING, surveyor.rotating());
        self.queue_news(now_us, SurveyNews::DYNAMICS, surveyor.dynamics());
        self.queue_news(now_us, SurveyNews::TOOLFACE, surveyor.sliding_toolface());
        self.queue_news(now_us, SurveyNews::DOSE, Some(surveyor.dose()));
        // One piece of a burst at a time, and only when nothing else waits: a result or an answer waits for one piece
        // at most.
        if !self.queue.has_results_or_answers()
            && let Some(part) = burst.take_part()
        {
            let _ = self.queue.push_result(now_us, &part);
        }
    }

    /// Moves what waits of the surveyor's news into the queue, where there is room; a surveyor that has begun anew has
    /// it no more.
    fn queue_news<P: Payload>(&mut self, now_us: u64, news: SurveyNews, latest: Option<&P>) {
        if self.surveys.contains(news) && self.queue.results_room() >= RESULT {
            self.surveys.remove(news);
            let sent = latest.map(|latest| self.queue.push_result(now_us, latest));
            self.lost_unless(sent.is_some());
        }
    }

    fn lost_unless(&mut self, kept: bool) {
        if !kept {
            self.results_lost = self.results_lost.saturating_add(1);
        }
    }
}

impl Default for Line {
    fn default() -> Self {
        Self::new()
    }
}
