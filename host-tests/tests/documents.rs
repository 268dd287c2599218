//! README and guides: short where they have to be, and no link or path in them leads nowhere.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    fs,
    path::{Path, PathBuf},
};

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
