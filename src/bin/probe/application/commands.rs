//! What a host asks, and what becomes of it.

use super::{Application, Pipeline, board::Board, memory::refusal};
use heapless::Vec;
use meerkat_mwd::{
    survey::{StationaryState, SurveyNews},
    telemetry::{
        Acknowledgement, Command, CommandCounters, CommandGate, CommandRefusal, CounterStore, EarlierModel, Erasure,
        FrameDecoder, Judgement, Key, LinkCounters, Outcome, SelfTest, Situation,
    },
};

/// Longest frame that is taken, without COBS: more than a configuration with its authentication.
const LONGEST: usize = 640;

/// Bytes looked at in one round of the loop.
const BYTES_A_ROUND: u32 = 64;

/// The way in. All zero at first, so that a `static` of it costs no flash.
pub struct Commands {
    decoder: FrameDecoder<LONGEST>,
    gate: CommandGate,
    /// What is to be reported at once.
    pub self_test: Vec<SelfTest, 1>,
    /// When the recording ends, microseconds; 0: when it is stopped.
    recording_until_us: u64,
}

impl Commands {
    pub const fn new() -> Self {
        Self {
            decoder: FrameDecoder::new(),
            gate: CommandGate::new(None),
            self_test: Vec::new(),
            recording_until_us: 0,
        }
    }

    /// With the key that was provisioned; without one, no command that changes calibration is carried out.
    pub fn provision(&mut self, key: Option<Key>) {
        self.gate = CommandGate::new(key);
    }

    pub const fn link(&self) -> LinkCounters {
        self.decoder.counters()
    }

    pub const fn counters(&self) -> CommandCounters {
        self.gate.counters()
    }
}

/// A probe without a memory for the counter: no authenticated command is carried out.
pub struct NoCounter;

impl CounterStore for NoCounter {
    type Error = ();

    fn read(&mut self) -> Result<u64, ()> {
        Err(())
    }

    fn store(&mut self, _counter: u64) -> Result<(), ()> {
        Err(())
    }
}

impl<B: Board> Application<B> {
    /// Looks at what has come in; carries out one command at most.
    pub(super) fn receive(&mut self, now_us: u64) {
        let commands = &mut *self.pipeline.commands;
        if commands.recording_until_us != 0 && now_us >= commands.recording_until_us {
            commands.recording_until_us = 0;
            self.pipeline.line.record(false);
        }
        for _ in 0..BYTES_A_ROUND {
            let Some(byte) = self.board.receive() else { return };
            if self.take(now_us, byte) {
                return;
            }
        }
    }

    /// Whether the byte ended a frame.
    #[inline(never)]
    fn take(&mut self, now_us: u64, byte: u8) -> bool {
        // Not known to stand still: then it may be drilling.
        let drilling = self.pipeline.surveyor.state() == StationaryState::Moving;
        let Pipeline { commands, memory, .. } = &mut self.pipeline;
        let Commands { decoder, gate, .. } = &mut **commands;
        let Some(frame) = decoder.push(byte) else { return false };
        let situation = Situation { now_us, drilling };
        let judgement = match memory {
            Some(memory) => gate.judge(&frame, situation, *memory),
            None => gate.judge(&frame, situation, &mut NoCounter),
        };
        let answer = match judgement {
            Judgement::Refuse(answer) => answer,
            Judgement::CarryOut { sequence, command } => {
                let outcome = match self.carry_out(now_us, &command) {
                    Ok(()) => Outcome::Accepted,
                    Err(refusal) => Outcome::Refused(refusal),
                };
                Acknowledgement { sequence, outcome }
            }
        };
        defmt::info!("{=u64:us}: command {=u16}: {}", now_us, answer.sequence, answer.outcome);
        self.pipeline.line.acknowledge(now_us, &answer);
        true
    }

    fn carry_out(&mut self, now_us: u64, command: &Command) -> Result<(), CommandRefusal> {
        let Pipeline { probe, surveyor, line, commands, memory, .. } = &mut self.pipeline;
        let board = &mut self.board;
        // The gate has checked every field.
        let bounds = |_| CommandRefusal::Malformed;
        match command {
            Command::SelfTest => {
                let storage_holds = memory.as_mut().map(|memory| memory.verify());
                commands.self_test.clear();
                // Just emptied, so there is room.
                let _ = commands.self_test.push(SelfTest { sensors: line.sensors_at_fault(), storage_holds });
            }
            Command::ConfigureStream(stream) => line.configure(stream).map_err(bounds)?,
            Command::StartRecording { for_s } => {
                commands.recording_until_us = for_s.map_or(0, |s| now_us.saturating_add(u64::from(s) * 1_000_000));
                line.record(true);
                self.report_boot(now_us);
            }
            Command::StopRecording => line.record(false),
            Command::Configure(config) => {
                probe.configure(config).map_err(bounds)?;
                let survey = surveyor.config().copied().unwrap_or_default();
                surveyor.configure(&config.earth, &survey).map_err(bounds)?;
                if let Some(memory) = memory {
                    memory.configured(config);
                }
                self.restarted(now_us);
            }
            Command::ConfigureSurvey(survey) => {
                surveyor.configure(&probe.config().earth, survey).map_err(bounds)?;
            }
            Command::Erase { what: Erasure::Models } => {
                let memory = memory.as_mut().ok_or(CommandRefusal::NothingThere)?;
                memory.erase(probe.config(), || board.feed_watchdog()).map_err(refusal)?;
            }
            Command::RollBackModel { to: EarlierModel::Factory } => {
                if let Some(memory) = memory {
                    memory.retire(probe.config()).map_err(refusal)?;
                }
                probe.restart(None).map_err(|_| CommandRefusal::NotSupported)?;
                self.restarted(now_us);
            }
            Command::RollBackModel { to: EarlierModel::Previous } => {
                memory.as_mut().ok_or(CommandRefusal::NothingThere)?.roll_back(probe)?;
                self.restarted(now_us);
            }
            Command::AcceptModel { window_end_us } => {
                if memory.as_mut().ok_or(CommandRefusal::NothingThere)?.accept(probe, *window_end_us)? {
                    self.restarted(now_us);
                }
            }
            Command::StationarySurvey { .. } => {
                // Every stop gives a survey by itself; one that is over is sent again.
                if surveyor.state() == StationaryState::Latched {
                    line.surveys(SurveyNews::STATIONARY);
                }
            }
            _ => return Err(CommandRefusal::NotSupported),
        }
        Ok(())
    }
}
