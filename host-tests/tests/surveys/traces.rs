//! A trace with stops becomes a path: surveys at rest, depths of the bit by another clock.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use meerkat_mwd::SampleFlags;
use tempfile::TempDir;
use testbed::{
    simulate::{Scenario, simulate},
    trace::Trace,
};

const RUN: &str = "latitude_deg = 60.0\nlongitude_deg = 2.0\ndate = \"2026-06-01\"\n[reference]\nmodel = \"fixed\"\n\
                   name = \"simulated\"\ndate = \"2026-06-01\"\nfield_nt = 50000\ndip_deg = 65\ndeclination_deg = 0\n\
                   gravity_m_s2 = 9.80665\n";
/// Depth of the bit at the clock's zero, and how fast it goes down, m/s.
const DEPTH: [f64; 2] = [1_000.0, 0.1];

/// A trace that rests for so long at its start, drills, and rests from `stop_s` on; the run's settings; the depth file,
/// of times from `from_s` to 200 s.
fn files(folder: &TempDir, rest_s: f64, stop_s: Option<f64>, from_s: f64) -> [PathBuf; 3] {
    let [trace, run, depth] = ["trace.csv", "run.toml", "depth.csv"].map(|name| folder.path().join(name));
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/drilling_45deg.toml");
    let scenario = Scenario { duration_s: 90.0, rest_s, stop_s, ..Scenario::read(&scenario).unwrap() };
    simulate(&scenario, 4).0.write(&trace).unwrap();
    fs::write(&run, RUN).unwrap();
    let row = |t_s: f64| format!("{t_s},{}\n", DEPTH[0] + DEPTH[1] * t_s);
    fs::write(&depth, format!("t_s,md_m\n{}{}", row(from_s), row(200.0))).unwrap();
    [trace, run, depth]
}

fn survey([trace, run]: [&Path; 2], more: &[&str]) -> Output {
    let mut mwd = Command::new(env!("CARGO_BIN_EXE_mwd"));
    mwd.arg("survey").arg(trace).arg("--run").arg(run).args(more).output().unwrap()
}

/// Measured depth, inclination and azimuth of each station.
fn stations(csv: &Path) -> Vec<[f64; 3]> {
    let text = fs::read_to_string(csv).unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
    text.lines().skip(1).map(row).collect()
}

#[test]
fn stops_of_a_trace_get_the_tools_depth_by_the_tools_clock_and_the_holes_direction() {
    let folder = TempDir::new().unwrap();
    let [trace, run, depth] = files(&folder, 25.0, Some(65.0), -50.0);
    let csv = folder.path().join("plain.csv");
    let depth = depth.display().to_string();
    let out = csv.display().to_string();
    let found = |more: &[&str]| {
        let mut all = vec!["--depth", depth.as_str(), "--plain", out.as_str()];
        all.extend_from_slice(more);
        let output = survey([&trace, &run], &all);
        assert!(output.status.success(), "{output:?}");
        stations(&csv)
    };
    let plain = found(&[]);
    // A survey's middle is between the end of settling and the end of its mean.
    let at = |from_s: f64, to_s: f64| [from_s, to_s].map(|t_s| DEPTH[0] + DEPTH[1] * t_s);
    let spans = [at(5.0, 25.0), at(70.0, 90.0)];
    assert_eq!(plain.len(), spans.len(), "{plain:?}");
    for ([md, inclination, azimuth], [above, below]) in plain.iter().zip(spans) {
        assert!((above..below).contains(md), "{plain:?}");
        // Sensors of the scenario, uncorrected.
        assert!((inclination - 45.0).abs() < 0.2 && (azimuth - 60.0).abs() < 0.5, "{plain:?}");
    }
    // The tool is behind the bit; a depth file whose clock is seven seconds behind the tool's has gone less far.
    for (more, shift_m) in [
        (vec!["--bit-to-tool", "15"], -15.0),
        (vec!["--clock", "7"], -7.0 * DEPTH[1]),
        (vec!["--clock", "-7", "--bit-to-tool", "15"], 7.0 * DEPTH[1] - 15.0),
    ] {
        for (with, without) in found(&more).iter().zip(&plain) {
            assert!((with[0] - without[0] - shift_m).abs() < 2e-3, "{more:?} {with:?} {without:?}");
        }
    }
}

/// A stop's own check and sigma go with its station, and a stop without a field is missed by nobody unsaid.
#[test]
fn what_a_stop_doubts_of_itself_is_told_and_stays_in_its_sigma() {
    let folder = TempDir::new().unwrap();
    let [path, run, depth] = files(&folder, 25.0, Some(65.0), -50.0);
    let depth = depth.display().to_string();
    let json = folder.path().join("run.json");
    let out = json.display().to_string();
    let surveyed = |path: &Path| {
        let output = survey([path, &run], &["--depth", depth.as_str(), "--json", out.as_str()]);
        assert!(output.status.success(), "{output:?}");
        let value: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
        (String::from_utf8(output.stdout).unwrap(), value)
    };
    let (told, value) = surveyed(&path);
    assert!(!told.contains("the stop at") && !told.contains("left out"), "{told}");
    for station in value["stations"].as_array().unwrap() {
        // Two stations are not analysed, and the survey knows its deviation all the same: 0.4 mg are 0.02 deg.
        let sigma = station["sigma_inclination_deg"].as_f64().unwrap();
        assert!((0.01..0.2).contains(&sigma), "{station}");
    }
    let mut trace = Trace::read(&path).unwrap();
    trace.keys.magnetic_field_ut = Some(47.0);
    let last = trace.samples.iter_mut().filter(|sample| sample.t_us > 60_000_000);
    last.for_each(|sample| (sample.mag_ut, sample.flags) = ([0.0; 3], sample.flags | SampleFlags::MAG_MISSING));
    trace.write(&path).unwrap();
    let (told, value) = surveyed(&path);
    assert_eq!(value["stations"].as_array().unwrap().len(), 1);
    assert!(told.contains("s is bad by its field, +") && told.contains("microtesla off the trace's own"), "{told}");
    assert!(told.contains("warning: 1 stops without a usable field are left out"), "{told}");
}

#[test]
fn what_a_trace_lacks_is_told_with_what_mends_it() {
    let folder = TempDir::new().unwrap();
    let refused = |paths: &[PathBuf; 3], with_depth: bool| {
        let depth = paths[2].display().to_string();
        let all = if with_depth { vec!["--depth", depth.as_str()] } else { Vec::new() };
        let output = survey([&paths[0], &paths[1]], &all);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let paths = files(&folder, 4.0, None, -50.0);
    let told = refused(&paths, true);
    assert!(told.contains("no survey at rest: it has no stop") && told.contains("needs 15 s without motion"), "{told}");
    let paths = files(&folder, 25.0, None, 30.0);
    let told = refused(&paths, false);
    assert!(told.contains("has no depth: --depth DEPTH.csv gives"), "{told}");
    let told = refused(&paths, true);
    assert!(told.contains("is outside of") && told.contains("30.0 to 200.0 s") && told.contains("--clock S"), "{told}");
    let paths = files(&folder, 25.0, Some(65.0), -50.0);
    fs::write(&paths[2], "t_s,md_m\n-50,1000\n200,900\n").unwrap();
    let told = refused(&paths, true);
    assert!(told.contains("station 2 at") && told.contains("above an earlier one"), "{told}");
    // Without a magnetometer there are stops, but no surveys of a direction.
    let text = fs::read_to_string(&paths[0]).unwrap();
    let without: String = text.lines().map(|line| without_field(line) + "\n").collect();
    fs::write(&paths[0], without).unwrap();
    let told = refused(&paths, true);
    assert!(told.contains("stops have no usable magnetometer"), "{told}");
}

/// A line of a trace without its columns of the field, which are the eighth to the tenth of the simulation's.
fn without_field(line: &str) -> String {
    if line.starts_with('#') {
        return line.to_owned();
    }
    let kept = line.split(',').enumerate().filter(|(k, _)| !(7..10).contains(k));
    kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(",")
}
