//! The main job as a newcomer runs it: it ends with three sentences in plain English, writes a report and says where,
//! and keeps its matrices for `--details`. Flown on this machine, where no emulator is asked for.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{fs, path::Path, process::Command};

use tempfile::TempDir;

/// Output of the main job, in a folder of its own and without any tool that it could call.
fn told(folder: &Path, arguments: &[&str]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_mwd"));
    program.args(arguments).current_dir(folder).env("PATH", "").env("MWD_NO_INSTALL", "1");
    let output = program.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The number behind each of some words.
fn numbers_behind<const N: usize>(sentence: &str, words: [&str; N]) -> [f64; N] {
    words.map(|word| {
        let behind = sentence.split_once(word).unwrap_or_else(|| panic!("{word}: {sentence}")).1;
        behind.split_whitespace().next().unwrap().parse().unwrap()
    })
}

#[test]
fn it_ends_with_three_sentences_and_a_report() {
    let folder = TempDir::new().unwrap();
    let told = told(folder.path(), &[]);
    let sentence = |start: &str| {
        let line = told.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {told}"));
        assert!(line.ends_with('.') && line.is_ascii() | line.contains('±'), "{line}");
        line.strip_prefix(start).unwrap().to_owned()
    };
    // Sentence on what was wrong: the known error has 2 deg/s of bias and up to 10 % of P.
    let wrong = sentence("In flight 2, what was wrong: ");
    let [bias] = numbers_behind(&wrong, ["a bias of "]);
    assert!((0.5..4.0).contains(&bias) && wrong.contains("% too ") && wrong.contains("axis"), "{wrong}");
    let done = sentence("What was done: ");
    assert!(done.starts_with("The gyro's errors were identified, and have been corrected since"), "{done}");
    let gained = sentence("What it gained: ");
    let [flown, raw, alone] = numbers_behind(&gained, ["are wrong by ", "deg; by ", "raw gyro, by "]);
    assert!(flown < 0.5 * alone && alone < raw, "{gained}");
    // The report lies where the last lines say, and needs nothing else.
    let named = told.lines().find(|line| line.starts_with("Report of flight 2: ")).unwrap();
    assert!(named.contains("mwd-report.html (open it in a browser)"), "{named}");
    let page = fs::read_to_string(folder.path().join("mwd-report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && !page.contains("src=\"http") && !page.contains("href=\"http"));
    assert!(told.contains("Flown ON THIS MACHINE") && told.contains("Install it with: "), "{told}");
    assert!(told.lines().any(|line| line.starts_with("Next: ")) && !told.contains('\u{1b}'), "{told}");
    // Three flights, a line each, which in a pipe say what their figures are.
    let flights: Vec<&str> = told.lines().filter(|line| line.starts_with("flight ")).collect();
    assert_eq!(flights.len(), 3, "{told}");
    for line in flights {
        let [raw, flown] = numbers_behind(&line.replace(',', " "), ["raw gyro ", "as flown "]);
        assert!(flown <= raw, "{line}");
    }
    assert!(!told.contains("+-") && told.lines().count() < 20, "the matrices are for --details: {told}");
}

#[test]
fn details_are_there_when_asked_for_and_the_report_where_it_is_wanted() {
    let folder = TempDir::new().unwrap();
    let told = told(folder.path(), &["--details", "--html", "other.html"]);
    assert!(told.contains("ACCEPTED: P and b fly") && told.contains("rotation error over 2 s"), "{told}");
    assert!(told.matches("   P ").count() >= 9 && told.contains("   known "), "{told}");
    assert!(told.contains("What it gained: ") && told.contains("other.html"), "{told}");
    assert!(folder.path().join("other.html").is_file() && !folder.path().join("mwd-report.html").exists());
}

/// A result on the standard output is alone there.
#[test]
fn the_report_may_be_the_only_thing_on_the_standard_output() {
    let folder = TempDir::new().unwrap();
    let page = told(folder.path(), &["--html", "-"]);
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"), "{}", page.len());
    let drawn = told(folder.path(), &["--plot", "-", "--html", "other.html"]);
    assert!(drawn.starts_with("<svg") && drawn.trim_end().ends_with("</svg>"), "{}", drawn.len());
    assert!(!folder.path().join("-").exists());
}

#[test]
fn two_outputs_in_one_file_are_refused() {
    let folder = TempDir::new().unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_mwd"));
    let output = program.args(["--plot", "x", "--html", "./x"]).current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("x: the result would overwrite another one"),
        "{output:?}"
    );
    assert!(!folder.path().join("x").exists());
}
