//! The programs on a socket, as on the emulator's serial port.

use crate::{
    commands::KEY,
    flown,
    played_probe::{self, Manner},
};
use blake2::{Blake2s256, Digest};
use meerkat_mwd::{
    sample::TurnFlags,
    telemetry::{AttitudeFormat, Command, EarlierModel, Erasure, SelfTest},
};
use mwd::report::attitude_csv::write_attitude_csv;
use std::{fs, path::Path, process};
use testbed::trace::Trace;

struct Said {
    status: i32,
    out: String,
    error: String,
}

fn mwd(arguments: &[&str]) -> Said {
    let output = process::Command::new(env!("CARGO_BIN_EXE_mwd")).args(arguments).output().unwrap();
    Said {
        status: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        error: String::from_utf8(output.stderr).unwrap(),
    }
}

fn key_in(folder: &Path) -> String {
    let path = folder.join("probe.key");
    fs::write(&path, KEY.map(|byte| format!("{byte:02x}")).concat()).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_recording_over_a_socket_replays_to_what_the_probe_computed() {
    let (config, samples) = flown::recording("broad_06");
    let count = 6_000;
    let manner = Manner { hangs_up_after: count, ..Manner::default() };
    let (place, probe) = played_probe::start(config, samples, manner, 1);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let said = mwd(&["record", &place, "-o", &at("trace.csv.gz"), "--capture", &at("line.bin"), "--seconds", "120"]);
    assert_eq!(said.status, 0, "{}", said.error);
    assert!(said.out.contains("6000 samples"), "{}", said.out);
    let log = probe.join().unwrap();
    assert_eq!(log.carried_out.first(), Some(&Command::StartRecording { for_s: None }));
    write_attitude_csv(log.outputs.iter().copied(), Path::new(&at("probe.csv"))).unwrap();
    let replayed =
        mwd(&["replay", &at("trace.csv.gz"), "--config", &at("trace.toml"), "--attitude", &at("replay.csv")]);
    assert_eq!(replayed.status, 0, "{}", replayed.error);
    assert!(fs::read(at("probe.csv")).unwrap() == fs::read(at("replay.csv")).unwrap());
    // Capture of the line: it gives the same recording as the line, but for the date.
    let again = mwd(&["record", &at("line.bin"), "-o", &at("again.csv.gz")]);
    assert_eq!(again.status, 0);
    let [mut live, kept] = ["trace.csv.gz", "again.csv.gz"].map(|name| Trace::read(Path::new(&at(name))).unwrap());
    assert!(live.keys.serial.is_some() && live.keys.date.take().is_some());
    assert_eq!(live.keys, kept.keys);
    assert!(live.samples == kept.samples && kept.samples.len() == count);
}

#[test]
fn commands_are_answered_and_counters_kept() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let key = key_in(folder.path());
    let (place, probe) = played_probe::start(config, samples, Manner { latest: 40, ..Manner::default() }, 6);
    let survey = mwd(&["command", &place, "survey", "--within", "60"]);
    assert_eq!((survey.status, survey.out.trim()), (0, "accepted"), "{}", survey.error);
    // The probe's counter is at 40 and the host's at none: the first is answered by a replay's refusal, and
    // sent again.
    for arguments in [["roll-back", "factory"], ["erase", "models"]] {
        let said = mwd(&[&["command", &place, "--key", &key], &arguments[..]].concat());
        assert_eq!((said.status, said.out.trim()), (0, "accepted"), "{}", said.error);
    }
    // Without its counter's file the host is behind again.
    fs::remove_file(format!("{key}.counter")).unwrap();
    let said = mwd(&["command", &place, "--key", &key, "roll-back", "previous"]);
    assert_eq!(said.status, 0, "{}", said.error);
    assert_eq!(fs::read_to_string(format!("{key}.counter")).unwrap().trim(), "43");
    let file = folder.path().join("config.toml");
    fs::write(&file, "sample_period_us = 2500\n[earth]\ngravity_m_s2 = 9.81\n").unwrap();
    let said = mwd(&["command", &place, "--key", &key, "configure", file.to_str().unwrap()]);
    assert_eq!(said.status, 0, "{}", said.error);
    let future = mwd(&["command", &place, "--key", &key, "accept-model", "9999999999999"]);
    assert_eq!(future.status, 2);
    assert!(future.error.contains("window_end_us"), "{}", future.error);
    let log = probe.join().unwrap();
    assert_eq!(log.counters, [40, 41, 42, 43, 44, 45]);
    assert!(matches!(
        log.carried_out[..],
        [
            Command::StationarySurvey { within_s: 60 },
            Command::RollBackModel { to: EarlierModel::Factory },
            Command::Erase { what: Erasure::Models },
            Command::RollBackModel { to: EarlierModel::Previous },
            Command::Configure(_)
        ]
    ));
}

#[test]
fn what_goes_wrong_with_a_command_has_its_status_and_its_reason() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let key = key_in(folder.path());
    let (place, probe) =
        played_probe::start(config, samples.clone(), Manner { drilling: true, ..Manner::default() }, 1);
    let said = mwd(&["command", &place, "--key", &key, "erase", "models"]);
    assert_eq!(said.status, 2);
    assert!(said.error.contains("the tool is drilling"), "{}", said.error);
    assert!(probe.join().unwrap().carried_out.is_empty());

    let (place, probe) = played_probe::start(config, samples, Manner { deaf: true, ..Manner::default() }, 1);
    let said = mwd(&["command", &place, "--deadline", "1", "self-test"]);
    assert_eq!(said.status, 3);
    assert!(said.error.contains("no answer within 1 s"), "{}", said.error);
    probe.join().unwrap();

    let bad = folder.path().join("bad.key");
    fs::write(&bad, "ff".repeat(32)).unwrap();
    let bad = bad.to_str().unwrap();
    let none = folder.path().join("none").to_str().unwrap().to_owned();
    let capture = key.as_str();
    for (arguments, status, text) in [
        (&["erase", "models"][..], 2, "needs --key"),
        (&["--key", &none, "erase", "models"], 3, "the key cannot be read"),
        (&["--key", bad, "erase", "models"], 2, "64 hexadecimal digits"),
        (&["survey", "--within", "0"], 2, "within_s"),
        (&["stream", "--bandwidth", "1"], 2, "stream.bytes_per_s"),
        (&["stream", "--every", "70000"], 2, "70000"),
        (&["nonsense"], 2, "nonsense"),
        (&["stop-recording"], 2, "a capture takes no commands"),
    ] {
        let said = mwd(&[&["command", capture], arguments].concat());
        assert_eq!(said.status, status, "{arguments:?} {}", said.error);
        assert!(said.error.contains(text), "{arguments:?} {}", said.error);
    }
}

#[test]
fn a_self_test_that_is_not_passed_or_not_told_has_its_status() {
    let (config, samples) = flown::recording("broad_06");
    let passed = SelfTest {
        gravity_mm_s2: Some(9_810),
        field_nt: Some(48_000),
        storage_holds: Some(true),
        turns_seen: TurnFlags::all(),
        ..SelfTest::default()
    };
    let turned = SelfTest { turns_wrong: TurnFlags::X_BY_MAG, ..passed };
    for (self_test, status, out, error) in [
        (Some(passed), 0, "accepted\npassed: ", ""),
        (Some(turned), 2, "accepted\nfailed: ", "the probe did not pass the self-test"),
        (None, 3, "accepted\n", "the self-test's findings did not come within 10 s"),
    ] {
        let manner = Manner { self_test, ..Manner::default() };
        let (place, probe) = played_probe::start(config, samples.clone(), manner, 1);
        let said = mwd(&["command", &place, "self-test"]);
        assert_eq!(said.status, status, "{} {}", said.out, said.error);
        assert!(said.out.starts_with(out) && said.error.contains(error), "{} {}", said.out, said.error);
        assert_eq!(probe.join().unwrap().carried_out, [Command::SelfTest]);
    }
}

#[test]
fn a_port_that_is_not_there_is_missing_and_a_name_that_is_none_is_a_mistake() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(at("empty"), "").unwrap();
    fs::write(at("noise"), [7; 500]).unwrap();
    // A port that was free a moment ago: nobody listens there.
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let out = at("t.csv");
    for (place, status) in [
        ("/dev/no-such-port".to_owned(), 3),
        (format!("tcp:{free}"), 3),
        (format!("unix:{}", at("no.sock")), 3),
        ("tcp:nowhere".to_owned(), 2),
        (at("nothing"), 2),
        (at(""), 2),
        (at("empty"), 2),
        (at("noise"), 2),
    ] {
        let record = mwd(&["record", &place, "-o", &out]);
        assert_eq!(record.status, status, "{place}: {}", record.error);
        let monitor = mwd(&["monitor", &place, "--once", "--seconds", "1"]);
        assert_eq!(monitor.status, status, "{place}: {}", monitor.error);
        assert!(monitor.error.contains(&place), "{}", monitor.error);
    }
    let noise = fs::read(at("noise")).unwrap();
    let twice = mwd(&["record", &at("noise"), "-o", &at("trace.csv"), "--capture", &at("noise")]);
    assert_eq!(twice.status, 2, "{}", twice.error);
    assert_eq!(fs::read(at("noise")).unwrap(), noise, "the capture would have been written over what is read");
    let said = mwd(&["record", &at("noise"), "-o", &at("trace.txt")]);
    assert!(said.status == 2 && said.error.contains(".csv"), "{}", said.error);
}

#[test]
fn the_monitor_says_what_the_probe_says() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.bin");
    let bytes = flown::stream(&config, &samples, AttitudeFormat::Exact);
    fs::write(&path, &bytes).unwrap();
    let flight = testbed::flight::fly(&config, &samples, |_| ()).unwrap();
    let last = flight.outputs.last().unwrap().attitude.unwrap();
    let said = mwd(&["monitor", path.to_str().unwrap()]);
    assert_eq!(said.status, 0, "{}", said.error);
    let of = |name: &str| said.out.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}"));
    assert!(of("probe").contains("firmware 0.1.0, started by PowerOn with the factory's model"));
    let number = |after: &str| -> f32 {
        let rest = of("attitude").split_once(after).unwrap().1;
        rest.split([' ', ',']).next().unwrap().parse().unwrap()
    };
    assert!((number("inclination ") - last.inclination_rad.to_degrees()).abs() < 0.01);
    assert!((number("azimuth ") - last.azimuth_rad.to_degrees()).abs() < 0.01);
    assert!(of("recording").contains(&samples.len().to_string()));
    assert!(of("link").contains(" 0 damaged, 0 oversize, 0 missing"));
    assert!(of("model").contains("window to"));

    let (place, probe) = played_probe::start(config, samples, Manner::default(), 1);
    let said = mwd(&["monitor", &place, "--once", "--seconds", "1"]);
    assert!(said.out.contains("stored model 3") && said.out.contains("health"), "{}{}", said.out, said.error);
    probe.join().unwrap();
}

/// The answers to the announcement, to the comparison and to the restart are lost once each: the announcement is made
/// again, and the probe's own report tells that the other two are done.
#[test]
fn an_update_survives_lost_answers() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let key = key_in(folder.path());
    let image = folder.path().join("program.bin");
    let bytes: Vec<u8> = (0..3_000_u32).map(|k| (k * k / 7) as u8).collect();
    fs::write(&image, &bytes).unwrap();
    let (place, probe) = played_probe::start(config, samples, Manner { loses_answers: true, ..Manner::default() }, 1);
    let image = ["--image", image.to_str().unwrap(), "--number", "2"];
    let said = mwd(&[&["update", &place, "--key", &key, "--deadline", "4"], &image[..]].concat());
    assert_eq!(said.status, 0, "{}{}", said.out, said.error);
    assert!(said.out.contains("program 2: runs and has confirmed itself"), "{}", said.out);
    let log = probe.join().unwrap();
    assert_eq!(log.program, bytes);
    let announced = Command::BeginUpdate { number: 2, length: 3_000, digest: Blake2s256::digest(&bytes).into() };
    assert_eq!(log.carried_out, [announced, announced, Command::FinishUpdate, Command::Restart]);
}

/// A probe whose program is on trial refuses the announcement as busy, and one whose memory is full the first command:
/// both are asked again.
#[test]
fn what_a_probe_cannot_do_yet_is_asked_again() {
    let (config, samples) = flown::recording("broad_06");
    let folder = tempfile::tempdir().unwrap();
    let key = key_in(folder.path());
    let image = folder.path().join("program.bin");
    fs::write(&image, [26; 700]).unwrap();
    let manner = Manner { on_trial: true, full: true, ..Manner::default() };
    let (place, probe) = played_probe::start(config, samples, manner, 1);
    let image = ["--image", image.to_str().unwrap(), "--number", "2"];
    let said = mwd(&[&["update", &place, "--key", &key, "--deadline", "20"], &image[..]].concat());
    assert_eq!(said.status, 0, "{}{}", said.out, said.error);
    assert!(said.out.contains("program 2: runs and has confirmed itself"), "{}", said.out);
    let announced = |command: &&Command| matches!(command, Command::BeginUpdate { .. });
    assert_eq!(probe.join().unwrap().carried_out.iter().filter(announced).count(), 2);
}
