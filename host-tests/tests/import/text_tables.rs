//! Tables of text that are understood without a word from the user.

use meerkat_mwd::{Sample, SampleFlags};
use mwd::import::Verdict;
use tempfile::TempDir;
use testbed::trace::Trace;

use crate::{
    files::{
        Written, accel, flies_as_the_original, gyro, imported, is_told_as_lost, mag, original, rows, si, with_map,
        written,
    },
    rig::program::mwd,
};

const G: f64 = 9.806_65;

#[test]
fn degrees_gauss_and_milliseconds() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(sample.t_us as f64 * 1e-3);
    let g = [0, 1, 2].map(|axis| move |sample: &Sample| gyro(sample, axis).map(f64::to_degrees));
    let a = [0, 1, 2].map(|axis| move |sample: &Sample| accel(sample, axis).map(|x| x / G));
    let m = [0, 1, 2].map(|axis| move |sample: &Sample| mag(sample, axis).map(|x| x / 100.0));
    let columns: [Written; 10] = [
        ("time", &time),
        ("gyr_x", &g[0]),
        ("gyr_y", &g[1]),
        ("gyr_z", &g[2]),
        ("acc_x", &a[0]),
        ("acc_y", &a[1]),
        ("acc_z", &a[2]),
        ("mag_x", &m[0]),
        ("mag_y", &m[1]),
        ("mag_z", &m[2]),
    ];
    // No unit is named: sizes, the step of time and the turning of the field tell them.
    let path = written(&folder, "log.csv", &rows(&original().samples, &columns, ',', '.'));
    let told = imported(&[path]);
    flies_as_the_original(&told);
    assert_eq!(told.map.gyro.unit.as_deref(), Some("deg/s"));
    assert_eq!(told.map.gyro.time_unit.as_deref(), Some("ms"));
}

#[test]
fn decimal_commas_a_preamble_and_a_row_of_units() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(sample.t_us as f64);
    let g = [0, 1, 2].map(|axis| move |sample: &Sample| gyro(sample, axis).map(f64::to_degrees));
    let a = [0, 1, 2].map(|axis| move |sample: &Sample| accel(sample, axis).map(|x| x / G * 1e3));
    let m = [0, 1, 2].map(|axis| move |sample: &Sample| mag(sample, axis).map(|x| x * 1e3));
    let columns: [Written; 10] = [
        ("Zeit t", &time),
        ("gx", &g[0]),
        ("gy", &g[1]),
        ("gz", &g[2]),
        ("ax", &a[0]),
        ("ay", &a[1]),
        ("az", &a[2]),
        ("mx", &m[0]),
        ("my", &m[1]),
        ("mz", &m[2]),
    ];
    let text = rows(&original().samples, &columns, ';', ',');
    let (head, body) = text.split_once('\n').unwrap();
    let text = format!("Logger 7;serial 12\r\n\r\n{head}\r\nus;dps;dps;dps;mg;mg;mg;nT;nT;nT\r\n{body}");
    let told = imported(&[written(&folder, "log.txt", &text)]);
    assert_eq!(told.map.mag.unit.as_deref(), Some("nT"));
    flies_as_the_original(&told);
    // The map that an import saves gives the same trace.
    let again = with_map(&folder.path().join("log.txt"), &told.map.to_toml());
    assert_eq!(again.trace, told.trace);
}

#[test]
fn clock_times() {
    let folder = TempDir::new().unwrap();
    let plain = si([|v| v; 3]);
    let mut text = String::from("clock,gx,gy,gz,ax,ay,az,mx,my,mz\n");
    for (row, sample) in plain.lines().skip(1).zip(&original().samples) {
        // Over midnight.
        let us = sample.t_us + 86_370_000_000 - original().first_us();
        let (s, us) = (us / 1_000_000 % 86_400, us % 1_000_000);
        let cells = row.split_once(',').unwrap().1;
        text += &format!("{:02}:{:02}:{:02}.{us:06},{cells}\n", s / 3_600, s / 60 % 60, s % 60);
    }
    let mut told = imported(&[written(&folder, "log.csv", &text)]);
    let moved = told.trace.first_us() - original().first_us();
    told.trace.samples.iter_mut().for_each(|sample| sample.t_us -= moved);
    flies_as_the_original(&told);
}

/// A trace of this program keeps what only its traces have, and what is not used is told.
#[test]
fn a_trace_keeps_its_flags_and_what_is_not_used_is_told() {
    let folder = TempDir::new().unwrap();
    let count = original().samples.len();
    let flags = |row: usize| if row % 100 == 7 { SampleFlags::FAULT } else { SampleFlags::empty() };
    let mut trace = Trace {
        driver_flags: Some((0..count).map(flags).collect()),
        movement: Some((0..count).map(|row| row > 3_000).collect()),
        rest: Some((0..count).map(|row| row < 2_500).collect()),
        ..original().clone()
    };
    trace.mark_clipped(&trace.keys.full_scale());
    let path = folder.path().join("trace.csv");
    trace.write(&path).unwrap();
    let mut lines: Vec<String> = std::fs::read_to_string(&path).unwrap().lines().map(str::to_owned).collect();
    let head = lines.iter().position(|line| !line.starts_with('#')).unwrap();
    for (row, line) in lines.iter_mut().enumerate().skip(head) {
        // The last column is empty.
        *line += if row == head { ",humidity,volts,spare" } else { ",40,3.3," };
    }
    // A row that is dropped takes its flags with it.
    lines.insert(head + 1_000, lines[head + 999].clone());
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]).trace;
    assert_eq!((told.samples.len(), &told.driver_flags), (count, &trace.driver_flags));
    assert!(told.movement == trace.movement && told.rest == trace.rest);
    assert!(told.samples.iter().zip(&trace.samples).all(|(a, b)| a.flags == b.flags));
    assert!(told.notes.contains(&"columns of log that are not used: humidity, volts".to_owned()), "{:?}", told.notes);
    // A column so named of another logger is not the trace's.
    lines[head] = lines[head].replace("t_s", "time_s");
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]).trace;
    assert_eq!((told.driver_flags, told.movement, told.rest), (None, None, None));
    let note = "columns of log that are not used: movement, rest, sample_flags, humidity, volts";
    assert!(told.notes.contains(&note.to_owned()), "{:?}", told.notes);
}

#[test]
fn repeated_and_late_rows_are_dropped_and_counted() {
    let folder = TempDir::new().unwrap();
    let mut lines: Vec<String> = si([|v| v; 3]).lines().map(str::to_owned).collect();
    lines.insert(2_001, lines[2_000].clone());
    lines.insert(3_000, lines[2_990].clone());
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]);
    assert_eq!(told.dropped(), 2);
    let counted =
        |finding: &mwd::import::Finding| finding.told.contains("2 rows dropped (1 repeat a time, 1 are out of order");
    assert!(told.findings.iter().any(|finding| finding.verdict == Verdict::Note && counted(finding)));
    flies_as_the_original(&told);
}

/// As in a trace: the rows behind it are not late.
#[test]
fn a_time_that_jumps_ahead_is_dropped_with_its_row_alone() {
    let folder = TempDir::new().unwrap();
    let mut lines: Vec<String> = si([|v| v; 3]).lines().map(str::to_owned).collect();
    let rest = lines[2_000].split_once(',').unwrap().1;
    lines[2_000] = format!("9000,{rest}");
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]);
    assert_eq!((told.dropped(), told.trace.len()), (1, original().samples.len() - 1));
    let whole = original().samples.iter().enumerate().filter(|(row, _)| *row != 1_999).map(|(_, sample)| sample.t_us);
    assert!(told.trace.samples.iter().map(|sample| sample.t_us).eq(whole));
    let counted =
        |finding: &mwd::import::Finding| finding.told.contains("1 rows dropped (0 repeat a time, 1 are out of order");
    assert!(told.findings.iter().any(|finding| finding.verdict == Verdict::Note && counted(finding)));
}

#[test]
fn a_text_that_is_cut_off_is_told() {
    let folder = TempDir::new().unwrap();
    let whole = si([|v| v; 3]);
    let path = written(&folder, "log.csv", whole.trim_end().rsplit_once(',').unwrap().0);
    is_told_as_lost(&imported(std::slice::from_ref(&path)), "the last line is cut off");
    let strict = mwd(&["import", path.to_str().unwrap(), "--strict"]);
    let said = String::from_utf8_lossy(&strict.stderr);
    assert!(strict.status.code() == Some(2) && said.contains("the last line is cut off"), "{said}");
}
