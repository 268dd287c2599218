//! The probe's program, the same on every board: samples first, then one bounded piece of identification or
//! diagnosis, then telemetry, then sleep.
//!
//! A `main` calls [`factory_records`], `data_sheet` and [`apply_factory_records`] for its [`Settings`],
//! [`Memory::start`], [`Application::start`], lets the sample clock call `Sensors::read`, and then
//! [`Application::turn`] for ever.

mod acquisition;
mod board;
mod burst;
mod commands;
mod delay;
mod factory;
mod line;
mod log;
mod memory;
mod owed_work;
mod program_update;
mod reports;
mod sensor_faults;
#[cfg(feature = "bus")]
mod sensors;
mod stage;
mod update;

pub use acquisition::{Acquired, Acquisition, AcquisitionCounts, QUEUE, SampleConsumer, SampleQueue};
pub use board::Board;
pub use burst::{BURST_SAMPLES, Burst};
pub use commands::Commands;
pub use delay::{Delays, LATE_US};
pub use factory::{apply_factory_records, factory_records, provision};
pub use line::Line;
pub use memory::Memory;
pub use program_update::{ProgramUpdate, Updater};
#[cfg(feature = "bus")]
pub use sensors::{Interrupts, Sensors, data_sheet};
pub use stage::Stage;
pub use update::PROVEN_US;

use crate::{
    Config, Probe,
    attitude::AttitudeFlags,
    config::ConfigError,
    survey::{SurveyNews, Surveyor},
    telemetry::{Key, StreamConfig},
};
use log::info;
use owed_work::OwedWork;
use stage::Progress;
use update::Update;

/// Reports of the vibration dose from one that is stored to the next: half an hour. At 128 bytes each the stored ones
/// fill a sector of 16 KiB in 64 hours.
const STORED_DOSES: u8 = 6;

/// Microseconds from one report of health to the next.
const HEALTH_US: u64 = 5_000_000;

/// Microseconds after the start at which health is reported first.
const SILENT_US: u64 = 1_000_000;

/// Settings that the probe starts from.
pub struct Settings {
    /// Configuration of the pipeline and of the surveys.
    pub config: Config,
    /// Configuration of the line.
    pub stream: StreamConfig,
    /// True if raw samples are sent from the start.
    pub recording: bool,
    /// The key of commands that need one, which the start hands to [`Commands`]; `None`: none was provisioned.
    pub key: Option<[u8; 32]>,
}

/// Buffers of the application, in static RAM.
pub struct Statics<'a, F> {
    /// Samples to attitudes and models.
    pub probe: &'a mut Probe,
    /// Attitudes to surveys.
    pub surveyor: &'a mut Surveyor,
    /// Recorder of the second with the worst vibration.
    pub burst: &'a mut Burst,
    /// Line that sends messages to the host.
    pub line: &'a mut Line,
    /// Receiver of the host's commands.
    pub commands: &'a mut Commands,
    /// Stored models; `None` if no flash can be used: the probe flies without.
    pub memory: Option<&'a mut Memory<F>>,
}

impl<F> Statics<'_, F> {
    /// Configuration in use. That of the surveys may have been set after the pipeline's.
    fn config(&self) -> Config {
        let config = *self.probe.config();
        Config { survey: self.surveyor.config().copied().unwrap_or(config.survey), ..config }
    }
}

/// Counters of the application since the start.
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
    /// Delays from acquisition to attitude.
    pub delays: Delays,
}

/// The program on one board.
pub struct Application<'a, B: Board> {
    board: B,
    statics: Statics<'a, B::Flash>,
    /// True once the first sample has come, for which a stored model may have been restored.
    begun: bool,
    next_sequence: u32,
    /// Number of the first sample since the pipeline started afresh.
    first_sequence: u32,
    owed: OwedWork,
    /// True while the estimator's state is being written to flash, a tenth of a second; identification waits until
    /// then.
    filter_stays: bool,
    /// Reports of the vibration dose since it was stored.
    doses: u8,
    progress: Progress,
    served: u32,
    /// When the next report of health is due.
    health_us: u64,
    /// When the last round began.
    round_us: u64,
    update: Update,
    counts: Counts,
}

impl<'a, B: Board> Application<'a, B> {
    /// Starts from a configuration, or from what commands have set since.
    ///
    /// # Errors
    /// The field that cannot be used.
    pub fn start(board: B, mut statics: Statics<'a, B::Flash>, settings: &Settings) -> Result<Self, ConfigError> {
        let Settings { config, stream, recording, key } = settings;
        let mut config = *config;
        if let Some(memory) = &mut statics.memory {
            memory.apply_commands(&mut config);
        }
        statics.probe.configure(&config)?;
        statics.surveyor.configure(&config.earth, &config.survey)?;
        statics.line.configure(stream)?;
        if let Some(dose) = statics.memory.as_mut().and_then(|memory| memory.dose()) {
            statics.surveyor.resume_dose(dose);
        }
        if *recording {
            statics.commands.recording.start(0, None, true);
        }
        statics.line.record(*recording);
        statics.commands.provision(key.as_ref().and_then(|key| Key::new(key, board.identity())));
        Ok(Self {
            served: board.acquisition().served(),
            board,
            statics,
            begun: false,
            next_sequence: 0,
            first_sequence: 0,
            owed: OwedWork::default(),
            filter_stays: false,
            doses: 0,
            progress: Progress::default(),
            // The first report is the boot's, at the first sample; without a sample it is this one.
            health_us: SILENT_US,
            round_us: 0,
            update: Update::new(),
            counts: Counts::default(),
        })
    }

    /// One round of the loop; sleeps when nothing is left to do.
    pub fn turn(&mut self) {
        let now_us = self.board.now_us();
        if now_us < core::mem::replace(&mut self.round_us, now_us) {
            self.clock_went_back(now_us);
        }
        self.enter(Stage::Samples);
        // At most one queue of samples: if they come faster than they are flown, the excess is lost and counted, and
        // the other stages go on.
        for _ in 0..QUEUE {
            let Some(acquired) = self.board.sample() else { break };
            self.fly(&acquired);
        }
        // With or without a sample: dead sensors must not make the watchdog reset the chip.
        self.progress.made(Stage::Samples);
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

    /// Restarts what waits for a time: after the clock went back the wait would be long, and old evidence of rest
    /// would look fresh when its time comes again. The pipeline handles such a step itself.
    #[inline(never)]
    fn clock_went_back(&mut self, now_us: u64) {
        let Statics { surveyor, line, commands, .. } = &mut self.statics;
        surveyor.restart();
        line.clock_went_back();
        commands.recording.stop(true);
        self.health_us = now_us;
        self.update.clock_went_back(now_us);
    }

    fn enter(&mut self, stage: Stage) {
        self.board.enter(stage);
    }

    /// Turns one sample into its attitude.
    #[inline(never)]
    fn fly(&mut self, acquired: &Acquired) {
        if acquired.sequence != self.next_sequence {
            self.counts.sequence_breaks = self.counts.sequence_breaks.saturating_add(1);
        }
        self.next_sequence = acquired.sequence.wrapping_add(1);
        let sample = &acquired.sample;
        if !self.begun {
            self.begin(acquired);
        }
        let Statics { probe, surveyor, burst, line, commands, memory } = &mut self.statics;
        if let Some(memory) = memory {
            memory.sample(sample);
        }
        commands.mounting.update(sample, probe.gyro_model().b_rad_s);
        probe.mistrust_mounting(commands.mounting.wrong());
        let output = probe.push(sample);
        let now_us = self.board.now_us();
        let began_afresh = output.is_some() && probe.began_afresh();
        if began_afresh && let Some(memory) = memory {
            memory.configured(probe.config());
        }
        if let Some(output) = &output {
            self.counts.delays.add(acquired.read_us, now_us as u32);
            let flags = output.attitude.map_or(AttitudeFlags::ACCEL_UNUSED, |attitude| attitude.flags);
            commands.faults.update(sample.t_us, flags);
            let input = probe.survey_input(sample, output);
            burst.push(&input);
            let mut news = surveyor.push(&input);
            // At rest attitudes and the survey report the toolface, and the survey must not wait for another message.
            if surveyor.stands_still(sample.t_us) {
                news.remove(SurveyNews::TOOLFACE);
            }
            line.surveys(news);
            if news.contains(SurveyNews::DOSE)
                && let Some(memory) = memory
            {
                self.doses += 1;
                if self.doses >= STORED_DOSES {
                    self.doses = 0;
                    memory.keep_dose(surveyor.dose());
                }
            }
        }
        line.sample(now_us, acquired.sequence, sample, output.as_ref());
        self.counts.processed = self.counts.processed.wrapping_add(1);
        if began_afresh {
            self.restarted();
            // The sample itself is the first one.
            self.first_sequence = acquired.sequence;
        }
        let budget = self.statics.probe.poll_budget_at(self.board.clock_hz());
        self.owed.add(budget);
    }

    /// Restores a stored model before the first sample is flown: the sample's temperature selects the model.
    #[inline(never)]
    fn begin(&mut self, first: &Acquired) {
        self.begun = true;
        self.first_sequence = first.sequence;
        let Statics { probe, memory, .. } = &mut self.statics;
        if let Some(memory) = memory {
            memory.restore(probe, &first.sample);
        }
        self.statics.line.want_boot();
    }

    /// Notes that the pipeline has started afresh: a boot is to be reported.
    fn restarted(&mut self) {
        self.first_sequence = self.next_sequence;
        self.statics.line.want_boot();
    }

    /// Does one bounded piece of identification or diagnosis. Returns true if more is owed.
    #[inline(never)]
    fn work(&mut self) -> bool {
        if self.filter_stays {
            let Statics { probe, memory, .. } = &mut self.statics;
            self.filter_stays = memory.as_mut().is_some_and(|memory| memory.step(probe));
            return true;
        }
        let units = self.owed.take_piece();
        if units > 0 {
            let Statics { probe, line, memory, .. } = &mut self.statics;
            if let Some(report) = probe.poll(units) {
                if let Some(memory) = memory {
                    memory.window(probe, &report);
                }
                info!("window to {=u64:us}: {}", report.t_end_us, report.decision);
                self.counts.windows = self.counts.windows.saturating_add(1);
                line.window(report);
            }
        }
        let Statics { probe, memory, .. } = &mut self.statics;
        if let Some(memory) = memory {
            self.filter_stays = memory.step(probe);
        }
        self.filter_stays || !self.owed.is_done()
    }

    /// Sends one frame at most, and reads the bytes received.
    #[inline(never)]
    fn telemetry(&mut self) {
        let now_us = self.board.now_us();
        let Statics { commands, line, .. } = &self.statics;
        if (now_us >= self.health_us || !commands.self_test.is_empty()) && line.takes_health() {
            self.health_us = now_us + HEALTH_US;
            reports::health(&self.board, &mut self.statics, &self.counts.delays, now_us);
            reports::program(&mut self.board, &mut self.statics, now_us);
        }
        self.take_diagnosis(now_us);
        self.take_magnet(now_us);
        self.receive(now_us);
        let Statics { surveyor, burst, line, .. } = &mut self.statics;
        line.queue_results(now_us, surveyor, burst);
        if line.takes_boot() {
            reports::boot(&self.board, &mut self.statics, self.first_sequence, now_us);
        }
        self.statics.line.transmit(&mut self.board);
        let now_us = self.board.now_us();
        let stands_still = self.statics.surveyor.stands_still(now_us);
        self.update.go_on(&mut self.board, now_us, stands_still);
    }

    #[inline(never)]
    fn take_diagnosis(&mut self, now_us: u64) {
        let Statics { probe, line, .. } = &mut self.statics;
        if !line.takes_finding() {
            return;
        }
        if let Some(report) = probe.take_diagnosis() {
            self.counts.diagnoses = self.counts.diagnoses.saturating_add(1);
            info!("{=u64:us}: {}", now_us, report.verdict);
            line.diagnosis(now_us, &report);
        }
    }

    #[inline(never)]
    fn take_magnet(&mut self, now_us: u64) {
        let Statics { probe, line, .. } = &mut self.statics;
        if line.takes_finding()
            && let Some(interval) = probe.take_hard_iron_interval()
        {
            line.magnet(now_us, &interval);
        }
    }

    /// Feeds the watchdog when every stage has made progress.
    fn watch(&mut self) {
        let served = self.board.acquisition().served();
        if served != self.served {
            self.served = served;
            self.progress.made(Stage::Acquisition);
        }
        if self.progress.take_if_whole() {
            self.board.feed_watchdog();
            self.counts.watchdog_fed = self.counts.watchdog_fed.wrapping_add(1);
            self.update.confirm(&mut self.board);
        }
    }
}

/// State that a test without hardware reads, beside the frames that are sent.
impl<'a, B: Board> Application<'a, B> {
    /// Returns the board on which the application runs.
    pub const fn board(&mut self) -> &mut B {
        &mut self.board
    }

    /// Counts since the start.
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Buffers in static RAM.
    pub const fn statics(&self) -> &Statics<'a, B::Flash> {
        &self.statics
    }
}
