//! `mwd fleet`: the recordings of one or more batches beside each other, as a page.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use clap::Args;

use super::same_file::none_overwritten;
use crate::{
    batch::{self, Key},
    fleet::{Recording, drift::probes, read_and_replaced},
    report::html::{fleet, write_page},
};
use testbed::{console::told, failure::Failure};

/// Recordings that are listed on a terminal.
const LISTED: usize = 5;

/// Options of `fleet`.
#[derive(Debug, Clone, Args)]
pub struct FleetArgs {
    /// Tables of recordings as `batch` writes them; those of their windows are read beside them
    #[arg(required = true, value_name = "RESULTS.parquet")]
    pub tables: Vec<PathBuf>,
    /// Where to write the page
    #[arg(long, value_name = "OUT.html", default_value = "mwd-fleet.html")]
    pub html: PathBuf,
    /// Folder with the recordings' reports, as `batch --html-dir` wrote them: each row leads to its own
    #[arg(long, value_name = "DIR")]
    pub html_dir: Option<PathBuf>,
}

/// Writes the page and prints the worst.
///
/// # Errors
/// A table cannot be used, or the page cannot be written or would overwrite a table.
pub fn run(args: &FleetArgs) -> anyhow::Result<()> {
    let tables: Vec<PathBuf> = args.tables.iter().flat_map(|table| batch::tables(table)).collect();
    none_overwritten(&[&args.html], &tables.iter().map(AsRef::as_ref).collect::<Vec<_>>())?;
    let (mut recordings, replaced) = read_and_replaced(&args.tables)?;
    if let Some(folder) = &args.html_dir {
        link(&mut recordings, folder, &args.html);
    }
    write(&recordings, &args.tables, &args.html)?;
    let mut out = told();
    writeln!(out, "{}", fleet::verdict(&recordings).1)?;
    list(&mut out, recordings.iter().filter(|recording| !recording.standing.is_sound()))?;
    replaced.iter().try_for_each(|line| writeln!(out, "{line}."))?;
    let noted = recordings.iter().filter(|recording| recording.has_notes).count();
    if noted > 0 {
        writeln!(out, "{noted} recordings have notes: the column `notes` of the table tells them.")?;
    }
    let drifting = probes(&recordings);
    let moving = drifting.iter().filter(|probe| probe.moves(drifting.len()).is_some()).count();
    if !drifting.is_empty() {
        writeln!(out, "P of {moving} of {} probes with dated recordings moves by more than chance.", drifting.len())?;
    }
    writeln!(
        out,
        "Next: open {} in a browser; `cargo mwd replay RECORDING --html OUT.html` shows one of them.",
        args.html.display()
    )?;
    Ok(())
}

/// Lists the first of some recordings, with how they stand and why.
///
/// # Errors
/// When it cannot be written.
pub fn list<'a>(out: &mut impl Write, recordings: impl Iterator<Item = &'a Recording>) -> io::Result<()> {
    for recording in recordings.take(LISTED) {
        let why = recording.error.as_ref().map_or_else(String::new, |why| format!(": {why}"));
        writeln!(out, "  {} {}{why}", recording.standing.words(), recording.path)?;
    }
    Ok(())
}

/// Gives each recording that has a report in `folder` the way to it from the page.
pub fn link(recordings: &mut [Recording], folder: &Path, page: &Path) {
    let full = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let beside = page.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (folder, beside) = (full(folder), full(beside));
    for recording in recordings.iter_mut().filter(|recording| recording.hash.len() >= 8) {
        let name = Key::told(recording.hash.clone()).file(Path::new(&recording.path), "html");
        recording.report = folder.join(&name).is_file().then(|| way(&beside, &folder.join(name)));
    }
}

/// The way from a folder to a file, as a link.
fn way(folder: &Path, file: &Path) -> String {
    let of = |path: &Path| -> Vec<String> {
        path.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let (from, to) = (of(folder), of(file));
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from.iter().skip(shared).map(|_| "..".to_owned());
    let parts: Vec<String> = up.chain(to.into_iter().skip(shared)).map(|part| encoded(&part)).collect();
    parts.join("/")
}

/// A part of a path as an address has it.
fn encoded(part: &str) -> String {
    part.bytes().fold(String::new(), |out, byte| match byte {
        b'-' | b'.' | b'_' | b'~' => out + &char::from(byte).to_string(),
        _ if byte.is_ascii_alphanumeric() => out + &char::from(byte).to_string(),
        _ => out + &format!("%{byte:02X}"),
    })
}

/// Writes the page of recordings.
///
/// # Errors
/// When it cannot be written.
pub fn write(recordings: &[Recording], tables: &[PathBuf], page: &Path) -> Result<(), Failure> {
    write_page(page, &fleet::page(recordings, tables))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_leads_out_of_one_folder_into_another() {
        let way = |folder: &str, file: &str| way(Path::new(folder), Path::new(file));
        assert_eq!(way("/a/b", "/a/b/c/d e.html"), "c/d%20e.html");
        assert_eq!(way("/a/b", "/a/c/#1.html"), "../c/%231.html");
        assert_eq!(way("/a", "/a/b.html"), "b.html");
    }
}
