//! Commands that the gate lets through.

use crate::frames::{self, Decoder};
use meerkat_mwd::{
    Config,
    config::SurveyConfig,
    telemetry::{
        Acknowledgement, Command, CommandGate, CommandRefusal, CounterStore, EarlierModel, Erasure, Frame, Judgement,
        Key, Kind, MAX_COUNTER_STEP, MAX_FRAME, MAX_PAYLOAD, Outcome, ProbeId, Situation, StreamConfig, authenticate,
        encode_frame, encode_payload,
    },
};
use proptest::prelude::*;
use rand_core::{Rng, SeedableRng};
use std::cell::Cell;

const AT_REST: Situation = Situation { now_us: 60_000_000, drilling: false };
const DRILLING: Situation = Situation { drilling: true, ..AT_REST };

pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";
pub const PROBE: ProbeId = ProbeId(*b"played probe");

pub fn key() -> Key {
    Key::new(&KEY, PROBE).unwrap()
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

/// A quarter of a minute after the last call: who asks no oftener is always answered.
fn later_us() -> u64 {
    thread_local!(static NOW_US: Cell<u64> = const { Cell::new(60_000_000) });
    NOW_US.replace(NOW_US.get() + 15_000_000)
}

/// Decision of a gate about a payload: the command, or the reason for which it is refused.
fn judge(
    gate: &mut CommandGate,
    kind: Kind,
    payload: &[u8],
    situation: Situation,
    store: &mut Counters,
) -> Result<Command, CommandRefusal> {
    let frame = Frame { kind: kind.number(), sequence: 9, payload };
    match gate.judge(&frame, Situation { now_us: later_us(), ..situation }, store) {
        Judgement::CarryOut { sequence: 9, command, authentic, .. } => {
            assert_eq!(authentic, kind == Kind::AuthenticatedCommand);
            Ok(command)
        }
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
    assert_eq!((gate.counters().accepted, gate.counters().refused), (9, 1));
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
    assert!(Key::new(&[0; 32], PROBE).is_none() && Key::new(&[255; 32], PROBE).is_none());
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
            let forged = authentic(&Key::new(&other, PROBE).unwrap(), 5, &command);
            let judged = judge(&mut gate, Kind::AuthenticatedCommand, &forged, AT_REST, &mut store);
            assert_eq!(judged, Err(CommandRefusal::Forged));
        }
    }
    assert!(store.stored.is_empty());
}

/// Python: `hashlib.blake2s(b"meerkat-mwd command v002" + bytes(range(100, 112)) + (7).to_bytes(8, "little")
/// + b"\x03", key=bytes(range(32)), digest_size=16)`
#[test]
fn the_code_is_that_of_another_implementation() {
    let probe = ProbeId(core::array::from_fn(|index| 100 + index as u8));
    let key = Key::new(&core::array::from_fn(|index| index as u8), probe).unwrap();
    let payload = authentic(&key, 7, &Command::StopRecording);
    let hex: String = payload[8..24].iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        (hex.as_str(), &payload[..8], &payload[24..]),
        ("ae24a9481b933ad56d67605fa9f17899", &7_u64.to_le_bytes()[..], &[3][..],)
    );
}

/// Two probes that share a key: what was sent to one is nothing to the other.
#[test]
fn a_command_to_one_probe_is_none_to_another() {
    let other = Key::new(&KEY, ProbeId(*b"second probe")).unwrap();
    let (mut gate, mut store) = (CommandGate::new(Some(other)), Counters::default());
    for command in calibrating() {
        let signed = authentic(&key(), 1, &command);
        let judged = judge(&mut gate, Kind::AuthenticatedCommand, &signed, AT_REST, &mut store);
        assert_eq!(judged, Err(CommandRefusal::Forged));
    }
    assert!(store.stored.is_empty());
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
        (Command::AcceptModel { window_end_us: u64::MAX }, "window_end_us"),
        (stream(|c| c.bytes_per_s = 99), "stream.bytes_per_s"),
        (stream(|c| c.attitude_every = 10_001), "stream.attitude_every"),
        (stream(|c| c.max_age_us = 0), "stream.max_age_us"),
        (config(|c| c.gyro.p[1][1] = f32::INFINITY), "gyro"),
        (config(|c| (c.gyro.p[1][1], c.gyro.b_rad_s[1]) = (3e20, 3e20)), "gyro"),
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
            prop_assert!(!command.needs_the_key() && kind == Kind::Command.number());
            prop_assert_eq!(plain(&command), payload);
        }
        prop_assert!(store.stored.is_empty());
    }
}

#[test]
fn commands_pass_a_receiver_of_the_probes_size() {
    let frames = frames::frames(&mut Decoder::new(), &every_command_on_line());
    let longest = frames.iter().map(|(_, _, payload)| payload.len() + 7).max();
    println!("the longest command takes {longest:?} bytes of a receiver");
    assert_eq!(frames.len(), harmless().len() + calibrating().len());
}

/// Half a minute of an 11-byte command, a thousand a second: the host costs its own answers and no more.
#[test]
fn a_keyless_flood_is_answered_a_few_times_a_second_and_leaves_the_owner_alone() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    let flood = plain(&Command::StartRecording { for_s: None });
    let erase = Command::Erase { what: Erasure::Models };
    let (mut answered, mut carried_out, mut owners) = (0, 0, 0);
    for millisecond in 0..30_000 {
        let situation = Situation { now_us: millisecond * 1_000, drilling: false };
        let frame = Frame { kind: Kind::Command.number(), sequence: 9, payload: &flood };
        match gate.judge(&frame, situation, &mut store) {
            Judgement::CarryOut { .. } => (answered, carried_out) = (answered + 1, carried_out + 1),
            Judgement::Refuse(_) => answered += 1,
            _ => {}
        }
        if millisecond % 100 == 50 {
            let signed = authentic(&key(), 1 + millisecond, &erase);
            owners +=
                u32::from(judge(&mut gate, Kind::AuthenticatedCommand, &signed, situation, &mut store) == Ok(erase));
        }
    }
    println!("{answered} answers, {carried_out} boots, {owners} commands of the owner in 30 s");
    assert!(answered <= 8 + 30 * 4 && carried_out <= 4 + 30 / 2, "{answered} answers, {carried_out} boots");
    assert_eq!(owners, 300);
    // It can be asked again a moment later.
    let later = Situation { now_us: 40_000_000, drilling: false };
    assert!(judge(&mut gate, Kind::Command, &flood, later, &mut store).is_ok());
}

#[test]
fn what_a_stream_says_nobody_silences_without_the_key() {
    let (mut gate, mut store) = (CommandGate::new(Some(key())), Counters::default());
    let silence = Command::ConfigureStream(StreamConfig { attitude_every: 0, ..StreamConfig::default() });
    let judged = judge(&mut gate, Kind::Command, &plain(&silence), DRILLING, &mut store);
    assert_eq!(judged, Err(CommandRefusal::NotAuthenticated));
    let signed = authentic(&key(), 1, &silence);
    assert_eq!(judge(&mut gate, Kind::AuthenticatedCommand, &signed, DRILLING, &mut store), Ok(silence));
}

#[test]
fn bytes_that_nobody_drew_are_no_key() {
    let mut one = [0; 32];
    one[31] = 1;
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(1);
    for weak in [one, [0xA5; 32], core::array::from_fn(|i| (i % 4) as u8), *b"meerkatmeerkatmeerkatmeerkat1234"] {
        assert!(Key::new(&weak, PROBE).is_none(), "{weak:?}");
    }
    for _ in 0..100_000 {
        let mut drawn = [0; 32];
        rng.fill_bytes(&mut drawn);
        assert!(Key::new(&drawn, PROBE).is_some());
    }
}
