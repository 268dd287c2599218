//! Many recordings at once: three tables, a row for a bad file, and a run that goes on where it was killed.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "rig/mod.rs"]
mod rig;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, SystemTime},
};

use parquet::{
    file::reader::{FileReader, SerializedFileReader},
    record::Field,
};
use rig::{files::scenario, program::mwd};
use tempfile::TempDir;
use testbed::simulate::{Scenario, simulate};

/// Recordings of `seconds` with a rest at their start.
fn recordings(folder: &Path, count: u64, seconds: f64) -> Vec<PathBuf> {
    let scenario = Scenario { duration_s: seconds, ..scenario("drilling_45deg") };
    (1..=count)
        .map(|seed| {
            let path = folder.join(format!("run_{seed:02}.csv"));
            simulate(&scenario, seed).0.write(&path).unwrap();
            path
        })
        .collect()
}

/// Rows of a table, each by the names of its columns.
fn table(path: &Path) -> Vec<BTreeMap<String, Field>> {
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap().map(Result::unwrap);
    rows.map(|row| row.get_column_iter().map(|(name, value)| (name.clone(), value.clone())).collect()).collect()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn three_tables_hold_what_replay_says_and_a_bad_file_is_a_row() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let good = recordings(folder.path(), 2, 75.0);
    fs::write(at("bad.csv"), "t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n0.01,0,oops,0,0,0,9.8\n").unwrap();
    fs::create_dir(at("out")).unwrap();
    let results = at("out/all.parquet");
    let list = at("list");
    fs::write(&list, format!("{}\n", text(&at("gone.csv")))).unwrap();
    let pattern = format!("{}/*.csv", text(folder.path()));
    let listed = format!("@{}", text(&list));
    let attitudes = at("attitudes");
    let pages = at("pages");
    let beside = ["--attitude-dir", text(&attitudes), "--html-dir", text(&pages)];
    let output = mwd(&[&["batch", &pattern, &listed, "-o", text(&results)][..], &beside].concat());
    assert!(output.status.success(), "{output:?}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.starts_with("4 recordings: 4 flown now, 0 from before; 2 bad"), "{told}");

    let rows = table(&results);
    let of = |path: &Path| rows.iter().find(|row| row["path"] == Field::Str(text(path).into())).unwrap();
    let error = |path: &Path| of(path)["error"].to_string();
    let told = error(&at("bad.csv"));
    assert!(told.starts_with(r#""line 3, column gy: "oops" is not a number"#), "{told}");
    assert!(error(&at("gone.csv")).contains("cannot be read"));
    assert_eq!(of(&at("bad.csv"))["trace_samples"], Field::Null);
    let windows = table(&at("out/all.windows.parquet"));
    let stations = table(&at("out/all.stations.parquet"));
    for path in &good {
        let (json, attitude, surveys, page) = (at("one.json"), at("one.csv"), at("surveys.csv"), at("one.html"));
        let files = ["--json", text(&json), "--attitude", text(&attitude), "--surveys", text(&surveys)];
        assert!(mwd(&[&["replay", text(path), "--html", text(&page)][..], &files].concat()).status.success());
        let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
        let row = of(path);
        assert_eq!(row["ok"], Field::Bool(true));
        assert_eq!(row["trace_samples"], Field::Long(json["trace"]["samples"].as_i64().unwrap()));
        for (column, value) in [
            ("identification_final_P_4", &json["identification"]["final"]["P"][4]),
            ("identification_final_sigma_11", &json["identification"]["final"]["sigma"][11]),
            (
                "reference_orientation_2s_rms_deg_with_effects",
                &json["reference"]["orientation_2s_rms_deg"]["with_effects"],
            ),
            ("reference_attitude_rms_deg_total", &json["reference"]["attitude_rms_deg"]["total"]),
        ] {
            assert_eq!(row[column], Field::Double(value.as_f64().unwrap()), "{column}");
        }
        let aligned = &json["reference"]["orientation_2s_rms_time_aligned_deg"]["with_effects"];
        let aligned = aligned.as_f64().map_or(Field::Null, Field::Double);
        assert_eq!(row["reference_orientation_2s_rms_time_aligned_deg_with_effects"], aligned);
        assert_eq!(
            row["identification_motion_from"],
            Field::Str(json["identification"]["motion_from"].as_str().unwrap().into())
        );
        let notes = json["trace"]["notes"].as_array().unwrap();
        let Field::Str(told) = &row["notes"] else { panic!("{row:?}") };
        assert_eq!(told.lines().count(), notes.len());
        assert!(matches!(&row["recording"], Field::Str(hash) if hash.len() == 32 && row["hash"] != row["recording"]));
        let mine = |row: &&BTreeMap<String, Field>| row["path"] == Field::Str(text(path).into());
        let expected = json["identification"]["windows"].as_array().unwrap();
        let found: Vec<_> = windows.iter().filter(mine).collect();
        assert!(!found.is_empty() && found.len() == expected.len());
        assert_eq!(found[0]["b_rad_s_2"], Field::Double(expected[0]["b_rad_s"][2].as_f64().unwrap()));
        let surveys = fs::read_to_string(surveys).unwrap();
        let found: Vec<_> = stations.iter().filter(mine).collect();
        assert!(!found.is_empty() && found.len() == surveys.lines().count() - 1);
        let first = surveys.lines().nth(1).unwrap().split(',').nth(3).unwrap();
        assert_eq!(found[0]["inclination_deg"], Field::Double(first.parse().unwrap()));
        let name = testbed::trace::recordings::name(path);
        let name = name.trim_end_matches(".csv");
        for (folder, one) in [(&attitudes, &attitude), (&pages, &page)] {
            let mut files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
            let file = files.find(|file| text(file).contains(name)).unwrap();
            assert!(fs::read(&file).unwrap() == fs::read(one).unwrap(), "the bytes of {}", file.display());
        }
    }
}

fn parts(folder: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let parts = entries.filter(|path| path.extension().is_some_and(|ending| ending == "json"));
    parts.map(|path| (path.clone(), fs::metadata(path).unwrap().modified().unwrap())).collect()
}

#[test]
fn a_killed_run_goes_on_and_only_what_changed_is_flown_again() {
    let folder = TempDir::new().unwrap();
    let paths = recordings(folder.path(), 10, 45.0);
    let out = TempDir::new().unwrap();
    let results = out.path().join("all.parquet");
    let kept = out.path().join("all.parquet.parts");
    let arguments = ["batch", text(folder.path()), "-o", text(&results), "--jobs", "2"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_mwd")).args(arguments).stdout(Stdio::null()).spawn().unwrap();
    while parts(&kept).len() < 3 {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(2));
    }
    // On Unix this is SIGKILL.
    child.kill().unwrap();
    child.wait().unwrap();
    let before = parts(&kept);
    assert!(!results.exists() && before.len() < 10, "{}", before.len());
    let told = |arguments: &[&str]| String::from_utf8(mwd(arguments).stdout).unwrap();
    let again = told(&arguments);
    let expected = format!("10 recordings: {} flown now, {} from before; 0 bad", 10 - before.len(), before.len());
    assert!(again.starts_with(&expected), "{again}");
    let after = parts(&kept);
    assert!(before.iter().all(|(path, time)| after.get(path) == Some(time)), "what was there stays untouched");
    assert_eq!(table(&results).len(), 10);
    let first = fs::read(&results).unwrap();
    assert!(told(&arguments).starts_with("10 recordings: 0 flown now, 10 from before"));
    assert_eq!(fs::read(&results).unwrap(), first, "the same bytes");
    // One recording changes, and then the options.
    let text_of_one = fs::read_to_string(&paths[4]).unwrap();
    fs::write(&paths[4], text_of_one.trim_end().rsplit_once('\n').unwrap().0).unwrap();
    assert!(told(&arguments).starts_with("10 recordings: 1 flown now, 9 from before"));
    let other = [&arguments[..], &["--seed", "2"]].concat();
    assert!(told(&other).starts_with("10 recordings: 10 flown now, 0 from before"));
}

/// Rows of a longer recording go to a temporary file. Where that cannot be written, the recording is not to blame.
#[test]
fn a_disk_that_fails_is_a_row_and_the_recording_is_flown_again() {
    let folder = TempDir::new().unwrap();
    // Over the megabyte that stays in memory.
    recordings(folder.path(), 1, 150.0);
    fs::write(folder.path().join("bad.csv"), "nothing\n").unwrap();
    let results = folder.path().join("all.parquet");
    let run = |temporary: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.args(["batch", text(folder.path()), "-o", text(&results)]).env("TMPDIR", temporary);
        String::from_utf8(command.output().unwrap().stdout).unwrap()
    };
    let told = run(&folder.path().join("none"));
    assert!(told.starts_with("2 recordings: 2 flown now, 0 from before; 2 bad"), "{told}");
    let error = table(&results)[1]["error"].to_string();
    assert!(error.contains("temporary file"), "{error}");
    let told = run(folder.path());
    assert!(told.starts_with("2 recordings: 1 flown now, 1 from before; 1 bad"), "{told}");
    assert_eq!(table(&results)[1]["ok"], Field::Bool(true));
}

/// Rows and outputs of a recording are in temporary files. What stays in memory are its windows, diagnoses and surveys,
/// and their JSON.
#[test]
#[cfg(target_os = "linux")]
fn memory_hardly_grows_with_the_length_of_a_recording() {
    let largest = |seconds: f64| {
        let folder = TempDir::new().unwrap();
        recordings(folder.path(), 1, seconds);
        let results = folder.path().join("all.parquet");
        let arguments = ["batch", text(folder.path()), "-o", text(&results), "--jobs", "1"];
        let mut child = Command::new(env!("CARGO_BIN_EXE_mwd")).args(arguments).stdout(Stdio::null()).spawn().unwrap();
        let mut largest = 0;
        while child.try_wait().unwrap().is_none() {
            largest = largest.max(testbed::process_memory::largest_kib(child.id()).unwrap_or(0));
            std::thread::sleep(Duration::from_millis(2));
        }
        assert_eq!(table(&results)[0]["ok"], Field::Bool(true));
        largest
    };
    // A short run's end may fall between two looks, so the largest of some counts.
    let short = (0..4).map(|_| largest(600.0)).max().unwrap_or(0);
    let long = largest(3_600.0);
    println!("{short} KiB for 10 min, {long} KiB for an hour");
    // The rows of the 50 minutes between are 26 MB, and as many outputs 23 MB.
    assert!(long < short + 8_192, "{short} KiB for 10 min, {long} KiB for an hour");
}

#[test]
fn an_input_that_names_nothing_is_told() {
    let folder = TempDir::new().unwrap();
    let results = folder.path().join("all.parquet");
    let output = mwd(&["batch", text(folder.path()), "-o", text(&results)]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("the folder holds no .csv and no .csv.gz\nnext: "));
    let output = mwd(&["batch", "/nowhere/*.csv", "-o", text(&results)]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("no file is so named\nnext: "));
}

#[test]
fn no_output_overwrites_an_input_or_another_one() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("rec")).unwrap();
    let recording = recordings(&at("rec"), 1, 20.0).remove(0);
    let (list, config) = (at("list"), at("config.toml"));
    fs::write(&list, text(&recording)).unwrap();
    fs::write(&config, "seed = 7\n").unwrap();
    let inputs = [&recording, &list, &config];
    let before = inputs.map(|input| fs::read(input).unwrap());
    let (rec, listed) = (at("rec"), format!("@{}", text(&list)));
    let (results, windows) = (at("all.parquet"), at("all.windows.parquet"));
    let read = "would overwrite what is read";
    let other = "would overwrite another one";
    for (output, page, told) in [
        (&recording, None, read),
        (&list, None, read),
        (&config, None, read),
        (&results, Some(&recording), read),
        (&results, Some(&results), other),
        (&results, Some(&windows), other),
    ] {
        let mut arguments = vec!["batch", text(&rec), &listed, "--config", text(&config), "-o", text(output)];
        arguments.extend(page.iter().flat_map(|page| ["--html", text(page)]));
        let output = mwd(&arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(told), "{arguments:?}: {output:?}");
        assert!(before == inputs.map(|input| fs::read(input).unwrap()), "{arguments:?}");
    }
}

/// Attitudes are tables of the ending that traces have: a later run would take them for recordings.
#[test]
fn attitudes_go_into_no_folder_that_is_read() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("rec")).unwrap();
    recordings(&at("rec"), 1, 20.0);
    fs::write(at("list"), text(&at("rec"))).unwrap();
    let (rec, listed, results) = (at("rec"), format!("@{}", text(&at("list"))), at("all.parquet"));
    for input in [text(&rec), &listed] {
        for (attitudes, is_refused) in [("rec", true), ("rec/in/it", true), ("rec/../rec/it", true), ("beside", false)]
        {
            let output = mwd(&["batch", input, "-o", text(&results), "--attitude-dir", text(&at(attitudes))]);
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code() == Some(2), is_refused, "{attitudes}: {output:?}");
            assert_eq!(said.contains("lies in a folder that is read"), is_refused, "{attitudes}: {said}");
        }
    }
    assert_eq!(fs::read_dir(&rec).unwrap().count(), 1);
}

/// A configuration that no trace can fly with says nothing of the recordings.
#[test]
fn a_configuration_that_cannot_be_used_ends_the_run_before_it_begins() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let recording = recordings(folder.path(), 1, 20.0).remove(0);
    let (config, results) = (at("bad.toml"), at("all.parquet"));
    for (bad, told) in [
        ("[identification]\nwindow = 40\n", "`window`"),
        ("seed = ", "bad.toml"),
        ("[identification]\nwindow_s = 400\n", "identification.window_s must be at most 50"),
        ("freeze_at_us = -1\n", "freeze_at_us must be"),
    ] {
        fs::write(&config, bad).unwrap();
        let output = mwd(&["batch", text(&recording), "--config", text(&config), "-o", text(&results)]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(told), "{bad}: {output:?}");
        assert!(!results.exists(), "{bad}");
    }
    // The trace's period is 10 ms: this is of the recording, and its row says so.
    fs::write(&config, "sample_period_us = 1000\n").unwrap();
    let output = mwd(&["batch", text(&recording), "--config", text(&config), "-o", text(&results)]);
    assert!(output.status.success() && String::from_utf8_lossy(&output.stdout).contains("1 bad"), "{output:?}");
}

#[test]
fn an_empty_list_is_an_error_as_an_empty_folder_is() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("list"), "# none\n").unwrap();
    let output = mwd(&["batch", &format!("@{}", text(&at("list"))), "-o", text(&at("all.parquet"))]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("the list names nothing"), "{output:?}");
}
