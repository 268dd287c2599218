//! The three tables: names and kinds of their columns, and their rows from a part.
//!
//! A column is a field of the result's JSON, named by its path with `_` for `.` and for brackets.

use std::path::Path;

use serde_json::{Value, json};

use super::{key::Key, parts::Part};

/// Kind of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// UTF-8 text.
    Text,
    /// A number of things, 64 bits.
    Count,
    /// A double.
    Number,
    /// True or false.
    Flag,
}

use Kind::{Count, Flag, Number, Text};

/// A column: where its value stands in the row, and its kind. `[n]` at the end stands for that many columns.
pub type Column = (&'static str, Kind);

/// One row a recording.
pub const RECORDINGS: &[Column] = &[
    ("path", Text),
    ("hash", Text),
    ("ok", Flag),
    ("error", Text),
    ("windows", Count),
    ("windows_accepted", Count),
    ("stations", Count),
    ("effects", Text),
    ("effects_left", Text),
    ("wrong", Text),
    ("notes", Text),
    ("recording", Text),
    ("trace.serial", Text),
    ("trace.date", Text),
    ("trace.samples", Count),
    ("trace.duration_s", Number),
    ("trace.rate_hz", Number),
    ("trace.gaps", Count),
    ("trace.clipped", Count),
    ("trace.missing.gyro", Count),
    ("trace.missing.accel", Count),
    ("trace.missing.mag", Count),
    ("trace.missing.temp", Count),
    ("trace.missing.reference", Count),
    ("trace.dropped.repeated", Count),
    ("trace.dropped.late", Count),
    ("identification.motion", Text),
    ("identification.motion_from", Text),
    ("identification.note", Text),
    ("identification.hold_out_from_s", Number),
    ("identification.final.P[9]", Number),
    ("identification.final.b_rad_s[3]", Number),
    ("identification.final.sigma[12]", Number),
    ("identification.final.rank", Count),
    ("diagnosis.verdict", Text),
    ("diagnosis.missing", Text),
    ("diagnosis.residual.gravity_deg.before", Number),
    ("diagnosis.residual.gravity_deg.after", Number),
    ("diagnosis.residual.magnetic_deg.before", Number),
    ("diagnosis.residual.magnetic_deg.after", Number),
    ("diagnosis.residual.nis.before", Number),
    ("diagnosis.residual.nis.after", Number),
    ("reference.orientation_2s_rms_deg.uncompensated", Number),
    ("reference.orientation_2s_rms_deg.bias_only", Number),
    ("reference.orientation_2s_rms_deg.twelve_parameters", Number),
    ("reference.orientation_2s_rms_deg.with_effects", Number),
    ("reference.orientation_2s_rms_time_aligned_deg.uncompensated", Number),
    ("reference.orientation_2s_rms_time_aligned_deg.bias_only", Number),
    ("reference.orientation_2s_rms_time_aligned_deg.twelve_parameters", Number),
    ("reference.orientation_2s_rms_time_aligned_deg.with_effects", Number),
    ("reference.time_alignment_ms", Number),
    ("reference.rest_gravity_deg.uncompensated", Number),
    ("reference.rest_gravity_deg.bias_only", Number),
    ("reference.rest_gravity_deg.twelve_parameters", Number),
    ("reference.rest_gravity_deg.with_effects", Number),
    ("reference.attitude_rms_deg.total", Number),
    ("reference.attitude_rms_deg.heading", Number),
    ("reference.attitude_rms_deg.inclination", Number),
];

/// One row a window.
pub const WINDOWS: &[Column] = &[
    ("path", Text),
    ("hash", Text),
    ("window", Count),
    ("t_start_s", Number),
    ("t_end_s", Number),
    ("t_effect_s", Number),
    ("accepted", Flag),
    ("reason", Text),
    ("optimizer", Text),
    ("evaluations", Count),
    ("cost_before", Number),
    ("cost_after", Number),
    ("P[9]", Number),
    ("b_rad_s[3]", Number),
    ("sigma[12]", Number),
    ("rank", Count),
    ("rest_s", Number),
    ("motion_s", Number),
    ("directions_decided", Count),
    ("innovation_nis", Number),
    ("deg_per_turn", Number),
    ("window_note", Text),
];

/// One row a survey; the columns of `--surveys`.
pub const STATIONS: &[Column] = &[
    ("path", Text),
    ("hash", Text),
    ("t_start_s", Number),
    ("t_end_s", Number),
    ("kind", Text),
    ("inclination_deg", Number),
    ("sigma_inclination_deg", Number),
    ("magnetic_azimuth_deg", Number),
    ("sigma_magnetic_azimuth_deg", Number),
    ("true_azimuth_deg", Number),
    ("sigma_true_azimuth_deg", Number),
    ("grid_azimuth_deg", Number),
    ("sigma_grid_azimuth_deg", Number),
    ("gravity_toolface_deg", Number),
    ("sigma_gravity_toolface_deg", Number),
    ("magnetic_toolface_deg", Number),
    ("sigma_magnetic_toolface_deg", Number),
    ("toolface", Text),
    ("gravity_m_s2", Number),
    ("sigma_gravity_m_s2", Number),
    ("field_ut", Number),
    ("sigma_field_ut", Number),
    ("dip_deg", Number),
    ("sigma_dip_deg", Number),
    ("temperature_c", Number),
    ("rotating", Flag),
    ("grade", Text),
    ("reason", Text),
];

/// Columns of a table with lists as single columns: name, path to the value, kind.
pub fn single(columns: &[Column]) -> Vec<(String, String, Kind)> {
    let expand = |&(path, kind): &Column| -> Vec<(String, String, Kind)> {
        match path.strip_suffix(']').and_then(|path| path.split_once('[')) {
            Some((list, count)) => (0..count.parse().unwrap_or(0))
                .map(|index: usize| {
                    (
                        format!("{}_{index}", list.replace('.', "_")),
                        format!("/{}/{index}", list.replace('.', "/")),
                        kind,
                    )
                })
                .collect(),
            None => vec![(path.replace('.', "_"), format!("/{}", path.replace('.', "/")), kind)],
        }
    };
    columns.iter().flat_map(expand).collect()
}

/// Rows of the three tables for a recording.
pub fn rows(path: &Path, key: &Key, part: &Part) -> [Vec<Value>; 3] {
    let own = [("path", json!(path.to_string_lossy())), ("hash", json!(key.text()))];
    let with = |mut row: Value, more: Vec<(&str, Value)>| {
        for (name, value) in own.iter().cloned().chain(more) {
            row[name] = value;
        }
        row
    };
    let windows = part.result["identification"]["windows"].as_array().cloned().unwrap_or_default();
    let surveys = stations(&part.surveys);
    let effects = |which: fn(&Value) -> bool| {
        let all = part.result["diagnosis"]["effects"].as_array().into_iter().flatten();
        all.filter(|effect| which(effect)).filter_map(|effect| effect["name"].as_str()).collect::<Vec<_>>().join(",")
    };
    // Each is a sentence, with commas of its own.
    let sentences = |name: &str| {
        let all = part.result["trace"][name].as_array().into_iter().flatten();
        all.filter_map(Value::as_str).collect::<Vec<_>>().join("\n")
    };
    let accepted = windows.iter().filter(|window| window["accepted"] == true).count();
    let is_ok = part.error.is_none();
    let counted = |value: Value| if is_ok { value } else { Value::Null };
    let recording = with(
        if part.result.is_object() { part.result.clone() } else { json!({}) },
        vec![
            ("ok", json!(is_ok)),
            ("error", json!(part.error)),
            ("windows", counted(json!(windows.len()))),
            ("windows_accepted", counted(json!(accepted))),
            ("stations", counted(json!(surveys.len()))),
            ("effects", counted(json!(effects(|_| true)))),
            ("effects_left", counted(json!(effects(|effect| effect["taken_out"] == false)))),
            ("wrong", counted(json!(sentences("wrong")))),
            ("notes", counted(json!(sentences("notes")))),
            ("recording", json!(part.recording)),
        ],
    );
    let numbered = windows.into_iter().enumerate().map(|(index, window)| with(window, vec![("window", json!(index))]));
    let stations = surveys.into_iter().map(|station| with(station, Vec::new()));
    [vec![recording], numbered.collect(), stations.collect()]
}

/// Rows of a surveys file, each cell by its column's kind.
fn stations(csv: &str) -> Vec<Value> {
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let cell = |name: &str, text: &str| {
        let kind = STATIONS.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind);
        match kind {
            _ if text.is_empty() => Value::Null,
            Some(Number) => text.parse::<f64>().map_or(Value::Null, |value| json!(value)),
            Some(Flag) => json!(text == "1"),
            _ => json!(text),
        }
    };
    lines
        .map(|line| {
            names.iter().zip(line.split(',')).map(|(name, text)| ((*name).to_owned(), cell(name, text))).collect()
        })
        .collect()
}
