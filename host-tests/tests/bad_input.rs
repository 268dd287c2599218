//! Traces and configurations that cannot be used: each error names what, and where; the program ends with status 2.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use flate2::{Compression, write::GzEncoder};
use meerkat_mwd::{
    Config,
    config::{FullScale, Latency},
};
use tempfile::TempDir;
use testbed::trace::Trace;

const HEADER: &str = "t_s,gx,gy,gz,ax,ay,az";
const ROW: &str = "0.01,0,0,0,0,0,9.8";

fn replay(trace: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mwd")).arg("replay").arg(trace).output().unwrap()
}

fn file(directory: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Error message without the file's name, which is checked; nothing may be on standard output.
fn refused(trace: &Path) -> String {
    let output = replay(trace);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty());
    let message = String::from_utf8(output.stderr).unwrap();
    let start = format!("error: {}", trace.display());
    assert!(message.starts_with(&start), "{message}");
    // Remedy, on a line of its own after the message: cut off here.
    let message = &message[start.len()..];
    message.split_once("\nnext: ").map_or(message, |(message, _)| message).trim_end().to_owned()
}

fn refused_text(text: &str) -> String {
    let directory = TempDir::new().unwrap();
    let plain = refused(&file(&directory, "trace.csv", text.as_bytes()));
    let compressed = refused(&file(&directory, "trace.csv.gz", &gzip(text.as_bytes())));
    assert_eq!(plain, compressed);
    plain
}

#[test]
fn a_wrong_path_and_a_directory_are_named() {
    let directory = TempDir::new().unwrap();
    assert!(refused(&directory.path().join("nothing.csv")).starts_with(": cannot be opened: "));
    assert!(refused(directory.path()).starts_with(": cannot be read: "));
}

#[test]
fn a_message_says_what_can_be_done() {
    let directory = TempDir::new().unwrap();
    let next = |path: &Path| {
        let message = String::from_utf8(replay(path).stderr).unwrap();
        message.split_once("\nnext: ").map(|(_, next)| next.to_owned()).unwrap()
    };
    assert!(next(&directory.path().join("nothing.csv")).contains("host-tests/traces"));
    assert!(next(&file(&directory, "log.csv", b"time;gyro x\n1;2\n")).contains("cargo mwd import FILE"));
}

#[test]
fn an_empty_file_is_called_empty() {
    let directory = TempDir::new().unwrap();
    for name in ["trace.csv", "trace.csv.gz"] {
        assert_eq!(refused(&file(&directory, name, b"")), ": the file is empty");
    }
}

#[test]
fn a_header_without_samples_is_an_empty_trace() {
    let expected = ": the trace is empty: no sample follows the header row";
    for text in [HEADER.to_owned(), format!("# source = x\n{HEADER}\n"), format!("{HEADER}\r\n\r\n")] {
        assert_eq!(refused_text(&text), expected);
    }
}

#[test]
fn a_file_without_a_header_row_says_so() {
    assert!(refused_text(&format!("{ROW}\n{ROW}\n")).starts_with(", line 1: no header row"));
    assert!(refused_text("# source = x\n\nhello world\n").starts_with(", line 3: no header row"));
    assert!(refused_text("# source = x\n").starts_with(": no header row"));
}

#[test]
fn a_missing_column_is_named_and_so_is_a_part_of_an_optional_group() {
    for (header, column) in [
        ("time,gx,gy,gz,ax,ay,az", "t_s"),
        ("t_s,gx,gz,ax,ay,az", "gy"),
        ("t_s,gx,gy,gz", "ax"),
        ("t_s,gx,gy,gz,ax,ay,az,mx,my", "mz"),
        ("t_s,gx,gy,gz,ax,ay,az,qx,qy,qz", "qw"),
        ("t_s,gx,gy,gz,ax,ay,az,wx_true", "wy_true"),
    ] {
        assert_eq!(refused_text(&format!("{header}\n")), format!(", line 1, column {column}: the column is missing"));
    }
    assert_eq!(refused_text("t_s,gx,gx,gy,gz,ax,ay,az\n"), ", line 1, column gx: the column is there twice");
}

#[test]
fn a_cell_that_is_no_finite_number_is_quoted_with_its_line_and_column() {
    let with = |row: &str| refused_text(&format!("# source = x\n{HEADER}\n{ROW}\n\n{row}\n"));
    assert_eq!(with("0.02,0,1.2.3,0,0,0,9.8"), r#", line 5, column gy: "1.2.3" is not a number"#);
    assert_eq!(with("0.02,0,0,0,0,0,down"), r#", line 5, column az: "down" is not a number"#);
    assert_eq!(with("later,0,0,0,0,0,9.8"), r#", line 5, column t_s: "later" is not a number"#);
    assert_eq!(with("0.02,0,0,NaN,0,0,9.8"), r#", line 5, column gz: "NaN" is not a finite number"#);
    assert_eq!(with("0.02,0,0,0,-inf,0,9.8"), r#", line 5, column ax: "-inf" is not a finite number"#);
    assert_eq!(with("0.02,0,0,0,1e39,0,9.8"), r#", line 5, column ax: "1e39" is not a finite number"#);
    assert_eq!(with("nan,0,0,0,0,0,9.8"), r#", line 5, column t_s: "nan" is not a finite number"#);
    let long = with(&format!("0.02,{},0,0,0,0,9.8", "x".repeat(5_000)));
    assert!(long.len() < 100, "{long}");
}

#[test]
fn optional_columns_are_read_as_strictly() {
    let with = |row: &str| refused_text(&format!("{HEADER},mx,my,mz,temp_c,qw,qx,qy,qz,movement\n{ROW},{row}\n"));
    assert_eq!(with("0,x,0,20,1,0,0,0,1"), r#", line 2, column my: "x" is not a number"#);
    assert_eq!(with("0,0,0,warm,1,0,0,0,1"), r#", line 2, column temp_c: "warm" is not a number"#);
    assert_eq!(with("0,0,0,20,1,0,inf,0,1"), r#", line 2, column qy: "inf" is not a finite number"#);
    assert_eq!(with("0,0,0,20,1,0,0,0,yes"), r#", line 2, column movement: "yes" is not a number"#);
}

#[test]
fn time_must_be_there_and_increase() {
    let after = |time: &str| refused_text(&format!("{HEADER}\n{ROW}\n{time},0,0,0,0,0,9.8\n"));
    // Half of all rows: the clock is wrong, and not one packet late.
    assert_eq!(after("0.009"), ", line 3, column t_s: time goes back: 0.009000 s after 0.010000 s");
    assert_eq!(after("0.0100"), ", line 3, column t_s: time repeats: 0.010000 s is the time of the row before");
    // The same microsecond in different texts.
    assert!(after("0.0100004").starts_with(", line 3, column t_s: time repeats"));
    assert_eq!(after(""), ", line 3, column t_s: the time is missing");
    assert_eq!(after("-1"), r#", line 3, column t_s: time "-1" is negative or too large"#);
}

/// A few repeated and late rows cost themselves; the flight is that without them.
#[test]
fn repeated_and_late_rows_are_dropped_and_counted_unless_strict() {
    let directory = TempDir::new().unwrap();
    let rows: Vec<String> = (1..400).map(|i| format!("{}.{:02},0.0{},0,0,0,0,9.8", i / 100, i % 100, i % 7)).collect();
    let mut spoilt = rows.clone();
    spoilt.insert(200, rows[199].clone());
    spoilt.insert(300, rows[290].clone());
    let mut results = Vec::new();
    for (name, rows) in [("plain", &rows), ("spoilt", &spoilt)] {
        let trace = file(&directory, &format!("{name}.csv"), format!("{HEADER}\n{}\n", rows.join("\n")).as_bytes());
        let (json, attitude) = (directory.path().join("out.json"), directory.path().join("out.csv"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.arg("replay").arg(&trace).arg("--json").arg(&json).arg("--attitude").arg(&attitude);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let result: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
        results.push((result["trace"]["dropped"].clone(), fs::read(attitude).unwrap(), output.stdout));
    }
    assert_eq!(results[0].0, serde_json::json!({"repeated": 0, "late": 0}));
    assert_eq!(results[1].0, serde_json::json!({"repeated": 1, "late": 1}));
    assert_eq!(results[0].1, results[1].1);
    let told = String::from_utf8(results[1].2.clone()).unwrap();
    assert!(told.contains("2 rows dropped: 1 repeat a time, 1 are out of order; the first in line 202"), "{told}");
    let mut strict = Command::new(env!("CARGO_BIN_EXE_mwd"));
    let strict = strict.arg("replay").arg(directory.path().join("spoilt.csv")).arg("--strict").output().unwrap();
    assert_eq!(strict.status.code(), Some(2));
    assert!(String::from_utf8(strict.stderr).unwrap().contains("line 202, column t_s: time repeats"));
}

#[test]
fn a_ragged_row_is_counted() {
    let with = |row: &str| refused_text(&format!("{HEADER}\n{row}\n"));
    assert_eq!(with("0.01,0,0,0,0,0"), ", line 2: 6 cells where the header row has 7");
    assert_eq!(with("0.01,0,0,0,0,0,9.8,"), ", line 2: 8 cells where the header row has 7");
}

#[test]
fn a_truncated_gzip_is_told_from_a_damaged_one() {
    let rows: String = (1..5_000).map(|i| format!("{}.{:03},0,{i}e-4,0,0,0,9.8\n", i / 1000, i % 1000)).collect();
    let bytes = gzip(format!("{HEADER}\n{rows}").as_bytes());
    let directory = TempDir::new().unwrap();
    for cut in [1, 5, 12, bytes.len() / 2, bytes.len() - 1] {
        let message = refused(&file(&directory, "cut.csv.gz", &bytes[..cut]));
        assert!(
            message.starts_with(", line ") && message.ends_with(": the gzip file is truncated"),
            "{cut}: {message}"
        );
    }
    let mut damaged = bytes.clone();
    let checksum = bytes.len() - 6;
    damaged[checksum] ^= 0x55;
    let message = refused(&file(&directory, "damaged.csv.gz", &damaged));
    assert!(message.starts_with(", line 5001: the gzip file is damaged"), "{message}");
    let message = refused(&file(&directory, "plain.csv.gz", format!("{HEADER}\n{rows}").as_bytes()));
    assert!(message.starts_with(", line 1: the gzip file is damaged"), "{message}");
}

#[test]
fn what_is_not_text_is_refused() {
    let directory = TempDir::new().unwrap();
    let mut bytes = format!("{HEADER}\n{ROW}\n").into_bytes();
    bytes.extend(b"0.02,0,\xff,0,0,0,9.8\n");
    assert_eq!(refused(&file(&directory, "bytes.csv", &bytes)), ", line 3: byte 8 of the line is not UTF-8 text");
    let zeros = refused(&file(&directory, "zeros.csv.gz", &gzip(&vec![0; 10_000_000])));
    assert!(zeros.starts_with(", line 1: the line is longer than"), "{zeros}");
}

#[test]
fn a_header_key_with_an_unusable_value_is_quoted() {
    let with = |line: &str| refused_text(&format!("# source = x\n# {line}\n{HEADER}\n{ROW}\n"));
    assert_eq!(
        with("gravity_m_s2 = heavy"),
        r#", line 2: "gravity_m_s2 = heavy": the value must be a positive number"#
    );
    assert_eq!(with("dip_deg = 91"), r#", line 2: "dip_deg = 91": the value must be a number from -90 to 90"#);
    assert_eq!(with("earth_frame = NUE"), r#", line 2: "earth_frame = NUE": the value must be NED, ENU or NWU"#);
    assert!(with("body_frame = left").ends_with("must be tool or sensor"));
    assert_eq!(with("motion = robot"), r#", line 2: "motion = robot": the value must be hand or drill_string"#);
    assert!(with("reference_north = maybe").ends_with("must be true or false"));
    assert!(with("gyro_full_scale_rad_s = 0").ends_with("must be a positive number"));
    assert!(with("latitude_deg = NaN").ends_with("must be a number from -90 to 90"));
}

#[test]
fn a_header_key_beyond_what_the_pipeline_takes_names_the_trace() {
    let refused = refused_text(&format!("# gravity_m_s2 = 3.7\n{HEADER}\n{ROW}\n"));
    assert_eq!(refused, ": configuration: earth.gravity_m_s2 must be 9.0 to 10.5");
}

#[test]
fn a_sample_rate_that_the_pipeline_cannot_take_is_refused_by_name() {
    let directory = TempDir::new().unwrap();
    let rows: String = (0..10).map(|i| format!("{i},0,0,0,0,0,9.8\n")).collect();
    let output = replay(&file(&directory, "slow.csv", format!("{HEADER}\n{rows}").as_bytes()));
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("the median step of the trace is 1 s"));
    // Beyond 32 bits of microseconds, and with the unit that it looks like.
    let rows: String = (0..10).map(|i| format!("{},0,0,0,0,0,9.8\n", 5_000_000 * i)).collect();
    let told = refused_text(&format!("{HEADER}\n{rows}"));
    assert!(told.ends_with("is 5000000 s; t_s looks like nanoseconds: t_s is in seconds"), "{told}");
}

/// One time that jumps ahead costs its own row, and no other.
#[test]
fn a_time_that_jumps_ahead_is_dropped_with_its_row_alone() {
    let directory = TempDir::new().unwrap();
    let text = |ahead: Option<usize>, count: usize| {
        let row = |i: usize| {
            let seconds = if ahead == Some(i) { 9_000 } else { i / 100 };
            format!("{seconds}.{:02},0.0{},0,0,0,0,9.8\n", i % 100, i % 7)
        };
        format!("{HEADER}\n{}", (0..count).map(row).collect::<String>())
    };
    for (ahead, count) in [(300, 400), (8_191, 9_000), (8_192, 9_000)] {
        let path = file(&directory, "ahead.csv", text(Some(ahead), count).as_bytes());
        let expected: Vec<_> = Trace::of_bytes(text(None, count).as_bytes()).unwrap().samples;
        let expected: Vec<_> = expected.iter().enumerate().filter(|(i, _)| *i != ahead).map(|(_, s)| *s).collect();
        for trace in [Trace::read(&path).unwrap(), Trace::spooled(&path).unwrap()] {
            assert_eq!((trace.dropped.repeated, trace.dropped.late), (0, 1));
            assert_eq!(trace.samples().collect::<Vec<_>>(), expected);
            assert_eq!(trace.facts().gaps, 0);
            assert!(trace.none_dropped().unwrap_err().to_string().contains("time jumps ahead: 9000."));
        }
    }
    // A clock that goes on from there is one gap.
    let after: String = (0..400)
        .map(|i| format!("{}.{:02},0,0,0,0,0,9.8\n", i / 100 + if i < 300 { 0 } else { 50 }, i % 100))
        .collect();
    let trace = Trace::of_bytes(format!("{HEADER}\n{after}").as_bytes()).unwrap();
    assert_eq!((trace.len(), trace.dropped.all(), trace.facts().gaps), (400, 0, 1));
}

/// Replaces the `left`-th float of a value by NaN. Returns its path, and counts down the floats before it.
fn spoil(value: &mut toml::Value, path: &str, left: &mut usize) -> Option<String> {
    match value {
        toml::Value::Float(float) if *left == 0 => {
            *float = f64::NAN;
            Some(path.to_owned())
        }
        toml::Value::Float(_) => {
            *left -= 1;
            None
        }
        toml::Value::Array(elements) => elements.iter_mut().find_map(|element| spoil(element, path, left)),
        toml::Value::Table(table) => table.iter_mut().find_map(|(key, value)| {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            spoil(value, &path, left)
        }),
        _ => None,
    }
}

#[test]
fn every_number_of_a_configuration_that_is_none_is_refused_by_its_name() {
    let mut config = Config {
        full_scale: FullScale { gyro_rad_s: Some(30.0), accel_m_s2: Some(150.0), mag_ut: Some(800.0) },
        latency: Latency { gyro_s: Some(0.01), accel_s: Some(0.01), mag_s: Some(0.01) },
        ..Config::default()
    };
    let earth = &mut config.earth;
    (earth.magnetic_field_ut, earth.dip_rad) = (Some(50.0), Some(1.0));
    (earth.declination_rad, earth.latitude_rad) = (Some(0.1), Some(0.8));
    config.survey.grid_convergence_rad = Some(0.1);
    assert_eq!(config.validate(), Ok(()));
    let sound = toml::Value::try_from(config).unwrap();
    let mut count = 0;
    loop {
        let (mut spoilt, mut left) = (sound.clone(), count);
        let Some(path) = spoil(&mut spoilt, "", &mut left) else { break };
        let config: Config = spoilt.try_into().unwrap();
        let error = config.validate().err().unwrap_or_else(|| panic!("{path} may be NaN"));
        assert!(path == error.field || path.starts_with(&format!("{}.", error.field)), "{path}: {}", error.field);
        count += 1;
    }
    // Twelve and twice twelve of the three models, and the settings.
    assert!(count > 36 + 50, "{count}");
}
