//! Hosts that speak to a probe's command gate, with its key and without.

use arbitrary::{Arbitrary, Unstructured};
use meerkat_mwd::telemetry::{
    Command, CommandGate, CounterStore, Frame, Judgement, Key, Kind, MAX_COUNTER_STEP, MAX_PAYLOAD, ProbeId, Situation,
    authenticate,
};

/// The key of the gate.
pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";
/// The probe of the gate.
pub const PROBE: ProbeId = ProbeId(*b"fuzzed probe");
/// A probe with the same key.
const OTHER_PROBE: ProbeId = ProbeId(*b"other probe.");

/// All that hosts say to a gate.
#[derive(Arbitrary, Debug)]
struct Exchange<'b> {
    has_key: bool,
    said: Vec<Said<'b>>,
}

/// One frame.
#[derive(Arbitrary, Debug)]
struct Said<'b> {
    drilling: bool,
    after_ms: u16,
    frame: Origin<'b>,
}

/// Who has made it. Nobody guesses a code, so that bytes alone would never show what is done with a signed command.
#[derive(Arbitrary, Debug)]
enum Origin<'b> {
    /// Somebody without the key.
    Anybody {
        kind: u8,
        #[arbitrary(with = sized)]
        payload: &'b [u8],
    },
    /// The owner, if the bytes are a command.
    Owner {
        counter: u64,
        #[arbitrary(with = sized)]
        command: &'b [u8],
    },
    /// The owner, for a probe with the same key.
    OwnerToAnother {
        counter: u64,
        #[arbitrary(with = sized)]
        command: &'b [u8],
    },
    /// Somebody who has heard one of the frames before and sends it again.
    Listener { which: u8 },
    /// The same, with a bit of it turned over.
    Forger { which: u8, bit: u16 },
}

/// Bytes behind their length, as far as there are so many.
fn sized<'b>(bytes: &mut Unstructured<'b>) -> arbitrary::Result<&'b [u8]> {
    let length = usize::from(u16::arbitrary(bytes)?);
    bytes.bytes(length.min(bytes.len()))
}

/// A memory that keeps one counter.
struct Counter(u64);

impl CounterStore for Counter {
    type Error = ();

    fn read(&mut self) -> Result<u64, ()> {
        Ok(self.0)
    }

    fn store(&mut self, counter: u64) -> Result<(), ()> {
        self.0 = counter;
        Ok(())
    }
}

/// A payload for the gate's probe or for another one, with its counter where its code is right for the gate's.
#[derive(Clone)]
struct Payload {
    bytes: Vec<u8>,
    counter: Option<u64>,
}

impl Payload {
    /// Payload that the owner of the key sends; `None` if the bytes are no command.
    fn signed(probe: ProbeId, counter: u64, command: &[u8]) -> Option<Self> {
        let (command, _) = postcard::take_from_bytes::<Command>(command).ok()?;
        let mut buffer = [0; MAX_PAYLOAD];
        let bytes = authenticate(&Key::new(&KEY, probe)?, counter, &command, &mut buffer).ok()?.to_vec();
        Some(Self { bytes, counter: (probe == PROBE).then_some(counter) })
    }

    fn with_a_bit_turned_over(mut self, bit: u16) -> Self {
        let at = usize::from(bit) % (8 * self.bytes.len());
        self.bytes[at / 8] ^= 1 << (at % 8);
        Self { counter: None, ..self }
    }
}

/// An exchange. What needs the key passes only with it, once, with the counter risen, and at rest where it has to; a
/// counter is used up by an authentic command and by nothing else.
///
/// # Panics
/// It does not.
pub fn command_gate(bytes: &[u8]) {
    let Ok(exchange) = Exchange::arbitrary(&mut Unstructured::new(bytes)) else { return };
    let mut gate = CommandGate::new(Key::new(&KEY, PROBE).filter(|_| exchange.has_key));
    let (mut counter, mut now_us, mut heard) = (Counter(0), 1_000_000_000, Vec::<Payload>::new());
    for said in &exchange.said {
        now_us += 1_000 * u64::from(said.after_ms);
        let again = |which: u8| heard.get(usize::from(which) % heard.len().max(1)).cloned();
        let payload = match said.frame {
            Origin::Anybody { payload, .. } => Some(Payload { bytes: payload.to_vec(), counter: None }),
            Origin::Owner { counter, command } => Payload::signed(PROBE, counter, command),
            Origin::OwnerToAnother { counter, command } => Payload::signed(OTHER_PROBE, counter, command),
            Origin::Listener { which } => again(which),
            Origin::Forger { which, bit } => again(which).map(|payload| payload.with_a_bit_turned_over(bit)),
        };
        let Some(payload) = payload else { continue };
        let kind = match said.frame {
            Origin::Anybody { kind, .. } => kind,
            _ => Kind::AuthenticatedCommand.number(),
        };
        let frame = Frame { kind, sequence: 7, payload: &payload.bytes };
        let situation = Situation { now_us, drilling: said.drilling };
        let before = counter.0;
        let is_new = |counter: &u64| *counter > before && *counter - before <= MAX_COUNTER_STEP;
        let used_up = payload.counter.filter(is_new).filter(|_| exchange.has_key);
        let judgement = gate.judge(&frame, situation, &mut counter);
        assert_eq!(counter.0, used_up.unwrap_or(before), "{:?}", said.frame);
        if let Judgement::CarryOut { command, authentic, .. } = judgement {
            assert_eq!(authentic, used_up.is_some(), "{:?}", said.frame);
            assert!(authentic || !command.needs_the_key(), "{command:?}");
            assert!(!said.drilling || !command.needs_a_pause(), "{command:?}");
            let again = gate.judge(&frame, situation, &mut counter);
            assert!(!authentic || matches!(again, Judgement::Refuse(_)), "{command:?} twice");
        }
        if !matches!(said.frame, Origin::Anybody { .. }) {
            heard.push(payload);
        }
    }
}
