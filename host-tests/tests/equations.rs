//! The paper's equations: every equation has a row in the table, and the files named there cite it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::{fs, path::Path};

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The equations that a text cites: "eq 19", "Eq 10 or 11", "eq 24 and 25", "eq 5, 6", "eq 20 to 23" with all
/// in between. A number with a decimal point ("eq 4.15") is another source's.
fn cited(text: &str) -> Vec<u32> {
    // A citation may run over the end of a comment's line.
    let markers = ["///", "//!", "//"];
    let lines = text.lines().map(|line| {
        let line = line.trim_start();
        markers.iter().find_map(|marker| line.strip_prefix(marker)).unwrap_or(line)
    });
    let text = lines.collect::<Vec<_>>().join(" ");
    let words: Vec<&str> = text.split_whitespace().collect();
    let number = |word: &str| {
        let digits = word.trim_start_matches('(').trim_end_matches([')', '.', ',', ';', ':', '`', '\'', ']']);
        digits.parse::<u32>().ok()
    };
    let mut found = Vec::new();
    for (at, word) in words.iter().enumerate() {
        if !matches!(word.trim_start_matches(['(', '`', '[']), "eq" | "Eq") {
            continue;
        }
        let mut rest = words[at + 1..].iter();
        let Some(mut last) = rest.next().and_then(|word| number(word)) else { continue };
        found.push(last);
        let mut joined = words[at + 1].ends_with(',');
        while let Some(word) = rest.next() {
            let (range, word) = match *word {
                "to" => (true, rest.next()),
                "and" | "or" => (false, rest.next()),
                _ if joined => (false, Some(word)),
                _ => break,
            };
            let Some((word, next)) = word.and_then(|word| number(word).map(|next| (word, next))) else { break };
            found.extend(if range { last + 1..=next } else { next..=next });
            (last, joined) = (next, word.ends_with(','));
        }
    }
    found
}

#[test]
fn citations_are_read_with_their_ranges() {
    assert_eq!(cited("/// Eq 19: towards (eq 20 to 23, the free form)."), [19, 20, 21, 22, 23]);
    assert_eq!(cited("// migration (eq 24 and\n    // 25), or eq 5, 6 and 7; equation 9, eq 4.15"), [24, 25, 5, 6, 7]);
    assert_eq!(cited("Eq 10 or 11, equally likely. (paper, eq 1 to 4; P)"), [10, 11, 1, 2, 3, 4]);
    assert_eq!(cited("eq 12, the 13 others; seq 14; eq of 15"), [12]);
}

#[test]
fn every_equation_has_a_row_and_the_files_it_names_cite_it() {
    let table = read("docs/equations.md");
    for equation in 1..=29 {
        let head = format!("| {equation} |");
        let rows: Vec<&str> = table.lines().filter(|line| line.starts_with(&head)).collect();
        let [row] = rows[..] else { panic!("equation {equation} has {} rows", rows.len()) };
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        assert_eq!(cells.len(), 5, "equation {equation}: {row}");
        assert!(!cells[1].is_empty() && !cells[2].is_empty(), "equation {equation}");
        let files: Vec<&str> = cells[4].split(", ").map(|file| file.trim_matches('`')).collect();
        // An unused equation is cited nowhere.
        for file in files.into_iter().filter(|file| *file != "none") {
            let cited = cited(&read(file));
            assert!(cited.contains(&equation), "{file} does not cite equation {equation}, only {cited:?}");
        }
    }
}
