//! README, guides and comments: short where they have to be, and no link or path in them leads nowhere.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use meerkat_mwd::Config;
use serde_json::Value;
use testbed::simulate::{Scenario, Temperature};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// README, guides and pages of measurements.
fn documents() -> Vec<PathBuf> {
    let mut found = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    for folder in ["docs", "docs/measurements"] {
        let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        found.extend(entries.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
    }
    assert!(found.len() > 15, "{found:?}");
    found
}

#[test]
fn the_readme_has_at_most_150_lines() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap().lines().count();
    assert!(lines <= 150, "{lines}");
}

#[test]
fn every_link_leads_to_a_file() {
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0) {
            if link.starts_with("http") {
                continue;
            }
            let file = document.parent().unwrap().join(link);
            assert!(file.exists(), "{}: {link}", document.display());
        }
    }
}

/// A path in backquotes that begins with a folder of the repository.
#[test]
fn every_path_that_a_guide_names_exists() {
    let folders = ["src/", "host-tests/", "docs/", "examples/", "tests/"];
    let mut count = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for quoted in text.split('`').skip(1).step_by(2) {
            if !folders.iter().any(|folder| quoted.starts_with(folder)) || quoted.contains(' ') {
                continue;
            }
            assert!(root().join(quoted).exists(), "{}: {quoted}", document.display());
            count += 1;
        }
    }
    assert!(count > 50, "{count}");
}

/// A key of a page of settings, as `table.key`, with the default beside it; without one, `none`.
fn settings_of_page(page: &str) -> BTreeMap<String, String> {
    let text = fs::read_to_string(root().join(page)).unwrap();
    let (mut table, mut settings) = (None, BTreeMap::new());
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let name = heading.strip_prefix("`[").and_then(|rest| rest.strip_suffix("]`"));
            table = name.map(|name| format!("{name}.")).or_else(|| (heading == "At the root").then(String::new));
        }
        let (Some(table), true) = (&table, line.starts_with("| `")) else { continue };
        let cells: Vec<&str> = line.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
        let known = settings.insert(format!("{table}{}", cells[1]), cells[3].to_owned());
        assert_eq!(known, None, "{page}: {line}");
    }
    settings
}

/// The values of a structure by their names with those of its tables.
fn leaves(table: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
    for (key, value) in value.as_object().unwrap() {
        match value {
            Value::Object(_) => leaves(&format!("{table}{key}."), value, into),
            _ => assert_eq!(into.insert(format!("{table}{key}"), value.clone()), None),
        }
    }
}

/// A page rounds a default to three digits.
fn is_near(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_near(a, b)),
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() <= 1e-3 * b.abs()
        }
        _ => a == b,
    }
}

fn parsed(default: &str) -> Value {
    if default == "none" {
        return Value::Null;
    }
    let table: toml::Table = format!("x = {default}").parse().unwrap_or_else(|error| panic!("{default}: {error}"));
    serde_json::to_value(&table["x"]).unwrap()
}

#[test]
fn every_setting_of_a_probe_is_on_its_page_with_its_default() {
    let mut settings = BTreeMap::new();
    leaves("", &serde_json::to_value(Config::default()).unwrap(), &mut settings);
    let told = settings_of_page("docs/configuration.md");
    assert!(told.keys().eq(settings.keys()), "{:?} {:?}", told.keys(), settings.keys());
    for (key, value) in settings {
        assert!(is_near(&parsed(&told[&key]), &value), "{key}: {} {value}", told[&key]);
    }
}

/// Names that an error about an unknown key offers in its place.
fn keys_of_table(table: &str) -> Vec<String> {
    let text = if table.is_empty() { "zz = 1".to_owned() } else { format!("[{table}]\nzz = 1") };
    let error = toml::from_str::<Scenario>(&text).unwrap_err().to_string();
    let (_, expected) = error.split_once("expected").unwrap();
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn every_setting_of_a_scenario_is_on_its_page_with_its_default() {
    let told = settings_of_page("docs/scenario.md");
    let mut tables: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for (path, default) in &told {
        let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
        tables.entry(table).or_default().push((key, default));
    }
    let mut file = String::new();
    for (table, settings) in &tables {
        for key in keys_of_table(table) {
            let path = if table.is_empty() { key.clone() } else { format!("{table}.{key}") };
            assert!(told.contains_key(&path) || tables.contains_key(path.as_str()), "{path}");
        }
        let given = settings.iter().filter(|(_, default)| *default != "none");
        let lines: Vec<String> = given.map(|(key, default)| format!("{key} = {default}\n")).collect();
        // The root comes first, as its name is the least.
        file += &if table.is_empty() { lines.concat() } else { format!("[{table}]\n{}", lines.concat()) };
    }
    let scenario: Scenario = toml::from_str(&file).unwrap_or_else(|error| panic!("{error}\n{file}"));
    assert_eq!(scenario, Scenario { temperature: Some(Temperature::default()), ..Scenario::default() });
}

/// Rust files under a folder, without built ones.
fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()) {
        let path = entry.path();
        if entry.file_type().unwrap().is_dir() {
            if path.file_name().is_some_and(|name| name != "target") {
                rust_files(&path, found);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Lines of a Rust file whose comment is wider than 120 columns, or begins with a word that does not name a thing.
fn unclear_comments(text: &str) -> Vec<usize> {
    const WIDEST: usize = 120;
    const UNNAMED: [&str; 4] = ["What", "Whether", "How", "Of"];
    let (mut found, mut before) = (Vec::new(), "");
    for (index, line) in text.lines().enumerate() {
        let comment = line.trim_start();
        // A paragraph begins after another kind of line, or after one without a word.
        let kind = ["//!", "///", "//"].into_iter().find(|kind| comment.starts_with(kind)).unwrap_or("");
        let words = comment[kind.len()..].trim();
        let first = words.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
        let begins = kind != before && UNNAMED.contains(&first);
        if !kind.is_empty() && (begins || line.chars().count() > WIDEST) {
            found.push(index + 1);
        }
        before = if words.is_empty() { "" } else { kind };
    }
    found
}

#[test]
fn a_comment_is_at_most_120_columns_wide_and_begins_with_the_thing_that_it_explains() {
    let seeded =
        format!("/// Whether it is.\nfn a() {{}}\n//! A thing.\n//! {}\n//\n// Of it.\nlet b = 1;", "x".repeat(117));
    assert_eq!(unclear_comments(&seeded), [1, 4, 6]);
    assert!(
        unclear_comments("// The gyro's bias.\n// What a gyro adds.\nlet What = 0;\n// Offset\n/// Often").is_empty()
    );

    let mut files = Vec::new();
    for folder in ["src", "host-tests", "bindings"] {
        rust_files(&root().join(folder), &mut files);
    }
    assert!(files.len() > 500, "{}", files.len());
    let mut unclear = Vec::new();
    for file in files {
        let lines = unclear_comments(&fs::read_to_string(&file).unwrap());
        unclear.extend(lines.into_iter().map(|line| format!("{}:{line}", file.display())));
    }
    assert!(
        unclear.is_empty(),
        "wider than 120 columns, or begins with What, Whether, How or Of:\n{}",
        unclear.join("\n")
    );
}
