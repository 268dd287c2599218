//! The targets of the fuzzer, on its corpus, mutated a bounded number of times.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{
    fs,
    panic::catch_unwind,
    path::{Path, PathBuf},
    thread,
    time::Instant,
};

use attack::fuzzed::{KEY, PROBE, TARGETS, Target, places};
use meerkat_mwd::{
    Config, Sample,
    compensation::{GyroModel, effects::LIBRARY},
    storage::{Limits, ModelHistory, ModelStore, NotDrilling, Preparation, StoredModel},
    survey::{BurstSample, SlidingToolface, ToolfaceKind, Uncertain, VibrationDose},
    telemetry::{
        Acknowledgement, Boot, BurstPart, Command, EarlierModel, Erasure, Health, Key, Kind, MAX_FRAME, MAX_PAYLOAD,
        Outcome, Payload, RawSample, StreamConfig, authenticate, encode_frame, encode_payload,
    },
};
use mock_flash::MockFlash;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Mutations of each target. `MWD_MUTATIONS` sets another number, and `MWD_TARGET` names the only one that runs.
const MUTATIONS: u64 = 1_000_000;
/// Mutations for one of `flights`, which goes on until a model is found.
const FOR_A_FLIGHT: u64 = 1_000;

/// The corpus.
fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("fuzz").join("corpus")
}

fn encoded<P: Payload>(payload: &P) -> (Kind, Vec<u8>) {
    let mut buffer = [0; MAX_PAYLOAD];
    (P::KIND, encode_payload(payload, &mut buffer).unwrap().to_vec())
}

/// Payloads that a probe and a host send each other, with their kinds.
fn said() -> Vec<(Kind, Vec<u8>)> {
    let signed = |counter, command| {
        let mut buffer = [0; MAX_PAYLOAD];
        let key = Key::new(&KEY, PROBE).unwrap();
        (Kind::AuthenticatedCommand, authenticate(&key, counter, &command, &mut buffer).unwrap().to_vec())
    };
    vec![
        encoded(&Boot { probe: PROBE, ..Boot::new(Config::default()) }),
        encoded(&Health { probe: PROBE, t_us: 5_000_000, ..Health::default() }),
        encoded(&RawSample::of(7, &Sample { t_us: 35_000, accel_m_s2: [0.1, -0.2, -9.8], ..Sample::default() })),
        encoded(&Acknowledgement { sequence: 3, outcome: Outcome::Accepted }),
        encoded(&SlidingToolface {
            t_start_us: 1,
            t_end_us: 5_000_001,
            kind: ToolfaceKind::Gravity,
            toolface_rad: Uncertain { value: 1.0, sigma: 0.01 },
            swing_rad: 0.02,
            latency_s: 2.5,
        }),
        encoded(&VibrationDose { shocks: 7, ..VibrationDose::NONE }),
        encoded(&BurstPart {
            first: 0,
            of: 200,
            rms_m_s2: 9.0,
            samples: (0..8).map(|_| BurstSample::default()).collect(),
        }),
        encoded(&Command::SelfTest),
        encoded(&Command::StartRecording { for_s: Some(60) }),
        encoded(&Command::ConfigureStream(StreamConfig::default())),
        signed(1, Command::Configure(Config::default())),
        signed(2, Command::RollBackModel { to: EarlierModel::Previous }),
        signed(3, Command::Erase { what: Erasure::Models }),
        signed(4, Command::SendVibration),
    ]
}

/// The beginning of a flash with models, counters and a retirement in it.
fn stored() -> Vec<u8> {
    let config = Config::default();
    let mut store = ModelStore::<_, 3>::open(MockFlash::<4, 8192>::new(3, 1), Limits::new(&config, &LIBRARY)).unwrap();
    while store.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {}
    let gyro = GyroModel { b_rad_s: [0.01, -0.02, 0.03], ..GyroModel::IDENTITY };
    let flying = *ModelHistory::of_factory(&Config { gyro, ..config }, &LIBRARY).latest();
    for (t_us, temperature) in [(1, 20.0), (2, 60.0), (3, 61.0)] {
        store.store_model(&StoredModel { t_us, temperature_c: Some([temperature; 2]), ..flying }).unwrap();
        store.store_counter(t_us).unwrap();
    }
    store.retire_models_before(2).unwrap();
    let mut flash = store.into_flash();
    let used = flash.bytes_mut()[..8192].iter().rposition(|byte| *byte != 0xFF).unwrap();
    flash.bytes_mut()[..used + 1].to_vec()
}

/// The bytes from which `arbitrary` makes a variant of an enum: it takes the upper part of a product with their number.
fn variant(number: u64, of: u64) -> [u8; 4] {
    (((number << 32).div_ceil(of)) as u32).to_le_bytes()
}

/// The bytes from which it makes a list: a one stands before each element.
fn list(elements: impl IntoIterator<Item = Vec<u8>>) -> Vec<u8> {
    elements.into_iter().flat_map(|element| [vec![1], element].concat()).chain([0]).collect()
}

/// Samples of a tool that turns, thirty of them at 100 Hz, as they are.
fn flown() -> Vec<u8> {
    let of = |k: u16| {
        let (sine, cosine) = libm::sincosf(f32::from(k) * 0.05);
        let numbers = [0.01, -0.02, 5.0, 2.0 * cosine, 2.0 * sine, -9.6, 20.0 * cosine, 20.0 * sine, 40.0, 25.0];
        let numbers = numbers.iter().flat_map(|number: &f32| number.to_le_bytes());
        variant(1, 2).into_iter().chain(10_000_i32.to_le_bytes()).chain(numbers).chain([0, 0]).collect()
    };
    [vec![1, 1, 8], list((0..30).map(of))].concat()
}

/// Turns of a tool: rates in steps of 0.05 rad/s, and periods. In the middle the magnetometer is missing for a while
/// and an axis of the gyro sticks.
fn turned(period: u8, by_hand: u8, turns: &[([i8; 3], u8)]) -> Vec<u8> {
    let of = |(k, (rate, periods)): (usize, &([i8; 3], u8))| {
        let replaced = if k == turns.len() / 2 { [&[1, 2][..], &3.0_f32.to_le_bytes()].concat() } else { vec![0] };
        let flags = u16::from(k == turns.len() / 3) << 2;
        let rate = rate.map(i8::cast_unsigned);
        [&variant(0, 2)[..], &rate, &[*periods], &replaced, &flags.to_le_bytes()].concat()
    };
    [vec![period, by_hand, 8], list(turns.iter().enumerate().map(of))].concat()
}

/// An exchange with a gate: whether it drills, milliseconds since the frame before, who speaks, and what.
fn exchanged(has_key: bool, said: impl IntoIterator<Item = (u8, u16, Vec<u8>)>) -> Vec<u8> {
    let of =
        |(drilling, after_ms, frame): (u8, u16, Vec<u8>)| [&[drilling], &after_ms.to_le_bytes()[..], &frame].concat();
    [vec![has_key.into()], list(said.into_iter().map(of))].concat()
}

/// Exchanges: commands without the key; the owner's, heard and sent again, whole and forged; those of a drilling
/// probe, and for another one.
fn exchanges() -> Vec<Vec<u8>> {
    let sized = |command| {
        let bytes = encoded(&command).1;
        [&u16::try_from(bytes.len()).unwrap().to_le_bytes()[..], &bytes].concat()
    };
    let anybody = |command| [&variant(0, 5)[..], &[Kind::Command.number()], &sized(command)].concat();
    let signed = |who, counter: u64, command| [&variant(who, 5)[..], &counter.to_le_bytes(), &sized(command)].concat();
    let again = |which| [&variant(3, 5)[..], &[which]].concat();
    let forged = |which, bit: u16| [&variant(4, 5)[..], &[which], &bit.to_le_bytes()].concat();
    let open = || [Command::SelfTest, Command::StartRecording { for_s: Some(60) }, Command::StopRecording];
    let owners = || {
        [
            Command::ConfigureStream(StreamConfig::default()),
            Command::Configure(Config::default()),
            Command::ConfigureSurvey(Config::default().survey),
            Command::AcceptModel { window_end_us: 1 },
            Command::RollBackModel { to: EarlierModel::Previous },
            Command::Erase { what: Erasure::Models },
            Command::SendVibration,
        ]
    };
    let spoken = |drilling, who| (1..).zip(owners()).map(move |(k, command)| (drilling, 300, signed(who, k, command)));
    let heard = [(0, 300, again(4)), (0, 0, forged(4, 3)), (0, 0, forged(5, 100)), (1, 0, again(0))];
    let for_another = [(0, 300, signed(2, 9, Command::SendVibration)), (0, 0, again(7))];
    vec![
        exchanged(true, open().into_iter().chain(owners()).map(|command| (0, 400, anybody(command)))),
        exchanged(true, spoken(0, 1).chain(heard.clone())),
        exchanged(true, spoken(1, 1).chain(for_another)),
        exchanged(false, spoken(0, 1).chain(heard)),
    ]
}

/// Configurations: the defaults as text, and with a field in seven changed by a little.
fn configurations() -> Vec<Vec<u8>> {
    let text = toml::to_string(&Config::default()).unwrap().into_bytes();
    let change = |place: usize| {
        let times = if place.is_multiple_of(2) { 5_i8 } else { -5 };
        [&[u8::try_from(place).unwrap()], &variant(1, 8)[..], &[times.cast_unsigned()]].concat()
    };
    vec![
        [&variant(0, 2)[..], &text].concat(),
        [&variant(1, 2)[..], &list((0..places()).step_by(7).map(change))].concat(),
    ]
}

/// A trace of some rows.
fn recorded() -> Vec<u8> {
    let rows = (0..8).map(|k| format!("{}.0{k},0.1,-0.2,0.3,0.0,0.1,-9.8,20,1,45,25.5\n", k / 3));
    let head = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz,temp_c\n".to_owned();
    [head].into_iter().chain(rows).collect::<String>().into_bytes()
}

/// Bytes from an ISM330DHCX that turns: forty bursts of two frames, and after each the time to the next.
fn inertial_bursts() -> Vec<u8> {
    let word = |sensor: u8, slot: u16, k: u16| {
        let tag = sensor << 3 | (slot as u8 & 3) << 1;
        let tag = tag | (tag.count_ones() % 2) as u8;
        let codes = [k * 37 % 101, 1_000 + k * 53 % 97, 2_000 + k * 71 % 89];
        [vec![tag], codes.iter().flat_map(|code| code.to_le_bytes()).collect()].concat()
    };
    let burst = |k: u16| {
        let over_run = u8::from(k == 20) << 3;
        let temperature = if k.is_multiple_of(16) { vec![0x00, 0x01] } else { Vec::new() };
        let words = [2 * k, 2 * k + 1].map(|slot| [word(1, slot, slot), word(2, slot, slot + 7)].concat());
        // 38 steps of 250 us: two frames at 208 Hz.
        [vec![4, over_run], temperature, words.concat(), vec![38]].concat()
    };
    (0..40).flat_map(burst).collect()
}

/// Bytes from an RM3100, a result at a time.
fn magnetic_results() -> Vec<u8> {
    let result = |k: u32| {
        let axes = [3_000 + k * 37 % 101, 500 + k * 53 % 97, 0xFF_F000 + k * 71 % 89];
        let bytes = axes.iter().flat_map(|axis| axis.to_be_bytes().into_iter().skip(1)).collect();
        [vec![0x80], bytes, vec![0x00], vec![27]].concat()
    };
    (0..60).flat_map(result).collect()
}

/// Turns of a tool on all axes, at 20 Hz for 25 seconds, and a rest.
const DRILLED: [([i8; 3], u8); 9] = [
    ([0; 3], 20),
    ([20, 3, 30], 72),
    ([-15, 25, 10], 72),
    ([5, -30, -20], 72),
    ([30, 10, -5], 72),
    ([-20, -20, 20], 72),
    ([10, 30, 15], 72),
    ([-5, 15, -30], 72),
    ([0; 3], 20),
];

/// The corpus as it was made, for whom it has to be made anew.
fn made() -> Vec<(&'static str, Vec<Vec<u8>>)> {
    let framed = |(kind, payload): &(Kind, Vec<u8>)| {
        let mut buffer = [0; MAX_FRAME];
        encode_frame(*kind, 9, payload, &mut buffer).unwrap().to_vec()
    };
    let with_kind = |(kind, payload): &(Kind, Vec<u8>)| [&[kind.number()][..], payload].concat();
    let said = said();
    vec![
        ("frame", said.iter().map(framed).collect()),
        ("message", said.iter().take(4).map(with_kind).collect()),
        ("command_gate", exchanges()),
        ("stored_records", vec![stored()]),
        ("ism330dhcx", vec![inertial_bursts()]),
        ("rm3100", vec![magnetic_results()]),
        ("samples", vec![flown(), turned(1, 1, &[([20, -7, 3], 60), ([0; 3], 40), ([-40, 2, 9], 20)])]),
        ("flights", vec![turned(9, 0, &DRILLED)]),
        ("configuration", configurations()),
        ("trace", vec![recorded()]),
    ]
}

#[test]
fn the_corpus_is_of_this_protocol() {
    for (target, files) in made() {
        let folder = corpus().join(target);
        for (number, bytes) in files.iter().enumerate() {
            let path = folder.join(format!("{number}.bin"));
            if std::env::var_os("MWD_BLESS").is_some_and(|v| v == "1") {
                fs::create_dir_all(&folder).unwrap();
                fs::write(&path, bytes).unwrap();
            }
            let kept = fs::read(&path).unwrap_or_default();
            assert!(kept == *bytes, "{}: another protocol; MWD_BLESS=1 writes it anew", path.display());
        }
    }
}

/// Bits that flip, bytes that are set, cut off, doubled, and spliced in from elsewhere.
fn mutated(bytes: &[u8], rng: &mut Xoshiro128PlusPlus) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut below = |n: usize| rng.next_u32() as usize % n.max(1);
    for _ in 0..1 + below(6) {
        let (at, other, length) = (below(bytes.len()), below(bytes.len()), below(40));
        match below(6) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << below(8),
            1 if !bytes.is_empty() => bytes[at] = [0, 1, 0x7F, 0x80, 0xFF, below(256) as u8][below(6)],
            2 => bytes.truncate(at),
            3 => {
                let end = bytes.len().min(at + length);
                let piece = bytes[at..end].to_vec();
                bytes.splice(other..other, piece);
            }
            4 => drop(bytes.drain(at..bytes.len().min(at + length))),
            _ => bytes.extend((0..length).map(|_| below(256) as u8).collect::<Vec<_>>()),
        }
    }
    bytes
}

/// Mutates the corpus of a target so many times; returns the seconds that it took.
fn fuzz(number: u64, name: &str, target: Target, mutations: u64) -> f64 {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(number);
    let mut paths: Vec<PathBuf> = fs::read_dir(corpus().join(name)).unwrap().map(|file| file.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{name}");
    let mut files: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
    let begun = Instant::now();
    files.iter().for_each(|bytes| target(bytes));
    files.push(Vec::new());
    for (k, file) in (0..mutations).zip(files.iter().cycle()) {
        let bytes = mutated(file, &mut rng);
        if catch_unwind(|| target(&bytes)).is_err() {
            panic!("{name}, mutation {k}: {}", bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
        }
    }
    begun.elapsed().as_secs_f64()
}

#[test]
fn nothing_that_comes_from_outside_breaks_what_holds() {
    let each: u64 = std::env::var("MWD_MUTATIONS").map_or(MUTATIONS, |text| text.parse().unwrap());
    let only = std::env::var("MWD_TARGET").ok();
    let chosen = |name: &str| only.as_ref().is_none_or(|only| only == name);
    thread::scope(|scope| {
        for (number, (name, target)) in (1..).zip(TARGETS) {
            let mutations = if name == "flights" { each / FOR_A_FLIGHT } else { each };
            let run =
                move || println!("{name}: {mutations} mutations in {:.1} s", fuzz(number, name, target, mutations));
            let _ = chosen(name).then(|| scope.spawn(run));
        }
    });
}
