//! Commands of a host, and their execution.

use super::{Application, Board, Statics, log::info, memory::refusal, sensor_faults::SensorFaults, update};
use crate::{
    config::{Config, ConfigError},
    sensors::MountingCheck,
    storage::{Image, NotDrilling},
    survey::StationaryState,
    telemetry::{
        Acknowledgement, Command, CommandCounters, CommandGate, CommandRefusal, CounterStore, EarlierModel, Erasure,
        FrameDecoder, Judgement, Key, Kind, LinkCounters, Outcome, Recording, SelfTest, Situation,
    },
};
use heapless::Vec;

/// Longest frame that is accepted, bytes without COBS: more than a configuration with its authentication.
const LONGEST: usize = 640;

/// Most bytes read from the line in one round of the loop.
const BYTES_A_ROUND: u32 = 64;

/// Receiver of commands. All zero at first, so that a `static` of it costs no flash.
pub struct Commands {
    decoder: FrameDecoder<LONGEST>,
    gate: CommandGate,
    /// Result of a self-test, to be reported with the health at once.
    pub(super) self_test: Vec<SelfTest, 1>,
    /// Turns that the sensors have seen, for a self-test.
    pub(super) mounting: MountingCheck,
    /// Faults of the sensors over a second, for a self-test.
    pub(super) faults: SensorFaults,
    /// Requests for raw samples, and their ends.
    pub(super) recording: Recording,
}

impl Commands {
    /// Creates a receiver without a key.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            decoder: FrameDecoder::new(),
            gate: CommandGate::new(None),
            self_test: Vec::new(),
            mounting: MountingCheck::new(),
            faults: SensorFaults::new(),
            recording: Recording::new(),
        }
    }

    /// Sets the key that was provisioned; without one, no command that needs it is carried out.
    pub fn provision(&mut self, key: Option<Key>) {
        self.gate = CommandGate::new(key);
    }

    /// Counters of good and bad frames received.
    #[must_use]
    pub const fn link(&self) -> LinkCounters {
        self.decoder.counters()
    }

    /// Counters of the commands received.
    #[must_use]
    pub const fn counters(&self) -> CommandCounters {
        self.gate.counters()
    }
}

/// Counter store of a probe without a memory: no authenticated command is carried out.
struct NoCounter;

impl CounterStore for NoCounter {
    type Error = ();

    fn read(&mut self) -> Result<u64, ()> {
        Err(())
    }

    fn store(&mut self, _counter: u64) -> Result<(), ()> {
        Err(())
    }
}

impl Default for Commands {
    fn default() -> Self {
        Self::new()
    }
}

impl<B: Board> Application<'_, B> {
    /// Reads the bytes received; carries out one command at most.
    pub(super) fn receive(&mut self, now_us: u64) {
        let Statics { commands, line, .. } = &mut self.statics;
        line.record(commands.recording.is_on(now_us));
        for _ in 0..BYTES_A_ROUND {
            let Some(byte) = self.board.receive() else { return };
            if self.take(now_us, byte) {
                return;
            }
        }
    }

    /// Takes a byte; returns true if it ended a frame.
    #[inline(never)]
    fn take(&mut self, now_us: u64, byte: u8) -> bool {
        // A probe that is not known to stand still may be drilling.
        let drilling = !self.statics.surveyor.stands_still(now_us);
        let Statics { commands, memory, line, .. } = &mut self.statics;
        let Commands { decoder, gate, .. } = &mut **commands;
        let Some(frame) = decoder.push(byte) else { return false };
        if frame.kind == Kind::ImagePart.number() {
            // A part that is no progress needs no key: such answers are few.
            if let Some(answer) = update::take_part(&mut self.board, &frame)
                && (answer.outcome == Outcome::Accepted || gate.may_answer_part(now_us))
            {
                line.acknowledge(now_us, &answer);
            }
            return true;
        }
        let situation = Situation { now_us, drilling };
        let judgement = match memory {
            Some(memory) => gate.judge(&frame, situation, *memory),
            None => gate.judge(&frame, situation, &mut NoCounter),
        };
        // Somebody with the key found no room for the counter, also if the answer is spared: the next try finds it.
        if let Some(memory) = memory
            && memory.takes_lack_of_room()
            && !drilling
        {
            // A flash that fails is told with the next try.
            let _ = memory.prepare(NotDrilling::Command, &mut || self.board.feed_watchdog());
        }
        let answer = match judgement {
            Judgement::Ignore => return true,
            Judgement::Refuse(answer) => answer,
            Judgement::CarryOut { sequence, command, bytes, authentic } => {
                // Stored first: what is set and not stored would be gone after a reset, with nobody told.
                let feed = &mut || self.board.feed_watchdog();
                let kept = memory.as_mut().map_or(Ok(()), |memory| memory.keep_command(&command, bytes, feed));
                let outcome = match kept.and_then(|()| self.carry_out(now_us, &command, authentic)) {
                    Ok(()) => Outcome::Accepted,
                    Err(refusal) => Outcome::Refused(refusal),
                };
                Acknowledgement { sequence, outcome }
            }
        };
        info!("{=u64:us}: command {=u16}: {}", now_us, answer.sequence, answer.outcome);
        self.statics.line.acknowledge(now_us, &answer);
        true
    }

    fn carry_out(&mut self, now_us: u64, command: &Command, authentic: bool) -> Result<(), CommandRefusal> {
        let Statics { probe, surveyor, burst, line, commands, memory } = &mut self.statics;
        let board = &mut self.board;
        // The gate has checked every field.
        let bounds = |_| CommandRefusal::Malformed;
        match command {
            Command::SelfTest => {
                let storage_holds = memory.as_mut().map(|memory| memory.verify()).transpose()?;
                commands.self_test.clear();
                // Just emptied, so there is room.
                let _ =
                    commands.self_test.push(SelfTest::of(commands.faults.found(), &commands.mounting, storage_holds));
            }
            Command::ConfigureStream(stream) => line.configure(stream).map_err(bounds)?,
            Command::StartRecording { for_s } => {
                commands.recording.start(now_us, *for_s, authentic);
                line.record(true);
                line.want_boot();
            }
            Command::StopRecording => {
                commands.recording.stop(authentic);
                line.record(commands.recording.is_on(now_us));
            }
            Command::Configure(config) => self.configure(config).map_err(bounds)?,
            Command::ConfigureSurvey(survey) => {
                surveyor.configure(&probe.config().earth, survey).map_err(bounds)?;
            }
            Command::Provision { record, only_check } => self.provision(record, *only_check)?,
            Command::Erase { what: Erasure::Models } => {
                let memory = memory.as_mut().ok_or(CommandRefusal::NothingThere)?;
                memory.erase(probe.config(), &mut || board.feed_watchdog()).map_err(refusal)?;
            }
            Command::Erase { what: Erasure::Settings } => {
                memory.as_mut().ok_or(CommandRefusal::NothingThere)?.forget_commands()?;
            }
            Command::RollBackModel { to: EarlierModel::Factory } => {
                if let Some(memory) = memory {
                    memory.retire(probe.config()).map_err(refusal)?;
                }
                probe.restart(None).map_err(|_| CommandRefusal::NotSupported)?;
                self.restarted();
            }
            Command::RollBackModel { to: EarlierModel::Previous } => {
                memory.as_mut().ok_or(CommandRefusal::NothingThere)?.roll_back(probe)?;
                self.restarted();
            }
            Command::AcceptModel { window_end_us } => {
                if memory.as_mut().ok_or(CommandRefusal::NothingThere)?.accept(probe, *window_end_us)? {
                    self.restarted();
                }
            }
            Command::BeginUpdate { number, length, digest } => {
                update::begin(&mut self.board, &Image { number: *number, length: *length, digest: *digest })?;
            }
            Command::FinishUpdate => update::finish(&mut self.board)?,
            Command::Restart => self.update.restart(&mut self.board, now_us)?,
            Command::SendVibration => {
                line.dose();
                burst.send();
            }
            Command::StationarySurvey { .. } => {
                // Every stop gives a survey without a command; a survey that is over is sent again.
                if surveyor.state() == StationaryState::Latched {
                    line.survey_again();
                }
            }
        }
        Ok(())
    }

    /// Starts afresh with another configuration.
    pub(super) fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        let Statics { probe, surveyor, memory, .. } = &mut self.statics;
        probe.configure(config)?;
        surveyor.configure(&config.earth, &config.survey)?;
        if let Some(memory) = memory {
            memory.configured(config);
        }
        self.restarted();
        Ok(())
    }
}
