//! A board on a desk: a tool at rest, a line, a watchdog, and a clock that goes on only while the program works or
//! waits.

use meerkat_mwd::{
    Config, Probe, Sample,
    application::{
        Acquired, Acquisition, AcquisitionCounts, Application, Board, Burst, Commands, Line, Memory, ProgramUpdate,
        SampleConsumer, SampleQueue, Settings, Stage, Statics, Updater, provision,
    },
    config::{DynamicsConfig, SurveyConfig},
    storage::FactoryRecord,
    survey::Surveyor,
    telemetry::{CommandRefusal, FrameDecoder, MAX_DECODED, Message, ProbeId, ResetReason, StreamConfig},
};
use mock_flash::MockFlash;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::mem::MaybeUninit;

pub const PROBE: ProbeId = ProbeId(*b"on some desk");
pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";

/// Patience of the watchdog, microseconds: the shortest second that a 32 kHz oscillator with 47 kHz gives.
const PATIENCE_US: u64 = 680_000;
/// Bytes that the serial port holds.
const PORT: u64 = 512;

/// Settings of the board: its times, its line and its readings.
pub struct Desk {
    pub period_us: u64,
    /// Time that a sample, a piece of work and a round of telemetry take, microseconds.
    pub sample_us: u64,
    pub work_us: u64,
    pub telemetry_us: u64,
    pub bytes_per_s: u32,
    /// Returns true if the line takes bytes at this time.
    pub takes: fn(u64) -> bool,
    /// The next byte from the line at this time.
    pub line: Box<dyn FnMut(u64) -> Option<u8>>,
    /// Time stamp of a sample that was read at this time.
    pub stamp: fn(u64) -> u64,
    /// Sample that the sensors read in the place of one at rest.
    pub reads: Box<dyn FnMut(Sample) -> Sample>,
    /// Length of a window of drilling dynamics, seconds.
    pub dynamics_s: f32,
    /// Flash for what has to outlive the power.
    pub flash: Option<MockFlash>,
    /// Receiver of another program.
    pub update: Option<Updater<Images>>,
}

/// Flash of two programs.
pub type Images = MockFlash<4, 1_024>;

impl Default for Desk {
    fn default() -> Self {
        Self {
            period_us: 5_000,
            sample_us: 900,
            work_us: 250,
            telemetry_us: 60,
            bytes_per_s: 10_368,
            takes: |_| true,
            line: Box::new(|_| None),
            stamp: |now_us| now_us,
            reads: Box::new(|at_rest| at_rest),
            dynamics_s: DynamicsConfig::default().window_s,
            flash: None,
            update: None,
        }
    }
}

/// Messages, resets and counts of samples that were seen of the probe.
#[derive(Default)]
pub struct Seen {
    /// Messages and when their last byte left.
    pub messages: Vec<(u64, Message)>,
    /// Times at which the watchdog was not fed in time.
    pub resets: u32,
    pub acquired: u32,
    pub lost: u32,
    pub processed: u32,
    /// The flash at the end.
    pub flash: Option<MockFlash>,
}

struct Machine<'q> {
    desk: Desk,
    now_us: u64,
    fed_us: u64,
    rounds: u64,
    acquisition: Acquisition<'q>,
    waiting: SampleConsumer<'q>,
    counts: &'q AcquisitionCounts,
    noise: Xoshiro128PlusPlus,
    given: u64,
    /// Region of the factory's records.
    factory: MockFlash,
    decoder: FrameDecoder<MAX_DECODED>,
    seen: Seen,
}

/// Flies for a while.
pub fn fly(mut desk: Desk, seconds: u64) -> Seen {
    let dynamics = DynamicsConfig { window_s: desk.dynamics_s, ..DynamicsConfig::default() };
    let survey = SurveyConfig { settle_s: 1.0, average_s: 1.0, dynamics, ..SurveyConfig::default() };
    let settings = Settings {
        config: Config { sample_period_us: desk.period_us as u32, survey, ..Config::default() },
        stream: StreamConfig { bytes_per_s: desk.bytes_per_s, ..StreamConfig::default() },
        recording: false,
        key: Some(KEY),
    };
    let counts = AcquisitionCounts::new();
    let mut queue = SampleQueue::new();
    let (producer, waiting) = queue.split();
    let mut place = MaybeUninit::uninit();
    let mut flash = desk.flash.take();
    let memory = flash.as_mut().and_then(|flash| Memory::start(&mut place, flash, &settings.config, || ()).ok());
    let machine = Machine {
        desk,
        now_us: 0,
        fed_us: 0,
        rounds: 0,
        acquisition: Acquisition::new(producer, &counts),
        waiting,
        counts: &counts,
        noise: Xoshiro128PlusPlus::seed_from_u64(1),
        given: 0,
        factory: MockFlash::new(1, 1),
        decoder: FrameDecoder::new(),
        seen: Seen::default(),
    };
    let (mut probe, mut surveyor, mut burst) = (Box::new(Probe::new()), Surveyor::new(), Box::new(Burst::new()));
    let (mut line, mut commands) = (Box::new(Line::new()), Box::new(Commands::new()));
    let statics = Statics {
        probe: &mut probe,
        surveyor: &mut surveyor,
        burst: &mut burst,
        line: &mut line,
        commands: &mut commands,
        memory,
    };
    let mut application = Application::start(machine, statics, &settings).unwrap();
    // After the first reset it is no longer this start.
    while application.board().now_us < seconds * 1_000_000 && application.board().seen.resets == 0 {
        application.turn();
    }
    let processed = application.counts().processed;
    let seen = core::mem::take(&mut application.board().seen);
    Seen { acquired: counts.acquired(), lost: counts.queue_full(), processed, flash, ..seen }
}

impl Machine<'_> {
    /// Time passes; samples are read meanwhile.
    fn pass(&mut self, us: u64) {
        self.now_us += us;
        if self.now_us - self.fed_us > PATIENCE_US {
            self.seen.resets += 1;
            self.fed_us = self.now_us;
        }
        while (self.rounds + 1) * self.desk.period_us <= self.now_us {
            self.rounds += 1;
            self.acquisition.served(0);
            let at_rest = self.at_rest();
            let sample = (self.desk.reads)(at_rest);
            self.acquisition.put(sample, self.rounds * self.desk.period_us);
        }
    }

    fn at_rest(&mut self) -> Sample {
        let t_us = (self.desk.stamp)(self.rounds * self.desk.period_us);
        let mut near = |value: f32, by: f32| value + by * (self.noise.next_u32() as f32 / u32::MAX as f32 - 0.5);
        Sample {
            t_us,
            gyro_rad_s: [0.0; 3].map(|value| near(value, 0.003)),
            accel_m_s2: [4.0, 1.0, -8.9].map(|value| near(value, 0.03)),
            mag_ut: [20.0, 1.0, 45.0].map(|value| near(value, 0.3)),
            temperature_c: 60.0,
            ..Sample::default()
        }
    }
}

impl<'q> Board for Machine<'q> {
    type Flash = &'q mut MockFlash;

    fn now_us(&self) -> u64 {
        self.now_us
    }

    fn sample(&mut self) -> Option<Acquired> {
        // A chip that was reset computes no more.
        let acquired = self.waiting.dequeue().filter(|_| self.seen.resets == 0)?;
        self.pass(self.desk.sample_us);
        Some(acquired)
    }

    fn acquisition(&self) -> &AcquisitionCounts {
        self.counts
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        let sent = self.now_us * u64::from(self.desk.bytes_per_s) / 1_000_000;
        self.given = self.given.max(sent);
        let room = if (self.desk.takes)(self.now_us) { PORT.saturating_sub(self.given - sent) } else { 0 };
        let taken = bytes.len().min(room as usize);
        self.given += taken as u64;
        let left_us = self.given * 1_000_000 / u64::from(self.desk.bytes_per_s);
        for byte in &bytes[..taken] {
            if let Some(frame) = self.decoder.push(*byte) {
                self.seen.messages.push((left_us, Message::decode(&frame).unwrap()));
            }
        }
        taken
    }

    fn receive(&mut self) -> Option<u8> {
        (self.desk.line)(self.now_us)
    }

    fn feed_watchdog(&mut self) {
        self.fed_us = self.now_us;
    }

    fn idle(&mut self) {
        if self.waiting.is_empty() {
            self.pass((self.rounds + 1) * self.desk.period_us - self.now_us);
        }
    }

    fn reset_reason(&self) -> ResetReason {
        ResetReason::PowerOn
    }

    fn watchdog_resets(&self) -> u32 {
        0
    }

    fn identity(&self) -> ProbeId {
        PROBE
    }

    fn provision(&mut self, record: &FactoryRecord, only_check: bool) -> Result<(), CommandRefusal> {
        provision(&mut self.factory, record, only_check)
    }

    fn program_update(&mut self) -> Option<&mut dyn ProgramUpdate> {
        self.desk.update.as_mut().map(|update| update as &mut dyn ProgramUpdate)
    }

    fn stack_bytes(&self) -> [u32; 2] {
        [0; 2]
    }

    fn enter(&mut self, stage: Stage) {
        self.pass(match stage {
            Stage::Work => self.desk.work_us,
            Stage::Telemetry => self.desk.telemetry_us,
            _ => 1,
        });
    }
}
