//! What the gate lets through.

use crate::flown::{self, Decoder};
use meerkat_mwd::{
    Config,
    config::SurveyConfig,
    telemetry::{
        Acknowledgement, Command, CommandGate, CommandRefusal, CounterStore, EarlierModel, Erasure, Frame, Judgement,
        Key, Kind, MAX_COUNTER_STEP, MAX_FRAME, MAX_PAYLOAD, Outcome, Situation, StreamConfig, authenticate,
        encode_frame, encode_payload,
    },
};
use proptest::prelude::*;

const AT_REST: Situation = Situation { now_us: 60_000_000, drilling: false };
const DRILLING: Situation = Situation { drilling: true, ..AT_REST };

pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";

pub fn key() -> Key {
    Key::of_bytes(&KEY).unwrap()
}

/// Remembers every counter that was stored, and can fail.
#[derive(Default)]
pub struct Counters {
    pub stored: Vec<u64>,
    pub broken: bool,
}

impl CounterStore for Counters {
    type Error = ();

    fn read(&mut self) -> Result<u64, ()> {
        Ok(self.stored.last().copied().unwrap_or(0))
    }

    fn store(&mut self, counter: u64) -> Result<(), ()> {
        if self.broken {
            return Err(());
        }
        self.stored.push(counter);
        Ok(())
    }
}

fn harmless() -> Vec<Command> {
    vec![
        Command::SelfTest,
        Command::ConfigureStream(StreamConfig::default()),
        Command::StartRecording { for_s: Some(60) },
        Command::StartRecording { for_s: None },
        Command::StopRecording,
        Command::StationarySurvey { within_s: 300 },
    ]
}

fn calibrating() -> Vec<Command> {
    vec![
        Command::Configure(Config::default()),
        Command::ConfigureSurvey(SurveyConfig::default()),
        Command::AcceptModel { window_end_us: 50_000_000 },
        Command::RollBackModel { to: EarlierModel::Previous },
        Command::RollBackModel { to: EarlierModel::Factory },
        Command::Erase { what: Erasure::Models },
    ]
}

fn plain(command: &Command) -> Vec<u8> {
    let mut buffer = [0; MAX_PAYLOAD];
    encode_payload(command, &mut buffer).unwrap().to_vec()
}

fn authentic(key: &Key, counter: u64, command: &Command) -> Vec<u8> {
    let mut buffer = [0; MAX_PAYLOAD];
    authenticate(key, counter, command, &mut buffer).unwrap().to_vec()
}

/// Every command as a host sends it, one frame after another.
pub fn every_command_on_line() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut buffer = [0; MAX_FRAME];
    let mut send = |sequence: usize, kind, payload: &[u8]| {
        bytes.extend_from_slice(encode_frame(kind, sequence as u16, payload, &mut buffer).unwrap());
    };
    for (sequence, command) in harmless().iter().enumerate() {
        send(sequence, Kind::Command, &plain(command));
    }
    for (sequence, command) in calibrating().iter().enumerate() {
        send(100 + sequence, Kind::AuthenticatedCommand, &authentic(&key(), 1 + sequence as u64, command));
    }
    bytes
}

/// What a gate makes of a payload.
fn judge(
    gate: &mut CommandGate,
    kind: Kind,
    payload: &[u8],
    situation: Situation,
    store: &mut Counters,
) -> Result<Command, CommandRefusal> {
    let frame = Frame { kind: kind.number(), sequence: 9, payload };
    match gate.judge(&frame, situation, store) {
        Judgement::CarryOut { sequence: 9, command } => Ok(command),
        Judgement::Refuse(Acknowledgement { sequence: 9, outcome: Outcome::Refused(reason) }) => Err(reason),
        other => panic!("{other:?}"),
    }
}

#[test]
fn harmless_commands_need_no_key_and_only_a_self_test_needs_a_pause() {
    let (mut gate, mut store) = (CommandGate::new(None), Counters::default());
    for command in harmless() {
        assert_eq!(judge(&mut gate, Kind::Command, &plain(&command), AT_REST, &mut store), Ok(command));
        let while_drilling = judge(&mut gate, Kind::Command, &plain(&command), DRILLING, &mut store);
        let expected = if command == Command::SelfTest { Err(CommandRefusal::WhileDrilling) } else { Ok(command) };
        assert_eq!(while_drilling, expected);
    }
    assert_eq!((gate.counters().accepted, gate.counters().refused), (11, 1));
    assert!(store.stored.is_empty());
}

#[test]
fn without_a_key_no_calibration_is_changed_by_anybody() {
    let (mut gate, mut store) = (CommandGate::new(None), Counters::default());
    for command in calibrating() {
        let no_key = Err(CommandRefusal::NoKey);
        assert_eq!(judge(&mut gate, Kind::Command, &plain(&command), AT_REST, &mut store), no_key);
        let signed = authentic(&key(), 1, &command);
        assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store), no_key);
    }
    // Memory that nobody wrote is no key.
    assert!(Key::of_bytes(&[0; 32]).is_none() && Key::of_bytes(&[255; 32]).is_none());
    assert_eq!(format!("{:?}", key()), "Key");
}

#[test]
fn an_authentic_command_passes_once_and_in_order_only() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    let mut counter = 0;
    for command in calibrating() {
        assert_eq!(
            judge(&mut gate, Kind::Command, &plain(&command), AT_REST, &mut store),
            Err(CommandRefusal::NotAuthenticated)
        );
        counter += 3;
        let signed = authentic(&key(), counter, &command);
        assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store), Ok(command));
        // The counter was stored before the gate said so.
        assert_eq!(store.stored.last(), Some(&counter));
        let replayed = Err(CommandRefusal::Replayed { latest: counter });
        assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store), replayed);
        let older = authentic(&key(), counter - 1, &command);
        assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &older, AT_REST, &mut store), replayed);
        // Nor after a loss of power, of which only the store knows nothing.
        let mut restarted = CommandGate::new(Some(key()));
        assert_eq!(judge(&mut restarted, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store), replayed);
    }
}

#[test]
fn what_was_refused_while_drilling_cannot_be_played_back_in_the_next_pause() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    for (index, command) in calibrating().iter().enumerate() {
        let latest = 1 + index as u64;
        let signed = authentic(&key(), latest, command);
        let at = |gate: &mut CommandGate, store: &mut Counters, situation| {
            judge(gate, Kind::AuthenticatedCommand, &signed, situation, store)
        };
        assert_eq!(at(&mut gate, &mut store, DRILLING), Err(CommandRefusal::WhileDrilling));
        assert_eq!(at(&mut gate, &mut store, AT_REST), Err(CommandRefusal::Replayed { latest }));
    }
}

#[test]
fn without_its_counter_stored_nothing_is_done() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    store.broken = true;
    let erase = Command::Erase { what: Erasure::Models };
    let signed = authentic(&key(), 1, &erase);
    let refused = judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store);
    assert_eq!(refused, Err(CommandRefusal::CounterNotStored));
    store.broken = false;
    assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store), Ok(erase));
}

/// Who can compute the frame's check but has no key: every bit of every authentic command, and a key that
/// differs in one bit.
#[test]
fn every_forgery_is_refused_and_uses_no_counter() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    for command in calibrating() {
        let signed = authentic(&key(), 5, &command);
        for bit in 0..8 * signed.len() {
            let mut forged = signed.clone();
            forged[bit / 8] ^= 1 << (bit % 8);
            let judged = judge(&mut gate, Kind::AuthenticatedCommand, &forged, AT_REST, &mut store);
            assert_eq!(judged, Err(CommandRefusal::Forged), "bit {bit}");
        }
        for length in 0..signed.len() {
            let judged = judge(&mut gate, Kind::AuthenticatedCommand, &signed[..length], AT_REST, &mut store);
            let reason = if length < 24 { CommandRefusal::Malformed } else { CommandRefusal::Forged };
            assert_eq!(judged, Err(reason));
        }
        for bit in 0..256 {
            let mut other = KEY;
            other[bit / 8] ^= 1 << (bit % 8);
            let forged = authentic(&Key::of_bytes(&other).unwrap(), 5, &command);
            let judged = judge(&mut gate, Kind::AuthenticatedCommand, &forged, AT_REST, &mut store);
            assert_eq!(judged, Err(CommandRefusal::Forged));
        }
    }
    assert!(store.stored.is_empty());
}

/// Python: `hashlib.blake2s(b"meerkat-mwd command v001" + (7).to_bytes(8, "little") + b"\x03",
/// key=bytes(range(32)), digest_size=16)`
#[test]
fn the_code_is_that_of_another_implementation() {
    let key = Key::of_bytes(&core::array::from_fn(|index| index as u8)).unwrap();
    let payload = authentic(&key, 7, &Command::StopRecording);
    let hex: String = payload[8..24].iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        (hex.as_str(), &payload[..8], &payload[24..]),
        ("2d8e7e53f7d1862ba7621783623bee9d", &7_u64.to_le_bytes()[..], &[3][..],)
    );
}

#[test]
fn a_counter_cannot_be_run_up_to_its_end() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    store.stored.push(10);
    let command = Command::RollBackModel { to: EarlierModel::Factory };
    for (counter, passes) in [(u64::MAX, false), (11 + MAX_COUNTER_STEP, false), (10 + MAX_COUNTER_STEP, true)] {
        let signed = authentic(&key(), counter, &command);
        let judged = judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store);
        assert_eq!(judged, if passes { Ok(command) } else { Err(CommandRefusal::CounterTooFar { latest: 10 }) });
    }
}

#[test]
fn every_number_has_its_bounds() {
    let config = |change: fn(&mut Config)| {
        let mut config = Config::default();
        change(&mut config);
        Command::Configure(config)
    };
    let stream = |change: fn(&mut StreamConfig)| {
        let mut config = StreamConfig::default();
        change(&mut config);
        Command::ConfigureStream(config)
    };
    let survey = SurveyConfig { toolface_offset_rad: f32::NAN, ..SurveyConfig::default() };
    let cases = [
        (Command::StartRecording { for_s: Some(0) }, "for_s"),
        (Command::StartRecording { for_s: Some(604_801) }, "for_s"),
        (Command::StationarySurvey { within_s: 0 }, "within_s"),
        (Command::StationarySurvey { within_s: 3_601 }, "within_s"),
        (Command::AcceptModel { window_end_us: AT_REST.now_us + 1 }, "window_end_us"),
        (stream(|c| c.bytes_per_s = 99), "stream.bytes_per_s"),
        (stream(|c| c.attitude_every = 10_001), "stream.attitude_every"),
        (stream(|c| c.max_age_us = 0), "stream.max_age_us"),
        (config(|c| c.gyro.p[1][1] = f32::INFINITY), "gyro"),
        (config(|c| c.earth.gravity_m_s2 = 3.7), "earth.gravity_m_s2"),
        (Command::ConfigureSurvey(survey), "survey.toolface_offset_rad"),
    ];
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    for (counter, (command, name)) in (1..).zip(cases) {
        let signed = authentic(&key(), counter, &command);
        match judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store) {
            Err(CommandRefusal::OutOfBounds { field }) => assert_eq!(field.as_str(), name),
            other => panic!("{name}: {other:?}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    #[test]
    fn whatever_bytes_come_are_a_command_or_refused(
        payload in prop::collection::vec(any::<u8>(), 0..80), kind in any::<u8>(), drilling: bool,
    ) {
        let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
        let frame = Frame { kind, sequence: 1, payload: &payload };
        let judged = gate.judge(&frame, Situation { now_us: 0, drilling }, &mut store);
        if let Judgement::CarryOut { command, .. } = judged {
            prop_assert!(!command.changes_calibration() && kind == Kind::Command.number());
            prop_assert_eq!(plain(&command), payload);
        }
        prop_assert!(store.stored.is_empty());
    }
}

#[test]
fn commands_pass_a_receiver_of_the_probes_size() {
    let frames = flown::frames(&mut Decoder::new(), &every_command_on_line());
    let longest = frames.iter().map(|(_, _, payload)| payload.len() + 7).max();
    println!("the longest command takes {longest:?} bytes of a receiver");
    assert_eq!(frames.len(), harmless().len() + calibrating().len());
}
