//! Where a page's figures come from: program, files that were read, configuration, with hashes.

use std::{fs, path::Path};

use sha2::{Digest, Sha256};

use super::{Told, escape::escape, table};
use crate::report::json::Configuration;

/// Sources from which a page was made.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    rows: Vec<(String, String)>,
    folded: String,
}

impl Sources {
    /// The program alone.
    #[must_use]
    pub fn program() -> Self {
        let version = format!("meerkat-mwd {}", env!("CARGO_PKG_VERSION"));
        Self { rows: vec![("program".to_owned(), version)], folded: String::new() }
    }

    /// With a file that was read, and its hash where it can be read again.
    #[must_use]
    pub fn file(mut self, what: &str, path: &Path) -> Self {
        self.rows.push((what.to_owned(), path.display().to_string()));
        if let Ok(bytes) = fs::read(path) {
            self.rows.push((format!("SHA-256 of the {what}"), sha256(&bytes)));
        }
        self
    }

    /// With something else that is known; nothing if it is empty.
    #[must_use]
    pub fn known(mut self, what: &str, value: impl Into<String>) -> Self {
        let value = value.into();
        if !value.is_empty() {
            self.rows.push((what.to_owned(), value));
        }
        self
    }

    /// With a configuration, told by its text in a fold, and its hash.
    #[must_use]
    pub fn configuration(mut self, summary: &str, text: &str) -> Self {
        self.rows.push(("SHA-256 of the configuration below".to_owned(), sha256(text.as_bytes())));
        self.folded(summary, &format!("<pre tabindex=\"0\">{}</pre>\n", escape(text)))
    }

    /// With more, as HTML, in a fold.
    #[must_use]
    pub(super) fn folded(mut self, summary: &str, html: &str) -> Self {
        self.folded += &format!("<details>\n<summary>{}</summary>\n{html}</details>\n", escape(summary));
        self
    }

    /// As HTML.
    pub(super) fn html(&self) -> String {
        let rows = self.rows.iter().map(|(name, what)| (false, vec![name.clone(), what.clone()]));
        table(&["", ""], rows) + &self.folded
    }
}

/// Version, recording and configuration of a flight.
pub(super) fn of_a_flight(told: &Told) -> String {
    let trace = told.trace;
    let configuration = toml::to_string_pretty(&Configuration::of(told.config, told.flight)).unwrap_or_default();
    let mut out = Sources::program()
        .file("recording", &trace.path)
        .known("recorded by", trace.keys.source.clone().unwrap_or_default())
        .known("licence of the recording", trace.keys.licence.clone().unwrap_or_default())
        .known("changed since it was recorded", trace.keys.changes.clone().unwrap_or_default())
        .configuration("The configuration, as --config takes it", &configuration)
        .html();
    for wrong in &trace.wrong {
        out += &format!("<p><strong>Wrong: {}. Nothing is identified from it.</strong></p>\n", escape(wrong));
    }
    for note in &trace.notes {
        out += &format!("<p>Note: {}.</p>\n", escape(note));
    }
    out
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_told_with_its_hash_and_a_configuration_with_its_text() {
        let folder = tempfile::TempDir::new().unwrap_or_else(|error| panic!("{error}"));
        let path = folder.path().join("a.csv");
        assert!(fs::write(&path, "abc").is_ok());
        let sources = Sources::program().file("table", &path).known("day", "").configuration("All of it", "a < b");
        let html = sources.html();
        // FIPS 180-4's own example.
        let of_abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(html.contains(of_abc) && html.contains("SHA-256 of the table") && html.contains("a &lt; b"), "{html}");
        assert!(!html.contains(">day<"), "{html}");
    }
}
