//! Files of a source to tables; the kind of a file is told by its first bytes.

use std::{
    io::{Read, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use super::{
    delimited::{self, Dialect},
    matlab, mcap, parquet_file,
    table::Contents,
    text, ulog,
};
use testbed::{failure::Failure, trace::recordings};

/// Name of the standard input.
pub const STDIN: &str = "-";

/// First bytes of files that are known and cannot be read, with what to do.
const REFUSED: [(&[u8], &str); 2] = [
    (b"PK\x03\x04", "a zip archive: unpack it and name the files or their folder"),
    (b"\x89HDF", "an HDF5 file, as MATLAB writes with -v7.3: save it with -v7"),
];

/// Files of a source: itself, or those in the folder that it names.
///
/// # Errors
/// The folder cannot be read.
pub fn files(source: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut files = if source.is_dir() { recordings::listed(source)? } else { vec![source.to_owned()] };
    files.retain(|file| !file.is_dir());
    Ok(files)
}

/// Contents of all files, folders and the standard input that are named.
///
/// # Errors
/// A file that cannot be read, with its name, and what is wrong in it.
pub fn contents(sources: &[PathBuf], dialect: Option<Dialect>) -> Result<Contents, Failure> {
    let (mut all, mut passed_over) = (Contents::default(), Vec::new());
    for source in sources {
        for file in files(source)? {
            let of_file = |what: String| format!("{}: {what}", file.display());
            let Contents { tables, lost, notes } = match read(&file, dialect) {
                Ok(contents) => contents,
                // A logger's folder holds settings, pictures and tables of two columns, too.
                Err(Unread::NoTable(what)) if source.is_dir() => {
                    passed_over.push(of_file(what));
                    continue;
                }
                Err(Unread::NoTable(what) | Unread::Damaged(what)) => return Err(Failure::BadInput(of_file(what))),
            };
            all.tables.extend(tables);
            all.lost.extend(lost.into_iter().map(of_file));
            all.notes.extend(notes.into_iter().map(of_file));
        }
    }
    if all.tables.is_empty() && !passed_over.is_empty() {
        return Err(Failure::BadInput(passed_over.remove(0)));
    }
    all.notes.extend(passed_over.into_iter().map(|what| format!("not read, as a file without a sensor: {what}")));
    // A map names a table; two of a name would be one.
    let tables = &mut all.tables;
    for index in 1..tables.len() {
        let is_taken = |name: &str| tables[..index].iter().any(|table| table.name == name);
        let plain = tables[index].name.clone();
        if let Some(free) =
            (2..).map(|count| format!("{plain} {count}")).find(|name| !is_taken(name)).filter(|_| is_taken(&plain))
        {
            tables[index].name = free;
        }
    }
    Ok(all)
}

/// Why a file is not read.
enum Unread {
    /// It holds no table of three columns or more, so that no sensor is in it.
    NoTable(String),
    /// It may hold a sensor.
    Damaged(String),
}

impl From<String> for Unread {
    fn from(what: String) -> Self {
        Self::Damaged(what)
    }
}

fn read(path: &Path, dialect: Option<Dialect>) -> Result<Contents, Unread> {
    let bytes = if path.as_os_str() == STDIN {
        let mut bytes = Vec::new();
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(|error| format!("cannot be read: {error}"))?;
        bytes
    } else {
        std::fs::read(path).map_err(|error| format!("cannot be opened: {error}"))?
    };
    if bytes.is_empty() {
        return Err(Unread::NoTable("the file is empty".into()));
    }
    let name = if path.as_os_str() == STDIN { "stdin".into() } else { stem(path) };
    if let Some((_, what)) = REFUSED.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(Unread::Damaged((*what).into()));
    }
    let bytes = text::unzipped(bytes)?;
    if bytes.starts_with(ulog::MAGIC) {
        return Ok(ulog::read(on_disk(&bytes)?.path())?);
    }
    if bytes.starts_with(mcap::MAGIC) {
        return Ok(mcap::read(&bytes)?);
    }
    if bytes.starts_with(parquet_file::MAGIC) {
        let file = on_disk(&bytes)?.reopen().map_err(|error| error.to_string())?;
        return Ok(Contents::whole(parquet_file::read(file, &name)?));
    }
    if bytes.starts_with(matlab::MAGIC) {
        return Ok(Contents::whole(matlab::read(&bytes, &name)?));
    }
    let text = text::decoded(bytes)?;
    if text.chars().take(2_000).any(|letter| letter == '\0') {
        return Err(Unread::NoTable("neither text nor a kind of file that is known".into()));
    }
    let dialect = dialect.unwrap_or_else(|| delimited::dialect(&text));
    delimited::none_in(&text, dialect).map_or(Ok(()), |what| Err(Unread::NoTable(what)))?;
    Ok(delimited::read(&text, &name, dialect)?)
}

/// Bytes as a file, for readers that want one: they may have come zipped, or from the standard input.
fn on_disk(bytes: &[u8]) -> Result<NamedTempFile, String> {
    let write = || {
        let mut file = NamedTempFile::new()?;
        file.write_all(bytes)?;
        Ok(file)
    };
    write().map_err(|error: std::io::Error| format!("cannot be unpacked: {error}"))
}

/// A file's name without its endings.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".gz");
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}
