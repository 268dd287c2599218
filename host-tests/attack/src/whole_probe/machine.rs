//! The board under the program: sensors that follow the clock, a line, and what goes wrong with them.

use super::{
    chip::{Chip, ChipFlash, Death},
    day::Day,
    plan::Trouble,
    truth::Angles,
};
use meerkat_mwd::{
    Sample,
    application::{Acquired, Acquisition, AcquisitionCounts, Board, QUEUE, SampleConsumer, Stage},
    emulation::{BusFault, Injection, ModelledParts, RecordingPlayer, Schedule},
    telemetry::{Message, ProbeId, ResetReason},
};
use std::collections::VecDeque;

/// Depth of the modelled FIFO in words.
pub const WORDS: usize = 16;
/// Time between samples, microseconds.
pub const PERIOD_US: u64 = 10_000;
/// Computing time of a sample, of a piece of work and of a round of telemetry, microseconds: those of the chip, rounded
/// up.
const SAMPLE_US: u64 = 900;
const WORK_US: u64 = 250;
const TELEMETRY_US: u64 = 60;
/// Bytes that a serial port holds in each direction.
const SENDING: u64 = 512;
const RECEIVING: usize = 256;
/// Counters of health that are judged.
pub const HEALTH: usize = 12;
/// Samples of which the truth is kept.
const REMEMBERED: usize = 300;

/// Time until which something goes on, microseconds.
#[derive(Default)]
struct Until {
    noise: (u32, u64),
    stalled_us: u64,
    overload: (u64, u64),
}

/// The board from one start to the next.
pub struct Machine<'c, 'd> {
    pub chip: &'c Chip,
    pub day: &'d mut Day,
    parts: &'c ModelledParts<WORDS>,
    player: RecordingPlayer<'c, WORDS>,
    acquisition: Acquisition<'c>,
    waiting: SampleConsumer<'c>,
    counts: &'c AcquisitionCounts,
    reason: ResetReason,
    /// Rounds of the sample clock since the start, and by how much the board's clock is ahead of it.
    rounds: u64,
    step_us: i64,
    /// When it last stepped, microseconds of the chip.
    stepped_us: Option<u64>,
    hang: Option<Stage>,
    until: Until,
    /// True if an effect is taken out.
    pub takes_an_effect_out: bool,
    /// When the line last changed a byte, microseconds of the chip.
    pub spoilt_us: Option<u64>,
    /// Bytes given to the line, those that it could have sent included.
    given: u64,
    received: VecDeque<(u8, Option<usize>)>,
    /// Stamps of the latest samples, and the truth at each.
    pub truths: VecDeque<(u64, Angles)>,
    /// Time at which the probe said that its pipeline had started afresh, and the first sample since.
    pub boot_us: u64,
    pub first_sample: u32,
    /// Time of the last fault of a sensor or of the clock, microseconds of the chip.
    pub unsound_us: Option<u64>,
    /// Counters of the health that was heard last.
    pub health: [u32; HEALTH],
    /// Numbers and stamps of the samples that were taken into the queue and not handed out yet.
    queued: VecDeque<(u32, u64)>,
    /// Samples that were put to the queue, that it has refused, and that it has handed out.
    put: u32,
    refused: u32,
    handed_out: u32,
    /// Number after that of the last one that was handed out, and times that a number was not that.
    next: u32,
    pub breaks: u32,
    /// First sample that was not handed out as it was taken, in its place.
    pub misplaced: Option<String>,
    /// Judge of every message that the host hears.
    judge: fn(&mut Self, &Message),
}

impl<'c, 'd> Machine<'c, 'd> {
    pub fn new(
        chip: &'c Chip,
        day: &'d mut Day,
        (parts, mut player): (&'c ModelledParts<WORDS>, RecordingPlayer<'c, WORDS>),
        (acquisition, waiting, counts): (Acquisition<'c>, SampleConsumer<'c>, &'c AcquisitionCounts),
        reason: ResetReason,
        judge: fn(&mut Self, &Message),
    ) -> Self {
        player.settle(&Sample { t_us: PERIOD_US, ..day.truth.sample() });
        Self {
            chip,
            day,
            parts,
            player,
            acquisition,
            waiting,
            counts,
            reason,
            rounds: 0,
            step_us: 0,
            stepped_us: None,
            hang: None,
            until: Until::default(),
            takes_an_effect_out: false,
            spoilt_us: None,
            given: 0,
            received: VecDeque::new(),
            truths: VecDeque::new(),
            boot_us: chip.now_us.get(),
            first_sample: 0,
            unsound_us: None,
            health: [0; HEALTH],
            queued: VecDeque::new(),
            put: 0,
            refused: 0,
            handed_out: 0,
            next: 0,
            breaks: 0,
            misplaced: None,
            judge,
        }
    }

    /// Samples that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Returns true if a stage hangs.
    pub const fn hangs(&self) -> bool {
        self.hang.is_some()
    }

    /// Returns true if the line has taken nothing lately.
    pub fn line_stood_still(&self) -> bool {
        self.chip.now_us.get() < self.until.stalled_us + 3_000_000
    }

    /// When the last fault of sensors, clock or computing time ended, or the pipeline started afresh.
    pub fn sound_since_us(&self) -> u64 {
        self.unsound_us.unwrap_or(0).max(self.until.overload.1).max(self.boot_us)
    }

    /// Returns true if work takes longer than it should, or did lately.
    pub fn overloaded(&self) -> bool {
        self.chip.now_us.get() < self.until.overload.1 + 1_000_000
    }

    /// Returns true if the board's clock has stepped, so lately that times before and after it may be compared.
    pub fn clock_stepped(&self) -> bool {
        let settles_s = self.day.proportions.clock_settles_s;
        self.stepped_us.is_some_and(|at_us| ((self.chip.now_us.get() - at_us) as f64) < settles_s * 1e6)
    }

    fn since_start_us(&self) -> u64 {
        self.chip.now_us.get() - self.chip.started_us.get()
    }

    fn stamp(&self, since_start_us: u64) -> u64 {
        since_start_us.saturating_add_signed(self.step_us)
    }

    /// Time passes, and with it come the ticks of the sample clock.
    fn pass(&mut self, us: u64) {
        let load = if self.chip.now_us.get() < self.until.overload.1 { self.until.overload.0 } else { 1 };
        self.chip.pass(us * load);
        self.catch_up();
    }

    /// Serves every tick that has been due.
    fn catch_up(&mut self) {
        let due = self.since_start_us() / PERIOD_US;
        if due > self.rounds && !self.chip.is_dead() && self.hang != Some(Stage::Acquisition) {
            let missed = due - self.rounds - 1;
            self.acquisition.served(u32::try_from(missed).unwrap_or(u32::MAX));
        }
        while self.rounds < due && !self.chip.is_dead() {
            self.rounds += 1;
            self.tick();
        }
        let now_us = self.chip.now_us.get();
        while self.day.host.outgoing.front().is_some_and(|(at_us, ..)| *at_us <= now_us) {
            let Some((_, byte, command)) = self.day.host.outgoing.pop_front() else { break };
            let byte = self.spoilt(byte);
            if self.received.len() < RECEIVING {
                self.received.push_back((byte, command));
            }
        }
    }

    /// One sample period of the world.
    fn tick(&mut self) {
        let tick_us = self.chip.started_us.get() + self.rounds * PERIOD_US;
        while let Some(trouble) = self.day.next_trouble(tick_us) {
            self.strike(trouble);
        }
        self.day.truth.step();
        let t_us = self.rounds * PERIOD_US;
        let truth = Sample { t_us, ..self.day.truth.sample() };
        self.player.pass_to(&truth);
        if self.hang == Some(Stage::Acquisition) {
            return;
        }
        let sample = self.player.service();
        let stamp_us = self.stamp(sample.t_us);
        self.truths.push_back((stamp_us, self.day.truth.angles()));
        if self.truths.len() > REMEMBERED {
            self.truths.pop_front();
        }
        self.put(Sample { t_us: stamp_us, ..sample });
        self.day.tally.queue = self.day.tally.queue.max(self.waiting.len() as u64);
    }

    /// Puts a sample to the queue, and notes its number and stamp if it has room.
    fn put(&mut self, sample: Sample) {
        let had_room = self.waiting.len() + 1 < QUEUE;
        self.acquisition.put(sample, sample.t_us);
        if had_room {
            self.queued.push_back((self.put, sample.t_us));
        } else {
            self.refused += 1;
        }
        self.put += 1;
    }

    /// Compares a sample that is handed out with the one whose turn it is.
    fn hand_out(&mut self, acquired: &Acquired) {
        let (number, t_us) = (acquired.sequence, acquired.sample.t_us);
        let taken = self.queued.pop_front();
        if taken != Some((number, t_us)) {
            self.misplaced.get_or_insert_with(|| format!("{:?} was handed out for {taken:?}", (number, t_us)));
        }
        self.handed_out += 1;
        self.breaks += u32::from(number != self.next);
        self.next = number + 1;
    }

    /// Samples of this start: put to the queue, refused by it, and handed out.
    pub const fn samples(&self) -> [u32; 3] {
        [self.put, self.refused, self.handed_out]
    }

    fn strike(&mut self, trouble: Trouble) {
        let now_us = self.chip.now_us.get();
        self.day.struck.push((now_us, trouble));
        let tally = &mut self.day.tally;
        match tally.troubles.get_mut(trouble.kind()) {
            Some(count) => *count += 1,
            None => tally.commands += 1,
        }
        let host = &mut self.day.host;
        let sent = match trouble {
            Trouble::Owner => host.owner(now_us),
            Trouble::WrongKey => host.forger(now_us, false),
            Trouble::OtherProbe => host.forger(now_us, true),
            Trouble::Flood(commands) => host.flood(now_us, commands),
            Trouble::Replay => {
                host.replay(now_us);
                Ok(())
            }
            Trouble::Garbage(bytes) => {
                host.garbage(now_us, bytes);
                Ok(())
            }
            _ => Ok(()),
        };
        if let Err(error) = sent {
            self.day.tally.first.get_or_insert_with(|| format!("a command could not be encoded: {error}"));
        }
        match trouble {
            Trouble::PowerCut => self.chip.die(Death::PowerCut),
            Trouble::CutInFlash(after, cut) => self.chip.flash.borrow_mut().cut_in(after, cut),
            Trouble::Wire(inertial, fault, lasting_us) => {
                let wire = if inertial { &self.parts.inertial_wire } else { &self.parts.magnetic_wire };
                wire.set(Schedule::of(Injection { fault, at_transaction: 0, lasting_us }));
                self.unsound(lasting_us);
            }
            Trouble::SilentStart => {
                let fault = BusFault::Locked;
                let lasting_us = 5_000_000;
                self.parts.inertial_wire.set(Schedule::of(Injection { fault, at_transaction: 0, lasting_us }));
                self.unsound(lasting_us);
                self.day.owner_at(now_us + 3_200_000);
            }
            Trouble::Part(true, fault, lasting_us) => {
                self.parts.inertial.borrow_mut().inject(Injection { fault, at_transaction: 0, lasting_us });
                self.unsound(lasting_us);
            }
            Trouble::Part(false, fault, lasting_us) => {
                self.parts.magnetic.borrow_mut().inject(Injection { fault, at_transaction: 0, lasting_us });
                self.unsound(lasting_us);
            }
            Trouble::LineNoise(every, lasting_us) => self.until.noise = (every, now_us + lasting_us),
            Trouble::LineStall(lasting_us) => self.until.stalled_us = now_us + lasting_us,
            Trouble::ClockStep(us) => {
                self.step_us += us;
                self.stepped_us = Some(now_us);
                self.unsound(0);
            }
            Trouble::Overload(times, lasting_us) => self.until.overload = (times, now_us + lasting_us),
            Trouble::Hang(stage) => self.hang = Some(stage),
            _ => {}
        }
    }

    fn unsound(&mut self, lasting_us: u64) {
        let until_us = self.chip.now_us.get() + lasting_us;
        self.unsound_us = Some(self.unsound_us.map_or(until_us, |before| before.max(until_us)));
    }

    /// A byte after the noise of the line.
    fn spoilt(&mut self, byte: u8) -> u8 {
        let (every, until_us) = self.until.noise;
        let random = &mut self.day.random;
        if self.chip.now_us.get() < until_us && random.uniform() * f64::from(every) < 1.0 {
            self.spoilt_us = Some(self.chip.now_us.get());
            return byte ^ 1 << random.between(0.0, 8.0) as u8;
        }
        byte
    }
}

impl<'c> Board for Machine<'c, '_> {
    type Flash = ChipFlash<'c>;

    fn now_us(&self) -> u64 {
        self.stamp(self.since_start_us())
    }

    fn sample(&mut self) -> Option<Acquired> {
        self.catch_up();
        if self.chip.is_dead() {
            return None;
        }
        let acquired = self.waiting.dequeue()?;
        self.hand_out(&acquired);
        self.pass(SAMPLE_US);
        Some(acquired)
    }

    fn acquisition(&self) -> &AcquisitionCounts {
        self.counts
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        self.chip.note_stack();
        let now_us = self.chip.now_us.get();
        if self.chip.is_dead() || now_us < self.until.stalled_us {
            return 0;
        }
        let sent = self.since_start_us() * u64::from(self.day.bytes_per_s) / 1_000_000;
        self.given = self.given.max(sent);
        let room = SENDING.saturating_sub(self.given - sent);
        let taken = bytes.len().min(room as usize);
        self.given += taken as u64;
        for byte in &bytes[..taken] {
            let byte = self.spoilt(*byte);
            self.day.digest(byte);
            if let Some(message) = self.day.host.hear(byte) {
                (self.judge)(self, &message);
            }
        }
        taken
    }

    fn receive(&mut self) -> Option<u8> {
        self.chip.note_stack();
        self.catch_up();
        if self.chip.is_dead() {
            return None;
        }
        let (byte, command) = self.received.pop_front()?;
        if let Some(command) = command {
            self.day.host.taken(command, self.day.truth.drilling_for_s());
        }
        Some(byte)
    }

    fn feed_watchdog(&mut self) {
        self.chip.feed();
    }

    fn idle(&mut self) {
        self.catch_up();
        if self.waiting.is_empty() {
            let next_us = (self.since_start_us() / PERIOD_US + 1) * PERIOD_US;
            self.chip.pass(next_us - self.since_start_us());
            self.catch_up();
        }
    }

    fn reset_reason(&self) -> ResetReason {
        self.reason
    }

    fn watchdog_resets(&self) -> u32 {
        self.day.watchdog_resets
    }

    fn identity(&self) -> ProbeId {
        super::host::PROBE
    }

    fn stack_bytes(&self) -> [u32; 2] {
        [0; 2]
    }

    fn enter(&mut self, stage: Stage) {
        self.chip.note_stack();
        self.pass(match stage {
            Stage::Work => WORK_US,
            Stage::Telemetry => TELEMETRY_US,
            _ => 1,
        });
        if self.hang == Some(stage) {
            self.chip.pass(2 * super::chip::PATIENCE_US);
        }
    }
}
