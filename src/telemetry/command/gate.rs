//! Gate for commands: decides which frames of a host are carried out. It checks authenticity, counter, bounds, drilling
//! and the allowance of hosts without the key, in this order (docs/security.md).

use super::{
    Acknowledgement, Command, CommandRefusal, CounterStore, FieldName, Key, Outcome,
    allowance::{Allowance, Rate},
    authentication::Authenticated,
};
use crate::{
    config::ConfigError,
    telemetry::{Frame, Kind},
};

/// Largest step of a command's counter over the latest, so that one mistake cannot use up all counters.
pub const MAX_COUNTER_STEP: u64 = 1 << 32;

/// Answers to hosts without the key: eight at once, then four a second. The longest, with the name of a field, takes
/// 72 bytes of the line, the usual one 13: at most 3 % of 10,368 bytes a second, and a fifth of that for most.
const ANSWERS: Rate = Rate { interval_us: 250_000, at_once: 8 };

/// Reports that hosts without the key may ask for, such as the boot before a recording (530 bytes and more): four at
/// once, then one in two seconds.
const REPORTS: Rate = Rate { interval_us: 2_000_000, at_once: 4 };

/// Facts about the probe that the gate needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Situation {
    /// Time of the probe, microseconds.
    pub now_us: u64,
    /// True if the tool is drilling or, where drilling cannot be recognised, moves at all.
    pub drilling: bool,
}

/// Judgement of a frame from the host.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[expect(clippy::large_enum_variant, reason = "nothing here can be boxed, and it lives only until it is looked at")]
pub enum Judgement<'a> {
    /// The owner carries the command out, and then acknowledges it under this sequence number.
    CarryOut {
        /// Sequence number of its frame.
        sequence: u16,
        /// The command.
        command: Command,
        /// The command as it came, to be stored.
        bytes: &'a [u8],
        /// True if the sender has the key.
        authentic: bool,
    },
    /// Send this answer, and do nothing.
    Refuse(Acknowledgement),
    /// Send nothing: a host without the key asks too often.
    Ignore,
}

/// Counters of commands, which stop at their largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CommandCounters {
    /// Commands let through.
    pub accepted: u32,
    /// Commands refused, with or without an answer.
    pub refused: u32,
}

/// Decides which frames of a host are carried out. It does nothing itself but store the counter.
#[derive(Clone, Debug, Default)]
pub struct CommandGate {
    key: Option<Key>,
    counters: CommandCounters,
    answers: Allowance,
    reports: Allowance,
    /// Answers to parts of an image that are no progress: of their own, so that no other frame uses them up.
    parts: Allowance,
}

impl CommandGate {
    /// Makes a gate with the probe's key. With `None` no key is provisioned, and commands that need one are refused.
    #[must_use]
    pub const fn new(key: Option<Key>) -> Self {
        Self {
            key,
            counters: CommandCounters { accepted: 0, refused: 0 },
            answers: Allowance::new(),
            reports: Allowance::new(),
            parts: Allowance::new(),
        }
    }

    /// Returns the counters of commands.
    #[must_use]
    pub const fn counters(&self) -> CommandCounters {
        self.counters
    }

    /// Returns true if a part of an image that is no progress may be answered, and counts the answer.
    pub fn may_answer_part(&mut self, now_us: u64) -> bool {
        self.parts.take(&ANSWERS, now_us)
    }

    /// Judges a frame whose CRC was right.
    ///
    /// An authentic command with a new counter uses the counter up, even if it is then refused: a command that was
    /// refused while drilling cannot be recorded and played back in the next pause. The counter is stored before this
    /// returns, so before anything is done.
    ///
    /// All hosts without the key together get a few answers a second, so that none can keep the probe's results from
    /// the line, or lock out a host with the key.
    pub fn judge<'a, S: CounterStore>(
        &mut self,
        frame: &Frame<'a>,
        situation: Situation,
        store: &mut S,
    ) -> Judgement<'a> {
        let bytes = match Kind::of_number(frame.kind) {
            Some(Kind::Command) => Ok((frame.payload, false)),
            Some(Kind::AuthenticatedCommand) => self.authentic(frame.payload, store).map(|bytes| (bytes, true)),
            _ => Err(CommandRefusal::Malformed),
        };
        let is_owners = matches!(bytes, Ok((_, true)));
        if !is_owners && !self.answers.take(&ANSWERS, situation.now_us) {
            self.counters.refused = self.counters.refused.saturating_add(1);
            return Judgement::Ignore;
        }
        let passed = |(bytes, authentic)| Ok((self.passed(bytes, authentic, situation)?, bytes, authentic));
        match bytes.and_then(passed) {
            Ok((command, bytes, authentic)) => {
                self.counters.accepted = self.counters.accepted.saturating_add(1);
                Judgement::CarryOut { sequence: frame.sequence, command, bytes, authentic }
            }
            Err(refusal) => {
                self.counters.refused = self.counters.refused.saturating_add(1);
                Judgement::Refuse(Acknowledgement { sequence: frame.sequence, outcome: Outcome::Refused(refusal) })
            }
        }
    }

    fn passed(&mut self, bytes: &[u8], authentic: bool, situation: Situation) -> Result<Command, CommandRefusal> {
        let command = Command::of_bytes(bytes).ok_or(CommandRefusal::Malformed)?;
        if command.needs_the_key() && !authentic {
            let no_key = self.key.is_none();
            return Err(if no_key { CommandRefusal::NoKey } else { CommandRefusal::NotAuthenticated });
        }
        command.check(situation.now_us).map_err(out_of_bounds)?;
        if command.needs_a_pause() && situation.drilling {
            return Err(CommandRefusal::WhileDrilling);
        }
        if !authentic && command.asks_for_a_report() && !self.reports.take(&REPORTS, situation.now_us) {
            return Err(CommandRefusal::Busy);
        }
        Ok(command)
    }

    /// Returns the command's bytes once their authenticity is shown and their counter used up.
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
