//! Troubled traces through the program: status 0, no NaN in any file, and the trouble named.

use std::{
    fs,
    process::{Command, Output},
};

use meerkat_mwd::{Sample, SampleFlags};
use serde_json::Value;
use tempfile::TempDir;
use testbed::trace::Trace;

use crate::rig::run::{Dice, run, saturated};

struct Replayed {
    output: Output,
    json: Value,
    rows: usize,
}

impl Replayed {
    fn summary(&self) -> String {
        String::from_utf8(self.output.stdout.clone()).unwrap()
    }

    /// The reason of the first window, or the note where there is none.
    fn why(&self) -> &str {
        let identification = &self.json["identification"];
        identification["windows"].get(0).map_or(&identification["note"], |w| &w["reason"]).as_str().unwrap()
    }
}

/// Replays samples with every output asked for; every cell is empty or finite.
fn replayed(trace: &Trace, samples: Vec<Sample>, more: &[&str]) -> Replayed {
    let directory = TempDir::new().unwrap();
    let path = |name: &str| directory.path().join(name);
    let reference = if samples.len() == trace.samples.len() { trace.reference.clone() } else { Vec::new() };
    let troubled = Trace { samples, reference, true_rate: None, ..trace.clone() };
    troubled.write(&path("trace.csv.gz")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
    command.arg("replay").arg(path("trace.csv.gz")).args(more);
    for (option, name) in [("--attitude", "attitude.csv"), ("--rates", "rates.csv"), ("--json", "result.json")] {
        command.arg(option).arg(path(name));
    }
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
    let mut rows = 0;
    for (name, columns) in [("attitude.csv", 13), ("rates.csv", 4)] {
        let text = fs::read_to_string(path(name)).unwrap();
        rows = text.lines().skip(1).count();
        for line in text.lines().skip(1) {
            assert_eq!(line.split(',').count(), columns);
            let finite = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok_and(f64::is_finite);
            assert!(line.split(',').all(finite), "{line}");
        }
        assert_eq!(rows, troubled.samples.len());
    }
    let text = fs::read_to_string(path("result.json")).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let summary = String::from_utf8_lossy(&output.stdout);
    assert!(!summary.contains("NaN") && !summary.contains("inf"), "{summary}");
    assert_numbers(&json["identification"]["final"]);
    Replayed { output, json, rows }
}

/// Parameters of the flown model are all numbers; a NaN would have become a null.
fn assert_numbers(parameters: &Value) {
    for name in ["P", "b_rad_s", "sigma"] {
        assert!(parameters[name].as_array().unwrap().iter().all(Value::is_number), "{parameters}");
    }
}

#[test]
fn a_trace_shorter_than_a_window_says_so_with_and_without_hold_out() {
    let run = run(30.0, 1);
    for (more, why) in [
        (&[][..], "the trace lasts 30.0 s; a window takes 50.0 s"),
        (&["--hold-out", "0.5"], "of motion with a usable gyro since the start, 4.5 s are needed"),
        (&["--hold-out", "0.97"], "before the hold-out lasts 0.9 s; the result of a window takes 1.0 s"),
    ] {
        let replayed = replayed(&run.trace, run.trace.samples.clone(), more);
        assert!(replayed.why().contains(why), "{more:?}: {}", replayed.why());
        assert!(replayed.summary().contains(why), "{}", replayed.summary());
        assert_eq!(replayed.json["identification"]["final"]["rank"], 0);
    }
}

#[test]
fn one_sample_is_a_trace() {
    let run = run(1.0, 1);
    for more in [&[][..], &["--hold-out", "0.5"]] {
        let replayed = replayed(&run.trace, run.trace.samples[..1].to_vec(), more);
        assert!(replayed.why().contains("no window"), "{}", replayed.why());
        assert_eq!(replayed.rows, 1);
    }
}

#[test]
fn dead_sensors_are_named() {
    let run = run(60.0, 3);
    let first = run.trace.samples[0];
    let gyro = replayed(&run.trace, run.with(|_, s| s.gyro_rad_s = first.gyro_rad_s), &[]);
    assert!(gyro.why().contains("the gyro gives too few usable readings: 99 %"), "{}", gyro.why());
    let accel = replayed(&run.trace, run.with(|_, s| s.accel_m_s2 = first.accel_m_s2), &[]);
    assert!(accel.why().contains("no usable accelerometer reading"), "{}", accel.why());
    for dead in [gyro, accel] {
        assert_eq!(dead.json["identification"]["final"]["P"][0], 1.0);
        assert_eq!(dead.json["identification"]["windows"][0]["accepted"], false);
    }
}

#[test]
fn rows_cells_and_seconds_that_are_missing_are_counted() {
    let run = run(60.0, 3);
    let mut dice = Dice::new(1);
    let thinned: Vec<Sample> = run.trace.samples.iter().filter(|_| dice.roll() >= 0.1).copied().collect();
    let rows = replayed(&run.trace, thinned, &[]);
    let gaps = rows.json["trace"]["gaps"].as_u64().unwrap();
    assert!(gaps > 0 && rows.summary().contains(&format!("{gaps} gaps in time")));
    assert_eq!(rows.json["identification"]["windows"].as_array().unwrap().len(), 1, "a gap cuts no window");

    let cells = run.with(|_, s| s.flags.set(SampleFlags::GYRO_MISSING, dice.roll() < 0.1));
    let missing = cells.iter().filter(|s| s.flags.contains(SampleFlags::GYRO_MISSING)).count();
    let cells = replayed(&run.trace, cells, &[]);
    assert_eq!(cells.json["trace"]["missing"]["gyro"], missing);
    assert!(cells.summary().contains(&format!("{missing} samples without gyro")));
    assert_eq!(cells.json["identification"]["windows"][0]["accepted"], true);

    let gap = |s: &&Sample| !(30_000_000..33_000_000).contains(&s.t_us);
    let gap = replayed(&run.trace, run.trace.samples.iter().filter(gap).copied().collect(), &["--hold-out", "0.2"]);
    assert_eq!(gap.json["trace"]["gaps"], 1);
    let windows = gap.json["identification"]["windows"].as_array().unwrap();
    assert_eq!((windows.len(), &windows[0]["t_end_s"]), (1, &47.0.into()));
    assert!(windows[0]["window_note"].as_str().unwrap().contains("shorter than the configured"));
}

#[test]
fn clipping_is_counted_where_the_full_scale_is_known() {
    let run = run(60.0, 3);
    let trace = Trace {
        keys: testbed::trace::Keys { gyro_full_scale_rad_s: Some(5.2), ..run.trace.keys.clone() },
        ..run.trace.clone()
    };
    let clipped = replayed(&trace, run.with(|_, s| s.gyro_rad_s = saturated(s.gyro_rad_s, 5.2)), &[]);
    let count = clipped.json["trace"]["clipped"].as_u64().unwrap();
    assert!(count > 100 && clipped.summary().contains(&format!("{count} clipped samples")));
}

#[test]
fn the_bundled_recording_survives_the_same() {
    let trace = Trace::read(&mwd::commands::main_job::recording()).unwrap();
    let change = |f: &dyn Fn(usize, &mut Sample)| {
        let mut samples = trace.samples.clone();
        samples.iter_mut().enumerate().for_each(|(index, sample)| f(index, sample));
        samples
    };
    let middle = trace.samples.len() / 2;
    let kept = trace.samples[middle];
    let dead_gyro = change(&|index, s| s.gyro_rad_s = if index >= middle { kept.gyro_rad_s } else { s.gyro_rad_s });
    assert!(!replayed(&trace, dead_gyro, &[]).json["identification"]["windows"].as_array().unwrap().is_empty());
    for samples in [
        change(&|_, s| s.mag_ut = [0.0; 3]),
        change(&|index, s| s.accel_m_s2 = if index >= middle { kept.accel_m_s2 } else { s.accel_m_s2 }),
        change(&|index, s| s.mag_ut = if index >= middle { kept.mag_ut } else { s.mag_ut }),
        change(&|index, s| s.flags.set(SampleFlags::ACCEL_MISSING, index % 10 == 0)),
    ] {
        let replayed = replayed(&trace, samples, &["--hold-out", "0.3"]);
        let score =
            |model: &str| replayed.json["reference"]["orientation_2s_rms_time_aligned_deg"][model].as_f64().unwrap();
        let [flown, bias_only] = [score("with_effects"), score("bias_only")];
        assert!(flown <= 1.05 * bias_only, "{flown} deg, {bias_only} with the bias alone");
    }
    let mut dice = Dice::new(1);
    let thinned: Vec<Sample> = trace.samples.iter().filter(|_| dice.roll() >= 0.1).copied().collect();
    let replayed = replayed(&trace, thinned, &["--hold-out", "0.5"]);
    assert!(replayed.json["trace"]["gaps"].as_u64().unwrap() > 0);
}
