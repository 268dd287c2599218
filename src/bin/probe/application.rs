//! The probe's program, the same on every board: samples first, then one bounded piece of identification or diagnosis, then
//! telemetry, then sleep.

pub mod acquisition;
pub mod board;
pub mod delay;
pub mod sample_clock;
pub mod stage;

use acquisition::{Acquired, COUNTS};
use board::{Board, ResetCause};
use delay::Delays;
use meerkat_mwd::{
    Config, Probe,
    config::{ConfigError, SurveyConfig},
    survey::{SurveyNews, Surveyor},
};
use stage::{Progress, Stage};

/// Units of work in one piece, some 30,000 instructions; a piece that is not cut up overshoots it.
const SLICE_UNITS: u32 = 100;

/// Work that is put off for later when the loop is short of time, in samples' shares: a second at 200 Hz.
const OWED_SAMPLES: u32 = 200;

/// What the application has counted since the start.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Samples taken out of the queue.
    pub processed: u32,
    /// Samples whose number was not the next one: the queue was full, or a tick was missed.
    pub sequence_breaks: u32,
    /// Windows identified, whether or not a model came of it.
    pub windows: u32,
    /// Diagnoses that were made.
    pub diagnoses: u32,
    /// Times that every stage had made progress.
    pub watchdog_fed: u32,
    /// From acquisition to attitude.
    pub delays: Delays,
}

/// The program on one board.
pub struct Application<B: Board> {
    board: B,
    probe: &'static mut Probe,
    surveyor: &'static mut Surveyor,
    next_sequence: u32,
    owed_units: u32,
    progress: Progress,
    acquired: u32,
    sample_period_us: u32,
    counts: Counts,
}

impl<B: Board> Application<B> {
    /// Starts from a configuration.
    ///
    /// # Errors
    /// The field that cannot be used.
    pub fn start(
        board: B,
        probe: &'static mut Probe,
        surveyor: &'static mut Surveyor,
        config: &Config,
        survey: &SurveyConfig,
    ) -> Result<Self, ConfigError> {
        probe.configure(config)?;
        surveyor.configure(&config.earth, survey)?;
        Ok(Self {
            board,
            probe,
            surveyor,
            next_sequence: 0,
            owed_units: 0,
            progress: Progress::default(),
            acquired: COUNTS.acquired(),
            sample_period_us: config.sample_period_us,
            counts: Counts::default(),
        })
    }

    /// One round of the loop; sleeps when nothing is left to do.
    pub fn turn(&mut self) {
        self.enter(Stage::Samples);
        while let Some(acquired) = self.board.samples().dequeue() {
            self.fly(&acquired);
            self.progress.made(Stage::Samples);
        }
        self.enter(Stage::Work);
        let more = self.work();
        self.progress.made(Stage::Work);
        self.enter(Stage::Telemetry);
        self.telemetry();
        self.progress.made(Stage::Telemetry);
        self.watch();
        if !more {
            self.board.idle();
        }
    }

    pub const fn sample_period_us(&self) -> u32 {
        self.sample_period_us
    }

    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    pub const fn probe(&self) -> &Probe {
        self.probe
    }

    pub const fn board(&mut self) -> &mut B {
        &mut self.board
    }

    pub fn reset_cause(&self) -> ResetCause {
        self.board.reset_cause()
    }

    fn enter(&mut self, stage: Stage) {
        self.board.enter(stage);
    }

    /// One sample to its attitude.
    #[inline(never)]
    fn fly(&mut self, acquired: &Acquired) {
        if acquired.sequence != self.next_sequence {
            self.counts.sequence_breaks = self.counts.sequence_breaks.saturating_add(1);
        }
        self.next_sequence = acquired.sequence.wrapping_add(1);
        let sample = &acquired.sample;
        if let Some(output) = self.probe.push(sample) {
            self.counts.delays.add(self.board.now_us().saturating_sub(sample.t_us));
            let _news: SurveyNews = self.surveyor.push(&self.probe.survey_input(sample, &output));
        }
        self.counts.processed = self.counts.processed.wrapping_add(1);
        let budget = self.probe.poll_budget();
        let most = budget.saturating_mul(OWED_SAMPLES);
        self.owed_units = self.owed_units.saturating_add(budget);
        if self.owed_units > most {
            self.owed_units = most;
        }
    }

    /// One bounded piece of identification or diagnosis; whether more is owed.
    #[inline(never)]
    fn work(&mut self) -> bool {
        let slice = if self.owed_units < SLICE_UNITS { self.owed_units } else { SLICE_UNITS };
        self.owed_units -= slice;
        if slice > 0 {
            if self.probe.poll(slice).is_some() {
                self.counts.windows = self.counts.windows.saturating_add(1);
            }
            if self.probe.take_diagnosis().is_some() {
                self.counts.diagnoses = self.counts.diagnoses.saturating_add(1);
            }
        }
        self.owed_units > 0
    }

    fn telemetry(&mut self) {
        while self.board.receive().is_some() {}
    }

    /// Feeds the watchdog when every stage has made progress.
    fn watch(&mut self) {
        let acquired = COUNTS.acquired();
        if acquired != self.acquired {
            self.acquired = acquired;
            self.progress.made(Stage::Acquisition);
        }
        if self.progress.take_if_whole() {
            self.board.feed_watchdog();
            self.counts.watchdog_fed = self.counts.watchdog_fed.wrapping_add(1);
        }
    }
}
