//! The layouts of docs/telemetry.md, and the decoders in Python and C that read them, are those of the library.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use meerkat_mwd::{
    diagnosis::DiagnosisReport,
    magnet::HardIronInterval,
    probe::Output,
    survey::{DrillingDynamics, SlidingToolface, SurveyReport, VibrationDose},
    telemetry::{
        Acknowledgement, AttitudeFrame, Boot, BurstPart, Command, Health, Identification, ImagePart, Key, Kind,
        MAX_FRAME, MAX_PAYLOAD, Payload, ProbeId, ProgramReport, RawSample, authenticate, encode_frame, encode_payload,
    },
};
use mwd::target::{deadline, toolchain::workspace};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::{Map, Value, json};
use std::{env, fs, path::PathBuf, process, time::Duration};

const TIME: Duration = Duration::from_secs(120);
/// Messages of each kind.
const EACH: usize = 150;

fn folder() -> PathBuf {
    workspace().join("bindings/telemetry")
}

/// The lines of the layouts in C.
fn as_c(layout: &str) -> String {
    let lines = layout.lines().filter(|line| !line.is_empty());
    let lines: String = lines.map(|line| format!("    \"{line}\",\n")).collect();
    format!(
        "/* Lines of telemetry.layout. Written by: MWD_BLESS=1 cargo test -p host-tests --test telemetry_layout */\n\
         static const char *const MWD_TELEMETRY_LAYOUT[] = {{\n{lines}    NULL,\n}};\n"
    )
}

/// `MWD_BLESS=1` writes the copies anew.
#[test]
fn guide_and_header_hold_the_same_layouts() {
    let layout = fs::read_to_string(folder().join("telemetry.layout")).unwrap();
    let guide = fs::read_to_string(workspace().join("docs/telemetry.md")).unwrap();
    let (before, rest) = guide.split_once("```layout\n").unwrap();
    let (_, after) = rest.split_once("```").unwrap();
    let copies = [
        ("docs/telemetry.md", format!("{before}```layout\n{layout}```{after}")),
        ("bindings/telemetry/mwd_telemetry_layout.h", as_c(&layout)),
    ];
    for (file, expected) in copies {
        let path = workspace().join(file);
        if env::var_os("MWD_BLESS").is_some() {
            fs::write(&path, &expected).unwrap();
        }
        assert!(fs::read_to_string(path).unwrap_or_default() == expected, "{file}: MWD_BLESS=1");
    }
}

/// Bytes that are an encoding more often than chance: absent or there, the first of some choices, small numbers.
fn bytes(random: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let most = 2 + random.next_u32() % 9;
    let often = 2 + random.next_u32() % 60;
    let mut byte =
        || if random.next_u32().is_multiple_of(often) { random.next_u32() % most } else { random.next_u32() % 2 };
    (0..3_000).map(|_| byte() as u8).collect()
}

struct Line {
    random: Xoshiro256PlusPlus,
    sent: Vec<u8>,
    expected: Vec<Value>,
}

impl Line {
    /// Takes a frame, and damage before it now and then.
    fn put(&mut self, kind: Kind, payload: &[u8], name: &str, value: Value) {
        if self.random.next_u32().is_multiple_of(16) {
            self.sent.extend([3, 1, 2, 0, 0, 0, 9, 255, 0]);
        }
        let sequence = self.expected.len() as u16;
        let mut frame = [0; MAX_FRAME];
        self.sent.extend(encode_frame(kind, sequence, payload, &mut frame).unwrap());
        let mut message = Map::new();
        message.insert("sequence".into(), json!(sequence));
        message.insert(name.into(), value);
        self.expected.push(Value::Object(message));
    }

    /// Sends random messages of a kind.
    fn send<P: Payload + serde::de::DeserializeOwned>(&mut self, name: &str) {
        let mut sent = 0;
        for _ in 0..1_000 * EACH {
            let Ok((message, _)) = postcard::take_from_bytes::<P>(&bytes(&mut self.random)) else { continue };
            let mut room = [0; MAX_PAYLOAD];
            let Ok(payload) = encode_payload(&message, &mut room) else { continue };
            self.put(P::KIND, payload, name, serde_json::to_value(&message).unwrap());
            sent += 1;
            if sent == EACH {
                return;
            }
        }
        panic!("{name}: {sent} only");
    }
}

fn messages() -> Line {
    let mut line = Line { random: Xoshiro256PlusPlus::seed_from_u64(26), sent: vec![], expected: vec![] };
    line.send::<Boot>("Boot");
    line.send::<AttitudeFrame>("AttitudeFrame");
    line.send::<Output>("Output");
    line.send::<RawSample>("RawSample");
    line.send::<SurveyReport>("SurveyReport");
    line.send::<DrillingDynamics>("DrillingDynamics");
    line.send::<Identification>("Identification");
    line.send::<DiagnosisReport>("DiagnosisReport");
    line.send::<HardIronInterval>("HardIronInterval");
    line.send::<Health>("Health");
    line.send::<Acknowledgement>("Acknowledgement");
    line.send::<SlidingToolface>("SlidingToolface");
    line.send::<VibrationDose>("VibrationDose");
    line.send::<BurstPart>("BurstPart");
    line.send::<ProgramReport>("ProgramReport");
    line.send::<Command>("Command");
    let key = Key::new(&std::array::from_fn(|i| (i * 37 + 11) as u8), ProbeId([7; 12])).unwrap();
    let mut room = [0; MAX_PAYLOAD];
    let counter = 0x0102_0304_0506;
    let payload = authenticate(&key, counter, &Command::StationarySurvey { within_s: 300 }, &mut room).unwrap();
    let command = json!({"StationarySurvey": {"within_s": 300}});
    let value = json!({"counter": counter, "code": payload[8..24], "command": command});
    line.put(Kind::AuthenticatedCommand, payload, "AuthenticatedCommand", value);
    let image: Vec<u8> = (0..ImagePart::BYTES).map(|k| (k * 7) as u8).collect();
    for bytes in [&image[..], &image[..3]] {
        let part = ImagePart { offset: 70_000, bytes };
        let value = serde_json::to_value(part).unwrap();
        line.put(Kind::ImagePart, encode_payload(&part, &mut room).unwrap(), "ImagePart", value);
    }
    line
}

/// Returns true if two values are one. Numbers are compared as what a line carries; a compact angle is two bytes to
/// serde.
fn same(told: &Value, expected: &Value) -> bool {
    match (told, expected) {
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(name, value)| b.get(name).is_some_and(|other| same(value, other)))
        }
        (Value::Number(a), Value::Array(b)) => match b.as_slice() {
            [low, high] => a.as_u64() == Some(low.as_u64().unwrap() + 256 * high.as_u64().unwrap()),
            _ => false,
        },
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Number(a), Value::Number(b)) => match (a.as_u64(), b.as_u64()) {
            (Some(a), Some(b)) => a == b,
            _ => (a.as_f64().unwrap() as f32).to_bits() == (b.as_f64().unwrap() as f32).to_bits(),
        },
        _ => told == expected,
    }
}

fn hold(line: &Line, printed: &str, who: &str) {
    assert_eq!(printed.lines().count(), line.expected.len(), "{who}");
    for (told, expected) in printed.lines().zip(&line.expected) {
        let told: Value = serde_json::from_str(told).unwrap_or_else(|error| panic!("{who}: {error}: {told}"));
        assert!(same(&told, expected), "{who}\n{told}\n{expected}");
    }
}

#[test]
fn both_decoders_read_every_message() {
    let line = messages();
    let directory = tempfile::tempdir().unwrap();
    let capture = directory.path().join("line.bin");
    fs::write(&capture, &line.sent).unwrap();
    let run = |command: &mut process::Command| deadline::run(command, TIME).unwrap_or_else(|error| panic!("{error}"));

    let mut python = process::Command::new("python3");
    hold(&line, &run(python.arg(folder().join("mwd_telemetry.py")).arg(&capture)), "Python");
    for compiler in [["gcc", "-std=c99", "-xc"], ["g++", "-std=c++17", "-xc++"]] {
        let program = directory.path().join("to_json");
        let mut build = process::Command::new(compiler[0]);
        build.args(&compiler[1..]).args([
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-Wno-missing-field-initializers",
        ]);
        build.args(["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
        build.args(["to_json.c", "mwd_telemetry.c"].map(|file| folder().join(file)));
        run(build.args(["-x", "none", "-lm", "-o"]).arg(&program));
        hold(&line, &run(process::Command::new(&program).arg(&capture)), compiler[0]);

        // Random bytes of every kind end in an error or in a message, and in nothing else.
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut spoilt = vec![];
        for _ in 0..3_000 {
            let kind =
                Kind::of_number([1, 5, 7, 8, 10, 11, 13, 14, 15, 64, 65, 66][random.next_u32() as usize % 12]).unwrap();
            let length = random.next_u32() as usize % 400;
            let mut payload = bytes(&mut random);
            payload[..20].iter_mut().for_each(|byte| *byte = random.next_u32() as u8);
            spoilt.extend(encode_frame(kind, 0, &payload[..length], &mut [0; MAX_FRAME]).unwrap());
        }
        fs::write(directory.path().join("spoilt.bin"), &spoilt).unwrap();
        let printed = run(process::Command::new(&program).arg(directory.path().join("spoilt.bin")));
        assert_eq!(printed.lines().count(), 3_000);
    }
}
