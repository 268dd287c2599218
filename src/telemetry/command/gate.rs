use super::{
    Acknowledgement, Command, CommandRefusal, CounterStore, FieldName, Key, Outcome, authentication::Authenticated,
};
use crate::{
    config::ConfigError,
    telemetry::{Frame, Kind},
};

/// The counter of a command may be this far ahead of the latest: a mistake cannot use them all up.
pub const MAX_COUNTER_STEP: u64 = 1 << 32;

/// What the gate has to know of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Situation {
    /// The probe's time, microseconds.
    pub now_us: u64,
    /// Whether the tool is drilling, or moves at all where that cannot be told.
    pub drilling: bool,
}

/// What is to be done with a frame from the host.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[expect(clippy::large_enum_variant, reason = "nothing here can be boxed, and it lives only until it is looked at")]
pub enum Judgement {
    /// Carry it out, then acknowledge it under this sequence number.
    CarryOut {
        /// Sequence number of its frame.
        sequence: u16,
        /// The command.
        command: Command,
    },
    /// Send this, and do nothing.
    Refuse(Acknowledgement),
}

/// How many commands came. Full counters stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CommandCounters {
    /// Let through.
    pub accepted: u32,
    /// Refused.
    pub refused: u32,
}

/// Decides what of a host's frames is carried out. It does nothing itself but store the counter.
#[derive(Clone, Debug, Default)]
pub struct CommandGate {
    key: Option<Key>,
    counters: CommandCounters,
}

impl CommandGate {
    /// A gate with the probe's key; `None`: no key is provisioned, and nothing that changes calibration passes. There is no other key.
    #[must_use]
    pub const fn new(key: Option<Key>) -> Self {
        Self { key, counters: CommandCounters { accepted: 0, refused: 0 } }
    }

    /// How many commands came.
    #[must_use]
    pub const fn counters(&self) -> CommandCounters {
        self.counters
    }

    /// Judges a frame whose check was right.
    ///
    /// An authentic command with a new counter uses the counter up, whatever becomes of it then: one that was refused while drilling and
    /// listened to cannot be played back in the next pause. The counter is stored before this returns, so before anything is done.
    pub fn judge<S: CounterStore>(&mut self, frame: &Frame<'_>, situation: Situation, store: &mut S) -> Judgement {
        match self.passed(frame, situation, store) {
            Ok(command) => {
                self.counters.accepted = self.counters.accepted.saturating_add(1);
                Judgement::CarryOut { sequence: frame.sequence, command }
            }
            Err(refusal) => {
                self.counters.refused = self.counters.refused.saturating_add(1);
                Judgement::Refuse(Acknowledgement { sequence: frame.sequence, outcome: Outcome::Refused(refusal) })
            }
        }
    }

    fn passed<S: CounterStore>(
        &self,
        frame: &Frame<'_>,
        situation: Situation,
        store: &mut S,
    ) -> Result<Command, CommandRefusal> {
        let (bytes, authentic) = match Kind::of_number(frame.kind) {
            Some(Kind::Command) => (frame.payload, false),
            Some(Kind::AuthenticatedCommand) => (self.authentic(frame.payload, store)?, true),
            _ => return Err(CommandRefusal::Malformed),
        };
        let Ok((command, [])) = postcard::take_from_bytes::<Command>(bytes) else {
            return Err(CommandRefusal::Malformed);
        };
        if command.changes_calibration() && !authentic {
            let no_key = self.key.is_none();
            return Err(if no_key { CommandRefusal::NoKey } else { CommandRefusal::NotAuthenticated });
        }
        command.check(situation.now_us).map_err(out_of_bounds)?;
        if command.needs_a_pause() && situation.drilling {
            return Err(CommandRefusal::WhileDrilling);
        }
        Ok(command)
    }

    /// The command's bytes, once their authenticity is shown and their counter used up.
    fn authentic<'a, S: CounterStore>(&self, payload: &'a [u8], store: &mut S) -> Result<&'a [u8], CommandRefusal> {
        let key = self.key.as_ref().ok_or(CommandRefusal::NoKey)?;
        let parts = Authenticated::split(payload).ok_or(CommandRefusal::Malformed)?;
        let (counter, bytes) = parts.verify(key).ok_or(CommandRefusal::Forged)?;
        let latest = store.read().map_err(|_| CommandRefusal::CounterNotStored)?;
        if counter <= latest {
            return Err(CommandRefusal::Replayed { latest });
        }
        if counter - latest > MAX_COUNTER_STEP {
            return Err(CommandRefusal::CounterTooFar { latest });
        }
        store.store(counter).map_err(|_| CommandRefusal::CounterNotStored)?;
        Ok(bytes)
    }
}

fn out_of_bounds(error: ConfigError) -> CommandRefusal {
    let mut field = FieldName::new();
    for character in error.field.chars() {
        if field.push(character).is_err() {
            break;
        }
    }
    CommandRefusal::OutOfBounds { field }
}
