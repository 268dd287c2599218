//! Outputs of the probe can be computed again, to the last bit, from what it sent.

use crate::{flown, frames, rig::program::mwd};
use meerkat_mwd::{
    Config, Sample, SampleFlags,
    telemetry::{AttitudeFormat, Boot, Health, Message, ProbeId, RawSample, ResetReason},
};
use mwd::{
    port::recording::{Progress, Recording},
    report::attitude_csv::write_attitude_csv,
};
use std::{fs, path::Path};
use testbed::trace::Trace;

/// Records the bytes of a line, replays the trace, and compares attitude files.
fn recorded_and_replayed(config: &Config, samples: &[Sample]) {
    let bytes = flown::stream(config, samples, AttitudeFormat::Exact);
    let outputs: Vec<_> = frames::messages(&bytes)
        .into_iter()
        .filter_map(|message| if let Message::Output(output) = message { Some(output) } else { None })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    write_attitude_csv(outputs.iter().copied(), Path::new(&at("probe.csv"))).unwrap();
    fs::write(at("line.bin"), &bytes).unwrap();

    let recorded = mwd(&["record", &at("line.bin"), "-o", &at("trace.csv.gz")]);
    assert!(recorded.status.success(), "{}", String::from_utf8_lossy(&recorded.stderr));
    let said = String::from_utf8(recorded.stdout).unwrap();
    assert!(said.contains("0 damaged, 0 oversize, 0 missing"), "{said}");
    let replayed =
        mwd(&["replay", &at("trace.csv.gz"), "--config", &at("trace.toml"), "--attitude", &at("replay.csv")]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    let (probe, replay) = (fs::read(at("probe.csv")).unwrap(), fs::read(at("replay.csv")).unwrap());
    assert!(probe.len() > 1_000);
    assert!(probe == replay, "the attitude differs");
}

#[test]
fn a_recording_replays_to_the_same_attitude() {
    for name in ["broad_06", "multipos_mpu9150_imu0"] {
        let (mut config, samples) = flown::recording(name);
        // Numbers that no short decimal is.
        config.accel.offset = [0.1 + 0.2, -1.0 / 3.0, f32::MIN_POSITIVE];
        config.earth.declination_rad = Some(0.123_456_79);
        config.earth.latitude_rad = None;
        config.seed = 12_345_678_901_234;
        recorded_and_replayed(&config, &samples);
    }
}

/// Missing and frozen sensors, faults, clipping that only the driver knows of, numbers that are none, gaps.
#[test]
fn a_recording_of_troubles_replays_to_the_same_attitude() {
    let (config, mut samples) = flown::recording("broad_06");
    samples.truncate(12_000);
    for (index, sample) in samples.iter_mut().enumerate() {
        match index % 997 {
            100 => sample.gyro_rad_s[1] = f32::NAN,
            200 => sample.accel_m_s2 = [f32::INFINITY, f32::NEG_INFINITY, 0.0],
            300..400 => sample.flags.insert(SampleFlags::MAG_MISSING),
            450 => sample.flags.insert(SampleFlags::ACCEL_MISSING | SampleFlags::GYRO_MISSING),
            500 => sample.gyro_rad_s = [-0.0, 1e-40, f32::MIN_POSITIVE],
            550..560 => sample.mag_ut = [0.0; 3],
            600 => sample.temperature_c = f32::NAN,
            650 => sample.flags.insert(SampleFlags::GYRO_CLIPPED | SampleFlags::FAULT),
            660..664 => sample.flags.insert(SampleFlags::ACCEL_CLIPPED),
            700..900 => sample.t_us += 0,
            _ => {}
        }
        sample.t_us += 2_000_000 * (index as u64 / 5_000);
    }
    recorded_and_replayed(&config, &samples);
}

#[test]
fn damage_and_losses_are_told() {
    let (config, samples) = flown::recording("broad_06");
    let bytes = flown::stream(&config, &samples[..3_000], AttitudeFormat::Compact);
    let mut frames: Vec<Vec<u8>> = bytes[1..].split_inclusive(|&byte| byte == 0).map(<[u8]>::to_vec).collect();
    // Three raw samples, which are every other frame from the second on: one is lost, one damaged, one both
    // is late and was there.
    let sample = |frame: &Vec<u8>| {
        let mut decoder = frames::Decoder::new();
        frames::frames(&mut decoder, frame).first().is_some_and(|(kind, ..)| *kind == 4)
    };
    let places: Vec<usize> = (0..frames.len()).filter(|&index| sample(&frames[index])).collect();
    frames[places[100]][5] ^= 4;
    frames.remove(places[50]);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(at("line.bin"), frames.concat()).unwrap();
    let recorded = mwd(&["record", &at("line.bin"), "-o", &at("trace.csv")]);
    let said = String::from_utf8(recorded.stdout).unwrap();
    assert!(recorded.status.success());
    for text in ["2998 samples", "2 samples were lost on the way", "1 damaged", "2 missing"] {
        assert!(said.contains(text), "{text}: {said}");
    }
    // A second run does not go into the same trace.
    fs::write(at("two.bin"), [&bytes[..], &bytes[..]].concat()).unwrap();
    let recorded = mwd(&["record", &at("two.bin"), "-o", &at("two.csv")]);
    let said = String::from_utf8(recorded.stdout).unwrap();
    assert!(said.contains("3000 samples") && said.contains("started afresh"), "{said}");
}

/// A disk that is full costs the capture, not the samples that came before.
#[test]
fn a_capture_that_cannot_be_written_leaves_the_samples_so_far() {
    if !Path::new("/dev/full").exists() {
        println!("SKIPPED: no /dev/full");
        return;
    }
    let (config, samples) = flown::recording("broad_06");
    let bytes = flown::stream(&config, &samples[..3_000], AttitudeFormat::Compact);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(at("line.bin"), &bytes).unwrap();
    let recorded = mwd(&["record", &at("line.bin"), "-o", &at("trace.csv"), "--capture", "/dev/full"]);
    let said = String::from_utf8(recorded.stderr).unwrap();
    assert_eq!(recorded.status.code(), Some(2), "{said}");
    assert!(said.contains("/dev/full: cannot be written") && said.contains("what came before is in "), "{said}");
    let trace = Trace::read(Path::new(&at("trace.csv"))).unwrap();
    assert!(trace.samples.len() > 10 && trace.samples.len() < 3_000, "{}", trace.samples.len());
}

/// A command that starts the pipeline afresh ends what one configuration can replay, at the sample that it
/// takes effect with.
#[test]
fn a_recording_ends_where_the_pipeline_starts_afresh() {
    let sample = |number| {
        Message::Sample(RawSample { number, sample: Sample { t_us: 1 + u64::from(number), ..Sample::default() } })
    };
    let boot = |first_sample| Message::Boot(Boot { first_sample, ..Boot::new(Config::default()) });
    let mut recording = Recording::default();
    // The second report is the recording's, the third overtakes two samples.
    let said = [boot(0), sample(0), boot(0), sample(1), sample(2), boot(5), sample(3), sample(4)];
    for message in said {
        assert_eq!(recording.take(message), Progress::Goes);
    }
    assert_eq!(recording.take(sample(5)), Progress::Over);
    assert_eq!(recording.trace().samples.len(), 5);
}

/// A reset ends a recording, also where the new run begins with sample 0 again and sends no sample.
#[test]
fn a_recording_ends_where_the_program_starts_afresh() {
    let sample = |number| {
        Message::Sample(RawSample { number, sample: Sample { t_us: 1 + u64::from(number), ..Sample::default() } })
    };
    let health = |s: u64| Message::Health(Health { t_us: s * 1_000_000, ..Health::default() });
    let first = Boot { first_sample: 3, ..Boot::new(Config::default()) };
    let begun = || {
        let mut recording = Recording::default();
        // Reports that overtake each other by no more than a slow line makes them late; the recording's own boot.
        for message in [health(900), Message::Boot(first), sample(7), Message::Boot(first), health(905), health(896)] {
            assert_eq!(recording.take(message), Progress::Goes);
        }
        recording
    };
    let watchdog = Boot { reset: ResetReason::Watchdog, ..first };
    let ends = [
        Message::Boot(watchdog),
        Message::Boot(Boot { watchdog_resets: 1, ..first }),
        Message::Boot(Boot { first_sample: 0, ..first }),
        Message::Boot(Boot { probe: ProbeId([9; 12]), ..first }),
        health(885),
    ];
    for (case, end) in ends.into_iter().enumerate() {
        let mut recording = begun();
        assert_eq!(recording.take(end), Progress::Over, "{case}");
        assert_eq!(recording.trace().samples.len(), 1, "{case}");
    }
    // Before the first sample it is the run that the recording is of.
    let mut recording = Recording::default();
    for message in [health(900), Message::Boot(first), Message::Boot(watchdog), health(1), sample(7)] {
        assert_eq!(recording.take(message), Progress::Goes);
    }
}

/// The bytes that are read stay, whichever of the files to be written has their name, and no two files have one name.
#[test]
fn a_recording_overwrites_neither_what_it_reads_nor_itself() {
    let (config, samples) = flown::recording("broad_06");
    let bytes = flown::stream(&config, &samples[..500], AttitudeFormat::Compact);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let read = "would overwrite what is read";
    for (place, output, capture, told) in [
        ("line.csv", "line.csv", None, read),
        ("line.toml", "line.csv", None, read),
        ("line.model.toml", "line.csv.gz", None, read),
        ("line.bin", "trace.csv", Some("line.bin"), read),
        ("line.bin", "trace.csv", Some("trace.csv"), "would overwrite another one"),
        ("line.bin", "trace.csv", Some("trace.toml"), "would overwrite another one"),
    ] {
        fs::write(at(place), &bytes).unwrap();
        let capture = capture.map(at);
        let mut arguments = vec!["record".to_owned(), at(place), "-o".to_owned(), at(output)];
        arguments.extend(capture.iter().flat_map(|capture| ["--capture".to_owned(), capture.clone()]));
        let recorded = mwd(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let said = String::from_utf8(recorded.stderr).unwrap();
        assert!(recorded.status.code() == Some(2) && said.contains(told), "{arguments:?}: {said}");
        assert!(fs::read(at(place)).unwrap() == bytes, "{arguments:?}");
    }
    // Its own files of before it does write again.
    for _ in 0..2 {
        let recorded = mwd(&["record", &at("line.bin"), "-o", &at("trace.csv"), "--capture", &at("again.bin")]);
        assert!(recorded.status.success(), "{}", String::from_utf8_lossy(&recorded.stderr));
    }
    assert!(fs::read(at("again.bin")).unwrap() == bytes);
}

/// A sender that does not clean its samples.
#[test]
fn readings_that_are_no_numbers_are_missing_and_told() {
    let samples = [
        Sample { t_us: 1, gyro_rad_s: [0.1, f32::NAN, 0.3], ..Sample::default() },
        Sample { t_us: 2, mag_ut: [f32::INFINITY, 0.0, 0.0], accel_m_s2: [0.0, 0.0, -9.8], ..Sample::default() },
        Sample { t_us: 3, gyro_rad_s: [0.1, 0.2, 0.3], temperature_c: 20.0, ..Sample::default() },
    ];
    let mut recording = Recording::default();
    for (number, sample) in (0..).zip(samples) {
        recording.take(Message::Sample(RawSample { number, sample }));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trace.csv");
    let told = recording.write(&path).unwrap();
    let note = "note: readings of 2 samples are no numbers or beyond any sensor, and count as missing";
    assert!(told.iter().any(|line| line == note), "{told:?}");
    let read = Trace::read(&path).unwrap().samples;
    let flags: Vec<SampleFlags> = read.iter().map(|sample| sample.flags).collect();
    assert_eq!(flags, [SampleFlags::GYRO_MISSING, SampleFlags::MAG_MISSING, SampleFlags::empty()]);
    assert_eq!((read[1].accel_m_s2, read[2]), ([0.0, 0.0, -9.8], samples[2]));
}
