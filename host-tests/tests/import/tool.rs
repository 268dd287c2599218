//! The command.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Command, Stdio},
};

use tempfile::TempDir;
use testbed::trace::Trace;

use crate::{
    files::{flies_within, si, written},
    rig::program::mwd,
};

#[test]
fn a_wrong_source_leaves_no_trace_unless_forced_and_a_map_makes_it_right() {
    let folder = TempDir::new().unwrap();
    let source = written(&folder, "log.csv", &si([|[x, y, z]| [y, x, z], |v| v, |v| v]));
    let trace = folder.path().join("trace.csv.gz");
    let run = |more: &[&str]| {
        let mut arguments = vec!["import", source.to_str().unwrap(), "-o", trace.to_str().unwrap()];
        arguments.extend(more);
        mwd(&arguments)
    };
    let refused = run(&[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stdout).contains("WRONG axes of the gyro"));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--force") && !trace.exists());
    assert!(run(&["--force"]).status.success() && trace.exists());
    let map = written(&folder, "map.toml", "[gyro]\ncolumns = ['gy', 'gx', 'gz']\n[keys]\nmotion = 'hand'\n");
    assert!(run(&["--map", map.to_str().unwrap(), "--key", "gravity_m_s2=9.81"]).status.success());
    let read = Trace::read(&trace).unwrap();
    assert_eq!((read.keys.gravity_m_s2, read.keys.motion.is_some()), (Some(9.81), true));
    let saved = fs::read_to_string(folder.path().join("trace.csv.gz.map.toml")).unwrap();
    assert!(saved.contains("columns = [\"gy\", \"gx\", \"gz\"]") && saved.contains("motion = \"hand\""), "{saved}");
    flies_within(&read, 0.01);
    // Neither the source nor a file of the folder that is one.
    let (bytes, logs) = (fs::read(&source).unwrap(), TempDir::new().unwrap());
    let inside = logs.path().join("log.csv");
    fs::write(&inside, &bytes).unwrap();
    for read in [&source, &inside] {
        let named: &Path = if *read == inside { logs.path() } else { read };
        let overwriting =
            mwd(&["import", named.to_str().unwrap(), "--map", map.to_str().unwrap(), "-o", read.to_str().unwrap()]);
        assert_eq!(overwriting.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&overwriting.stderr).contains("would overwrite what it is made of"));
        assert_eq!(fs::read(read).unwrap(), bytes);
    }
}

#[test]
fn the_standard_input_is_a_source_and_strict_keeps_the_error() {
    let folder = TempDir::new().unwrap();
    let mut lines: Vec<String> = si([|v| v; 3]).lines().map(str::to_owned).collect();
    lines.insert(3_000, lines[2_990].clone());
    let run = |more: &[&str]| {
        let trace = folder.path().join("trace.csv");
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.args(["import", "-", "-o", trace.to_str().unwrap()]).args(more);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(lines.join("\n").as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    assert!(run(&[]).status.success());
    let strict = run(&["--strict"]);
    assert_eq!(strict.status.code(), Some(2));
    let told = String::from_utf8_lossy(&strict.stderr);
    assert!(told.contains("1 rows have a repeated, late or missing time"), "{told}");
}

/// A line of a trace's own header that its keys do not take is told, not dropped in silence.
#[test]
fn what_a_traces_header_says_and_no_key_takes_is_told() {
    let folder = TempDir::new().unwrap();
    let text = format!("# gravity = 9.81\n# dip_deg = north\n{}", si([|v| v; 3]));
    let source = written(&folder, "log.csv", &text);
    let trace = folder.path().join("trace.csv");
    let imported = mwd(&["import", source.to_str().unwrap(), "-o", trace.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&imported.stdout);
    for line in [
        "left out of the header of log: gravity = 9.81: no key of a trace's header",
        "\"dip_deg = north\": the value must be a number",
    ] {
        assert!(imported.status.success() && told.contains(line), "{line}: {told}");
    }
}

/// A trace on the standard output is alone there, however the option is written.
#[test]
fn a_trace_on_the_standard_output_is_alone_there() {
    let folder = TempDir::new().unwrap();
    let source = written(&folder, "log.csv", &si([|v| v; 3]));
    for to in [vec!["-o", "-"], vec!["-o-"]] {
        let imported = mwd(&[&["import", source.to_str().unwrap()], to.as_slice()].concat());
        let told = String::from_utf8_lossy(&imported.stdout);
        assert!(imported.status.success() && told.starts_with("# "), "{to:?}: {:.200}", told);
        let is_row = |line: &str| line.starts_with(['#', 't', '-']) || line.starts_with(|c: char| c.is_ascii_digit());
        assert!(told.lines().all(is_row), "{to:?}");
    }
}
