//! Everything that parses what comes from outside, each with what has to hold of any bytes at all: for a
//! fuzzer, and for a test that mutates a small corpus.

mod sensors;

pub use sensors::{ism330dhcx, rm3100};

use crate::{target::mock_flash::MockFlash, trace::Trace};
use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    compensation::effects::LIBRARY,
    storage::{FactoryRecords, Limits, ModelStore, NotDrilling, Outcome},
    telemetry::{
        CommandGate, CounterStore, Frame, FrameDecoder, Judgement, Key, Kind, MAX_DECODED, MAX_FRAME, MAX_PAYLOAD,
        Message, ProbeId, Situation, encode_frame,
    },
};

/// What takes any bytes.
pub type Target = fn(&[u8]);

/// All, by name.
pub const TARGETS: [(&str, Target); 9] = [
    ("frame", frame),
    ("message", message),
    ("command_gate", command_gate),
    ("stored_records", stored_records),
    ("ism330dhcx", ism330dhcx),
    ("rm3100", rm3100),
    ("samples", samples),
    ("configuration", configuration),
    ("trace", trace),
];

/// Bytes of a sample of [`samples`]: a step of time, then gyro, accelerometer, magnetometer, temperature and flags.
pub const SAMPLE_BYTES: usize = 4 + 4 * 10 + 2;

/// The key of the gate that is fuzzed, and of what its corpus is signed with.
pub const KEY: [u8; 32] = *b"a key that no probe has 32 bytes";
/// The probe of that gate.
pub const PROBE: ProbeId = ProbeId(*b"fuzzed probe");

/// Bytes of a line. A frame that is found in them is found again where it is encoded anew.
///
/// # Panics
/// It is not.
pub fn frame(bytes: &[u8]) {
    let mut decoder = FrameDecoder::<MAX_DECODED>::new();
    let (mut found, mut ends) = (0, 0);
    for byte in bytes {
        ends += u32::from(*byte == 0);
        let Some(frame) = decoder.push(*byte) else { continue };
        found += 1;
        let Some(kind) = Kind::of_number(frame.kind) else { continue };
        if frame.payload.len() > MAX_PAYLOAD {
            continue;
        }
        let mut buffer = [0; MAX_FRAME];
        let encoded = encode_frame(kind, frame.sequence, frame.payload, &mut buffer);
        let mut again = FrameDecoder::<MAX_DECODED>::new();
        let same = encoded.is_ok_and(|encoded| encoded.iter().any(|byte| again.push(*byte) == Some(frame)));
        assert!(same, "{frame:?}");
    }
    let counters = decoder.counters();
    assert_eq!(counters.frames, found);
    assert!(found + counters.bad + counters.oversize <= ends, "every frame ends with a zero");
}

/// A kind and a payload.
pub fn message(bytes: &[u8]) {
    let Some((kind, payload)) = bytes.split_first() else { return };
    if let Ok(message) = Message::decode(&Frame { kind: *kind, sequence: 0, payload }) {
        let _ = format!("{message:?}");
    }
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

/// Whether it drills, a kind and a payload. What needs the key passes only with it, once, with the counter
/// risen, and at rest where it has to.
///
/// # Panics
/// It does not.
pub fn command_gate(bytes: &[u8]) {
    let [drilling, kind, payload @ ..] = bytes else { return };
    let (drilling, frame) = (drilling % 2 == 1, Frame { kind: *kind, sequence: 7, payload });
    let situation = Situation { now_us: 1_000_000_000, drilling };
    let (mut gate, mut counter) = (CommandGate::new(Key::new(&KEY, PROBE)), Counter(0));
    if let Judgement::CarryOut { command, authentic, .. } = gate.judge(&frame, situation, &mut counter) {
        assert!(authentic || !command.needs_the_key(), "{command:?}");
        assert!(!drilling || !command.needs_a_pause(), "{command:?}");
        assert_eq!(authentic, counter.0 > 0);
        let again = gate.judge(&frame, situation, &mut counter);
        assert!(!authentic || matches!(again, Judgement::Refuse(_)), "{command:?} twice");
    }
    let (mut keyless, mut counter) = (CommandGate::new(None), Counter(0));
    if let Judgement::CarryOut { command, .. } = keyless.judge(&frame, situation, &mut counter) {
        assert!(!command.needs_the_key(), "{command:?}");
    }
    assert_eq!(counter.0, 0);
}

/// What the flash holds from its beginning; the rest of it is erased. What is restored may fly, the counter
/// does not fall, and it can be prepared and written to.
///
/// # Panics
/// One of these does not hold.
pub fn stored_records(bytes: &[u8]) {
    const SECTOR: usize = 8 * 1024;
    let mut flash = MockFlash::<4, SECTOR>::new(3, 1);
    for (place, byte) in flash.bytes_mut().iter_mut().zip(bytes) {
        *place = *byte;
    }
    let _ = FactoryRecords::read(&mut flash.clone());
    let limits = Limits::new(&Config::default(), &LIBRARY);
    let opened = ModelStore::<_, 3>::open(flash, limits);
    assert!(opened.is_ok(), "a flash that can be read is opened");
    let Ok(mut store) = opened else { return };
    for temperature_c in [None, Some(20.0), Some(f32::NAN)] {
        if let Ok(restoration) = store.restore(temperature_c)
            && let Outcome::Chosen { model, .. } = restoration.outcome
        {
            assert_eq!(limits.check(&model), Ok(()));
        }
    }
    let counter = store.read_counter();
    for _ in 0..12 {
        assert!(store.prepare(NotDrilling::PowerUp).is_ok());
    }
    assert_eq!(store.read_counter(), counter);
    if let Some(next) = counter.checked_add(1) {
        assert_eq!(store.store_counter(next), Ok(()));
    }
}

/// Samples, each after a step of time forwards or back, microseconds. Each is taken or counted, and what is said of it
/// is finite.
///
/// # Panics
/// One is not.
pub fn samples(bytes: &[u8]) {
    let mut probe = Box::new(Probe::new());
    assert!(probe.configure(&Config::default()).is_ok());
    let (mut t_us, mut pushed) = (1_u64 << 40, 0);
    for bytes in bytes.as_chunks::<SAMPLE_BYTES>().0 {
        let word = |k: usize| bytes.get(4 * k..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default();
        let vector = |k: usize| [k, k + 1, k + 2].map(|k| f32::from_le_bytes(word(k)));
        t_us = t_us.saturating_add_signed(i32::from_le_bytes(word(0)).into());
        let sample = Sample {
            t_us,
            gyro_rad_s: vector(1),
            accel_m_s2: vector(4),
            mag_ut: vector(7),
            temperature_c: f32::from_le_bytes(word(10)),
            flags: SampleFlags::from_bits_retain(u16::from_le_bytes([bytes[44], bytes[45]])),
        };
        pushed += 1;
        if let Some(output) = probe.push(&sample) {
            assert!(output.rate_rad_s.iter().all(|x| x.is_finite()), "{output:?}");
            assert!(output.attitude.is_none_or(|it| it.q.iter().all(|x| x.is_finite())), "{output:?}");
        }
        probe.poll(probe.poll_budget());
    }
    let counters = probe.counters();
    assert_eq!(counters.samples + u64::from(counters.out_of_order), pushed);
}

/// A configuration as text. One that is accepted can be flown with.
///
/// # Panics
/// It cannot.
pub fn configuration(bytes: &[u8]) {
    let Ok(config) = toml::from_str::<Config>(&String::from_utf8_lossy(bytes)) else { return };
    let mut probe = Box::new(Probe::new());
    assert_eq!(config.validate().is_ok(), probe.configure(&config).is_ok());
    for k in 1..50 {
        let t_us = k * u64::from(config.sample_period_us);
        let sample = Sample { t_us, accel_m_s2: [0.1, 0.2, -9.8], mag_ut: [20.0, 3.0, 40.0], ..Sample::default() };
        probe.push(&sample);
        probe.poll(probe.poll_budget());
    }
}

/// A trace as text. In one that is read time goes forward.
///
/// # Panics
/// It does not.
pub fn trace(bytes: &[u8]) {
    if let Ok(trace) = Trace::of_bytes(bytes) {
        assert!(trace.samples.is_sorted_by(|before, after| before.t_us < after.t_us));
    }
}
