//! The factory's records, over the emulator's serial line into the probe, with the power cut in the middle.

use super::live::{KEY, LiveProbe};
use meerkat_mwd::{
    Config, Sample,
    storage::{FactoryKey, FactoryRecord},
    telemetry::{Command, CommandRefusal, EarlierModel, Message, Outcome},
};
use mwd::target::real_time::RealTime;
use std::fs;

const REGION_BYTES: usize = 16 * 1024;
/// Longer than any of it takes.
const RUN_S: usize = 1_800;

/// A calibration as `mwd calibrate` writes it, and another.
const CALIBRATION: &str = "[gyro]\np = [[1.01, 0.0, 0.002], [0.0, 0.99, 0.0], [0.0, 0.003, 1.0]]\nb_rad_s = [0.01, 0.0, -0.02]\n\
    [accel]\nmatrix = [[1.0, 0.0, 0.0], [0.0, 1.002, 0.0], [0.0, 0.0, 0.998]]\noffset = [0.1, 0.0, -0.05]\n\
    [mag]\nmatrix = [[1.0, 0.01, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\noffset = [3.0, -2.0, 1.0]\n";

fn run(power_cut_after: Option<u32>) -> (RealTime, Vec<Sample>) {
    let run = RealTime { power_cut_after, ..RealTime::default() };
    let still = Sample { accel_m_s2: [0.0, 0.1, -9.8], mag_ut: [20.0, 1.0, 45.0], ..Sample::default() };
    let samples = vec![still; RUN_S * 1_000_000 / run.config.sample_period_us as usize];
    (run, samples)
}

/// A probe from the assembly, and the files of its factory.
fn new_probe() -> Option<LiveProbe> {
    let probe = LiveProbe::new()?;
    fs::write(probe.at("factory.bin"), vec![0xFF; REGION_BYTES]).unwrap();
    fs::write(probe.at("calibration.toml"), CALIBRATION).unwrap();
    fs::write(probe.at("other.toml"), CALIBRATION.replace("1.01", "1.02")).unwrap();
    fs::write(probe.at("probe.key"), KEY.map(|byte| format!("{byte:02x}")).concat()).unwrap();
    Some(probe)
}

fn provision(probe: &LiveProbe, calibration: &str, more: &[&str]) -> (i32, String) {
    let (calibration, key) = (probe.at(calibration), probe.at("probe.key"));
    let all = ["provision", "--deadline", "300", "--calibration", &calibration, "--serial", "17"];
    let all = [&all[..], &["--toolface-offset", "-12.5", "--key", &key], more].concat();
    let (status, said) = probe.mwd(&all);
    println!("{status}: {}", said.trim().replace('\n', "; "));
    (status, said)
}

/// Another key than the factory's.
const OTHER_KEY: [u8; 32] = *b"another key, nobody's, 32 bytes!";

/// Asserts that the provisioned calibration flies, that the provisioned key is the one that opens, and that no other
/// record is taken, whoever sends it.
fn is_provisioned(probe: &LiveProbe) {
    assert_eq!(provision(probe, "calibration.toml", &["--check"]).0, 0);
    let (status, said) = provision(probe, "other.toml", &[]);
    assert!(status == 2 && said.contains("calibration: the probe refused"), "{said}");
    let mut host = probe.host();
    let refused = |outcome: Outcome| match outcome {
        Outcome::Refused(refusal) => Some(refusal),
        _ => None,
    };
    let factory = Command::RollBackModel { to: EarlierModel::Factory };
    assert_eq!(refused(host.plain(&factory)), Some(CommandRefusal::NotAuthenticated), "it has a key");
    // One that needs no pause: whether it stands still the probe cannot know before it has its calibration.
    let stream = Command::ConfigureStream(RealTime::default().stream);
    assert_eq!(refused(host.signed(&OTHER_KEY, 1, &stream)), Some(CommandRefusal::Forged));
    // The counter is judged after the code, so that a used one shows the right key, too.
    let with_the_key = host.signed(&KEY, 1, &stream);
    let is_open = matches!(with_the_key, Outcome::Accepted | Outcome::Refused(CommandRefusal::Replayed { latest: 1 }));
    assert!(is_open, "{with_the_key:?}");
    // Nobody gives it another key, with the present one or without.
    let other_key = Command::Provision { record: FactoryRecord::Key(FactoryKey(OTHER_KEY)), only_check: false };
    assert_eq!(refused(host.plain(&other_key)), Some(CommandRefusal::AlreadyProvisioned));
    let same_key = Command::Provision { record: FactoryRecord::Key(FactoryKey(KEY)), only_check: true };
    assert_eq!(host.plain(&same_key), Outcome::Accepted);
    assert_eq!(host.plain(&Command::StartRecording { for_s: Some(1) }), Outcome::Accepted);
    let boot = match host.boot {
        Some(boot) => boot,
        None => host.until("a boot", |message| if let Message::Boot(boot) = message { Some(*boot) } else { None }),
    };
    let expected: Config = toml::from_str(CALIBRATION).unwrap();
    let told = boot.config;
    assert_eq!((told.gyro, told.accel, told.mag), (expected.gyro, expected.accel, expected.mag));
}

#[test]
fn a_probe_is_provisioned_over_the_line_once_and_flies_with_it() {
    let Some(mut probe) = new_probe() else { return };
    let (run, samples) = run(None);
    probe.power_up(&run, &samples);
    // Before the first provisioning there is no key to ask for, and nothing that needs one is carried out.
    let mut host = probe.host();
    let stream = Command::ConfigureStream(RealTime::default().stream);
    assert_eq!(host.signed(&KEY, 1, &stream), Outcome::Refused(CommandRefusal::NoKey));
    drop(host);
    let (status, said) = provision(&probe, "calibration.toml", &["--check"]);
    assert!(status == 2 && said.contains("calibration: the probe holds none"), "{said}");
    let (status, said) = provision(&probe, "calibration.toml", &[]);
    assert_eq!((status, said.matches("written and read back").count()), (0, 3), "{said}");
    assert_eq!(provision(&probe, "calibration.toml", &[]).0, 0, "the same again");
    is_provisioned(&probe);
    probe.power_up(&run, &samples);
    is_provisioned(&probe);
}

/// Words of the three records: six granules of 32 bytes, one and two.
const WORDS: u32 = 9 * 8;

fn cut(words: impl Iterator<Item = u32>) {
    let Some(mut probe) = new_probe() else { return };
    for word in words {
        fs::write(probe.at("factory.bin"), vec![0xFF; REGION_BYTES]).unwrap();
        let (cut, samples) = run(Some(word));
        probe.power_up(&cut, &samples);
        assert_eq!(provision(&probe, "calibration.toml", &[]).0, 3, "word {word}");
        let (whole, samples) = run(None);
        probe.power_up(&whole, &samples);
        assert_eq!(provision(&probe, "calibration.toml", &[]).0, 0, "word {word}");
        is_provisioned(&probe);
    }
}

#[test]
fn a_provisioning_that_loses_power_is_repeated() {
    // One in each record.
    cut([20, 50, 60].into_iter());
}

#[test]
#[ignore = "each word takes some seconds"]
fn a_provisioning_that_loses_power_at_any_word_is_repeated() {
    cut(0..WORDS);
}
