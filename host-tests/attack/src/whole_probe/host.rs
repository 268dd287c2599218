//! Who is at the other end of the line: the owner, and who would like to be. Hears the probe and judges what it says.

use super::tally::{Tally, Violation};
use meerkat_mwd::{
    Config,
    application::Settings,
    telemetry::{
        Acknowledgement, Command, CommandRefusal, EarlierModel, Erasure, FrameDecoder, Key, Kind, MAX_DECODED,
        MAX_PAYLOAD, Message, Outcome, ProbeId, StreamConfig, authenticate,
    },
};
use std::collections::VecDeque;
use testbed::command_frame::{frame_of, framed};
use testbed::simulate::Random;

/// The probe, and another with the same key.
pub const PROBE: ProbeId = ProbeId(*b"under attack");
const OTHER: ProbeId = ProbeId(*b"some other 1");
/// The owner's key, and one that somebody else has.
pub const KEY: [u8; 32] = *b"an owner's key for attacks only.";
const FALSE_KEY: [u8; 32] = *b"a key that somebody else drew up";
/// Time of a byte on the line, microseconds.
const BYTE_US: u64 = 87;

/// Seed of the search in the configuration that the owner's first command may send, above the factory's.
const OWNERS_SEED: u64 = 1_000;

/// Who sent a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sender {
    Owner { counter: u64 },
    Keyless,
    Forger,
}

/// A command that was sent.
struct Sent {
    sender: Sender,
    command: Command,
    bytes: Vec<u8>,
    accepted: bool,
    /// For how long the tool had been moving when the probe took the last byte, seconds; `None` before.
    drilling_for_s: Option<f64>,
}

/// The host's side of the line.
pub struct Host {
    random: Random,
    config: Config,
    stream: StreamConfig,
    decoder: FrameDecoder<MAX_DECODED>,
    sent: Vec<Sent>,
    /// Sequence number of the first frame that is sent; they wrap.
    first_sequence: u16,
    counter: u64,
    /// Highest counter of which the probe said that it carried its command out.
    highest: u64,
    /// Bytes on their way, and when they arrive; the last of a command with its place among those sent.
    pub outgoing: VecDeque<(u64, u8, Option<usize>)>,
    /// End of the last window that the probe reported.
    pub window_end_us: u64,
    /// The command, by its place, that set what is known to be in force; `None`: the factory's.
    set_by: Option<usize>,
    /// True if the flash was damaged since: an earlier command, or the factory's, may be in force again.
    spoilt: bool,
}

impl Host {
    pub fn new(random: Random, settings: &Settings, first_sequence: u16, counter: u64) -> Self {
        let Settings { config, stream, .. } = settings;
        Self {
            random,
            config: *config,
            stream: *stream,
            decoder: FrameDecoder::new(),
            sent: Vec::new(),
            first_sequence,
            counter,
            highest: counter,
            outgoing: VecDeque::new(),
            window_end_us: 0,
            set_by: None,
            spoilt: false,
        }
    }

    fn put(&mut self, now_us: u64, bytes: &[u8], of: Option<usize>) {
        let mut at_us = self.outgoing.back().map_or(now_us, |(at_us, ..)| now_us.max(*at_us));
        for (k, byte) in bytes.iter().enumerate() {
            at_us += BYTE_US;
            self.outgoing.push_back((at_us, *byte, of.filter(|_| k + 1 == bytes.len())));
        }
    }

    /// Number of frames that were sent.
    pub const fn frames(&self) -> u64 {
        self.sent.len() as u64
    }

    /// The probe took the last byte of a command; the tool had been moving for so long.
    pub fn taken(&mut self, command: usize, drilling_for_s: f64) {
        if let Some(sent) = self.sent.get_mut(command) {
            sent.drilling_for_s = Some(drilling_for_s);
        }
    }

    fn send(&mut self, now_us: u64, sender: Sender, command: Command, bytes: Vec<u8>) {
        self.put(now_us, &bytes, Some(self.sent.len()));
        self.sent.push(Sent { sender, command, bytes, accepted: false, drilling_for_s: None });
    }

    /// Sequence number of the next frame: its place among all that were sent.
    const fn sequence(&self) -> u16 {
        self.first_sequence.wrapping_add(self.sent.len() as u16)
    }

    /// Place of the latest frame that was sent with this number.
    fn place_of(&self, sequence: u16) -> Option<usize> {
        // From 0 to 65,535 frames before the last one.
        let before = self.sequence().wrapping_sub(1).wrapping_sub(sequence);
        self.sent.len().checked_sub(1 + usize::from(before))
    }

    fn signed(&mut self, key: &[u8; 32], probe: ProbeId, counter: u64, command: &Command) -> anyhow::Result<Vec<u8>> {
        let key = Key::new(key, probe).ok_or_else(|| anyhow::anyhow!("this is no key"))?;
        let mut payload = [0; MAX_PAYLOAD];
        framed(Kind::AuthenticatedCommand, self.sequence(), authenticate(&key, counter, command, &mut payload)?)
    }

    /// Something that an owner may want.
    fn wish(&mut self) -> Command {
        match self.random.between(0.0, 10.0) as usize {
            0 => Command::Erase { what: Erasure::Models },
            1 => Command::Erase { what: Erasure::Settings },
            // Its place tells which it is.
            2 => Command::Configure(Config { seed: OWNERS_SEED + self.sent.len() as u64, ..self.config }),
            3 => Command::ConfigureSurvey(self.config.survey),
            4 => Command::ConfigureStream(self.stream),
            5 | 6 => Command::AcceptModel { window_end_us: self.window_end_us },
            7 => Command::RollBackModel { to: EarlierModel::Previous },
            8 => Command::RollBackModel { to: EarlierModel::Factory },
            _ => Command::StartRecording { for_s: Some(3) },
        }
    }

    /// The owner asks for something.
    pub fn owner(&mut self, now_us: u64) -> anyhow::Result<()> {
        let command = self.wish();
        self.owner_wants(now_us, command)
    }

    fn owner_wants(&mut self, now_us: u64, command: Command) -> anyhow::Result<()> {
        self.counter += 1 + self.random.between(0.0, 3.0) as u64;
        let counter = self.counter;
        let bytes = self.signed(&KEY, PROBE, counter, &command)?;
        self.send(now_us, Sender::Owner { counter }, command, bytes);
        Ok(())
    }

    /// Somebody signs with another key, or what was meant for another probe is sent to this one.
    pub fn forger(&mut self, now_us: u64, other_probe: bool) -> anyhow::Result<()> {
        let command = self.wish();
        let (key, probe) = if other_probe { (KEY, OTHER) } else { (FALSE_KEY, PROBE) };
        let bytes = self.signed(&key, probe, self.counter + 1, &command)?;
        self.send(now_us, Sender::Forger, command, bytes);
        Ok(())
    }

    /// Commands without the key.
    pub fn flood(&mut self, now_us: u64, commands: u8) -> anyhow::Result<()> {
        for _ in 0..commands {
            let command = match self.random.between(0.0, 4.0) as usize {
                0 => Command::SelfTest,
                1 => Command::StationarySurvey { within_s: 60 },
                2 => Command::Erase { what: Erasure::Models },
                _ => Command::StartRecording { for_s: Some(1) },
            };
            let bytes = frame_of(&command, self.sequence())?;
            self.send(now_us, Sender::Keyless, command, bytes);
        }
        Ok(())
    }

    /// Bytes that are no frames.
    pub fn garbage(&mut self, now_us: u64, bytes: u16) {
        let bytes: Vec<u8> = (0..bytes).map(|_| self.random.between(0.0, 256.0) as u8).collect();
        self.put(now_us, &bytes, None);
    }

    /// Sends one of the owner's latest commands again.
    pub fn replay(&mut self, now_us: u64) {
        let owners: Vec<usize> = (0..self.sent.len())
            .rev()
            .filter(|k| matches!(self.sent[*k].sender, Sender::Owner { .. }))
            .take(3)
            .collect();
        let chosen = self.random.index(owners.len());
        if let Some((k, bytes)) = owners.get(chosen).map(|k| (*k, self.sent[*k].bytes.clone())) {
            self.put(now_us, &bytes, Some(k));
        }
    }

    /// The counter that the probe has read from its flash at a start.
    pub fn counter_is(&self, stored: u64, tally: &mut Tally) {
        tally.checked(Violation::CounterFell);
        if stored < self.highest {
            tally.violated(Violation::CounterFell, || format!("{stored} at a start after {}", self.highest));
        }
    }

    /// The flash was damaged.
    pub const fn flash_is_spoilt(&mut self) {
        self.spoilt = true;
    }

    /// Returns true if a configuration that flies is what the owner has set last. Later commands may have been carried
    /// out without an answer that was heard.
    pub fn has_set(&mut self, config: &Config) -> bool {
        let is_set_by = |host: &Self, place: Option<usize>| match place.map(|place| &host.sent[place]) {
            None => config.seed == host.config.seed,
            Some(Sent { sender: Sender::Owner { .. }, command: Command::Configure(sent), .. }) => {
                config.seed == sent.seed
            }
            Some(Sent { sender: Sender::Owner { .. }, command, .. }) => {
                sets(command) && config.seed == host.config.seed
            }
            Some(_) => false,
        };
        let from = self.set_by.filter(|_| !self.spoilt).map_or(0, |place| place + 1);
        let known = self.set_by.filter(|_| !self.spoilt);
        if is_set_by(self, known) {
            return true;
        }
        let later = (from..self.sent.len()).find(|place| is_set_by(self, Some(*place)));
        if later.is_some() {
            self.set_by = later;
        }
        later.is_some()
    }

    /// A byte arrives from the probe.
    pub fn hear(&mut self, byte: u8) -> Option<Message> {
        let frame = self.decoder.push(byte)?;
        Message::decode(&frame).ok()
    }

    /// Judges an answer.
    pub fn answered(&mut self, answer: &Acknowledgement, tally: &mut Tally) {
        let place = self.place_of(answer.sequence);
        let Some(sent) = place.and_then(|place| self.sent.get_mut(place)) else { return };
        let accepted = answer.outcome == Outcome::Accepted;
        match (sent.sender, &answer.outcome) {
            (Sender::Forger, Outcome::Accepted) => tally.violated(Violation::Forged, || format!("{:?}", sent.command)),
            (Sender::Keyless, Outcome::Accepted) if sent.command.needs_the_key() => {
                tally.violated(Violation::Forged, || format!("{:?}", sent.command))
            }
            (Sender::Owner { counter }, Outcome::Accepted) => {
                if sent.accepted || counter <= self.highest {
                    tally.violated(Violation::Replayed, || format!("counter {counter}, {:?}", sent.command));
                }
                sent.accepted = true;
                self.highest = self.highest.max(counter);
                if sets(&sent.command) {
                    (self.set_by, self.spoilt) = (place, false);
                }
            }
            (_, Outcome::Refused(CommandRefusal::Replayed { latest } | CommandRefusal::CounterTooFar { latest })) => {
                tally.checked(Violation::CounterFell);
                if *latest < self.highest {
                    tally.violated(Violation::CounterFell, || format!("{latest} after {}", self.highest));
                }
            }
            _ => {}
        }
        tally.checked(Violation::Replayed);
        tally.checked(Violation::Forged);
        if let Some(drilling_for_s) = sent.drilling_for_s {
            tally.checked(Violation::ChangedWhileDrilling);
            if accepted && sent.command.needs_a_pause() && drilling_for_s > super::EVIDENCE_S {
                tally.violated(Violation::ChangedWhileDrilling, || {
                    format!("{:?} after {drilling_for_s:.2} s", sent.command)
                });
            }
        }
    }
}

/// Returns true if a command sets what holds after a start.
const fn sets(command: &Command) -> bool {
    matches!(command, Command::Configure(_) | Command::Erase { what: Erasure::Settings })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_answer_is_of_the_latest_command_with_its_number() {
        let settings =
            Settings { config: Config::default(), stream: StreamConfig::default(), recording: false, key: None };
        let mut host = Host::new(Random::new(1), &settings, 65_530, 0);
        assert_eq!(host.place_of(65_530), None);
        let mut numbers = Vec::new();
        for sent in 1..70_000_usize {
            numbers.push(host.sequence());
            host.send(0, Sender::Keyless, Command::SelfTest, Vec::new());
            assert_eq!(host.place_of(host.sequence()), sent.checked_sub(65_536));
            let oldest = sent.saturating_sub(65_536);
            for place in [oldest, oldest.midpoint(sent), sent - 1] {
                assert_eq!(host.place_of(numbers[place]), Some(place));
            }
        }
        assert_eq!(numbers[..8], [65_530, 65_531, 65_532, 65_533, 65_534, 65_535, 0, 1]);
    }
}
