//! Pages of the refusals: each shows what the program prints of a recording that is refused for its reason.
//! `MWD_BLESS=1 cargo test -p host-tests --test guide` writes the lines into the pages.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use meerkat_mwd::{Probe, Sample, SampleFlags, sample::TurnFlags};
use mwd::report::refusal_text::decision_text;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Scenario, simulate},
    trace::Trace,
};

use super::guide;

/// Simulated drilling: 10 s at rest, then a minute's rest of drilling. One window closes in it.
fn drilling() -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/drilling_45deg.toml");
    let mut trace = simulate(&Scenario { duration_s: 62.0, ..Scenario::read(&path).unwrap() }, 1).0;
    trace.reference.clear();
    trace.true_rate = None;
    trace
}

/// Turns two axes of a vector into each other.
fn turn(vector: &mut [f32; 3], [from, to]: [usize; 2], angle_rad: f32) {
    let (sine, cosine) = libm::sincosf(angle_rad);
    let (x, y) = (vector[from], vector[to]);
    vector[from] = cosine * x - sine * y;
    vector[to] = sine * x + cosine * y;
}

/// A recording that is refused, by the name of its page: what is wrong with it, and each sample so changed.
type Spoilt = (&'static str, fn(&mut Trace));

const SPOILT: [Spoilt; 7] = [
    // The first ten seconds again and again.
    ("not_enough_motion", |trace| {
        let rest: Vec<Sample> = trace.samples.iter().take(1_000).copied().collect();
        for (sample, at_rest) in trace.samples.iter_mut().zip(rest.iter().cycle()) {
            *sample = Sample { t_us: sample.t_us, ..*at_rest };
        }
    }),
    ("no_accelerometer", |trace| {
        trace.samples.iter_mut().for_each(|sample| sample.flags |= SampleFlags::ACCEL_MISSING)
    }),
    ("gyro_unusable", |trace| {
        let most = 1.0;
        trace.keys.gyro_full_scale_rad_s = Some(f64::from(most));
        let clipped = |rate: f32| if rate.abs() > most { most.copysign(rate) } else { rate };
        trace.samples.iter_mut().for_each(|sample| sample.gyro_rad_s = sample.gyro_rad_s.map(clipped));
    }),
    ("diverged", |trace| {
        for sample in &mut trace.samples {
            let swing = libm::sinf(sample.t_us as f32 * 1e-6 * core::f32::consts::TAU / 1.3);
            turn(&mut sample.accel_m_s2, [0, 1], swing * 18_f32.to_radians());
        }
    }),
    ("no_magnetometer", |trace| trace.samples.iter_mut().for_each(|sample| sample.flags |= SampleFlags::MAG_MISSING)),
    ("implausible", |trace| {
        trace.samples.iter_mut().for_each(|sample| turn(&mut sample.gyro_rad_s, [2, 0], 12_f32.to_radians()));
    }),
    ("magnetometer_uncalibrated", |trace| {
        trace
            .samples
            .iter_mut()
            .for_each(|sample| sample.mag_ut = [sample.mag_ut[0] + 30.0, sample.mag_ut[1], sample.mag_ut[2] + 20.0]);
    }),
];

/// Lines that the program prints of the verdict and of the window.
fn printed(name: &str, trace: &Trace) -> String {
    let directory = tempfile::TempDir::new().unwrap();
    let path: PathBuf = directory.path().join(format!("{name}.csv"));
    trace.write(&path).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_mwd")).arg("replay").arg(&path).output().unwrap();
    assert!(output.status.success(), "{name}: {output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    let is_shown =
        |line: &&str| line.starts_with("verdict") || line.starts_with("windows") || line.contains(" s  refused: ");
    said.lines().filter(is_shown).map(|line| line.trim_end().to_owned() + "\n").collect()
}

/// The line of a window that closed without its result, because nobody polled.
fn never_polled() -> String {
    let trace = drilling();
    let mut probe = Box::new(Probe::new());
    probe.configure(&of_trace(&trace)).unwrap();
    let report = trace.samples.iter().find_map(|sample| {
        probe.push(sample);
        probe.poll(0)
    });
    decision_text(&report.unwrap().decision) + "\n"
}

/// The decision of a probe whose gyro has its y axis turned round, once a turn has shown it.
fn of_a_turned_axis() -> String {
    let turns = TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG;
    let trace = drilling();
    let mut probe = Box::new(Probe::new());
    probe.configure(&of_trace(&trace)).unwrap();
    probe.mistrust_mounting(turns);
    let report = trace.samples.iter().find_map(|sample| {
        probe.push(sample);
        probe.poll(u32::MAX)
    });
    decision_text(&report.unwrap().decision) + "\n"
}

/// Without its digits: an estimate may move a little, and its words may not.
fn without_digits(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_ascii_digit() && *letter != ' ').collect()
}

#[test]
fn every_page_of_a_refusal_shows_what_the_program_prints() {
    let mut expected: Vec<(&str, String)> = SPOILT
        .iter()
        .map(|(name, spoil)| {
            let mut trace = drilling();
            spoil(&mut trace);
            (*name, printed(name, &trace))
        })
        .collect();
    expected.push(("overrun", never_polled()));
    expected.push(("wrong_mounting", of_a_turned_axis()));
    let count = fs::read_dir(guide().join("refusals")).unwrap().count();
    assert_eq!(expected.len(), count);
    for (name, lines) in expected {
        assert!(lines.contains("refused: "), "{name}: {lines}");
        let path = guide().join(format!("refusals/{name}.md"));
        let page = fs::read_to_string(&path).unwrap();
        let (before, rest) = page.split_once("```text\n").unwrap_or_else(|| panic!("{name} shows nothing"));
        let (shown, after) = rest.split_once("```\n").unwrap();
        if env::var_os("MWD_BLESS").is_some_and(|value| value == "1") {
            fs::write(&path, format!("{before}```text\n{lines}```\n{after}")).unwrap();
        } else {
            assert_eq!(without_digits(shown), without_digits(&lines), "{name}; MWD_BLESS=1 writes it anew");
        }
    }
}
