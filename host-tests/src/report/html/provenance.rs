//! Where a page's figures come from: program, recording, configuration, with hashes.

use std::fs;

use sha2::{Digest, Sha256};

use super::{Told, escape::escape, table};

/// Version, recording and configuration.
pub(super) fn provenance(told: &Told) -> String {
    let mut rows = vec![("program".to_owned(), format!("meerkat-mwd {}", env!("CARGO_PKG_VERSION")))];
    let trace = told.trace;
    rows.push(("recording".to_owned(), trace.path.display().to_string()));
    rows.extend(trace.keys.source.clone().map(|source| ("recorded by".to_owned(), source)));
    rows.extend(trace.keys.licence.clone().map(|licence| ("licence of the recording".to_owned(), licence)));
    if let Ok(bytes) = fs::read(&trace.path) {
        rows.push(("SHA-256 of the recording".to_owned(), sha256(&bytes)));
    }
    let configuration = toml::to_string_pretty(told.config).unwrap_or_default();
    rows.push(("SHA-256 of the configuration below".to_owned(), sha256(configuration.as_bytes())));
    let mut out = table(&["", ""], rows.into_iter().map(|(name, what)| (false, vec![name, what])));
    for wrong in &trace.wrong {
        out += &format!("<p><strong>Wrong: {}. Nothing is identified from it.</strong></p>\n", escape(wrong));
    }
    for note in &trace.notes {
        out += &format!("<p>Note: {}.</p>\n", escape(note));
    }
    let folded = "<details>\n<summary>The configuration, as --config takes it</summary>\n";
    out + folded + &format!("<pre tabindex=\"0\">{}</pre>\n</details>\n", escape(&configuration))
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
