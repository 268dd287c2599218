//! The key of a probe, and the counter of commands beside it.

use std::{
    fs,
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

use meerkat_mwd::{
    storage::{FactoryKey, can_be_key},
    telemetry::{Key, ProbeId},
};

use testbed::failure::Failure;

/// A key and the latest counter used with it, which is kept in a file beside it.
#[derive(Debug)]
pub struct KeyFile {
    bytes: [u8; 32],
    counter_path: PathBuf,
    latest: u64,
}

impl KeyFile {
    /// Reads the key from `path` (64 hexadecimal digits) and the counter from `path` with `.counter` behind
    /// it (a decimal number; 0 if there is no such file).
    ///
    /// # Errors
    /// [`Failure::Key`] if the key's file is missing, [`Failure::BadInput`] if a file holds anything
    /// else.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let text =
            fs::read_to_string(path).map_err(|error| Failure::Key { path: path.to_owned(), why: error.to_string() })?;
        let bytes = bytes(text.trim()).filter(can_be_key).ok_or_else(|| {
            let must_be = "64 hexadecimal digits, drawn at random";
            Failure::BadInput(format!("{}: a key must be {must_be}", path.display()))
        })?;
        let counter_path = PathBuf::from(format!("{}.counter", path.display()));
        let latest = match fs::read_to_string(&counter_path) {
            Ok(text) => text
                .trim()
                .parse()
                .map_err(|_| Failure::BadInput(format!("{}: a counter must be a number", counter_path.display())))?,
            Err(error) if error.kind() == ErrorKind::NotFound => 0,
            Err(error) => return Err(Failure::BadInput(format!("{}: {error}", counter_path.display()))),
        };
        Ok(Self { bytes, counter_path, latest })
    }

    /// The key as it is written into a probe.
    #[must_use]
    pub const fn to_write(&self) -> FactoryKey {
        FactoryKey(self.bytes)
    }

    /// The key to one probe.
    #[must_use]
    pub fn key(&self, probe: ProbeId) -> Option<Key> {
        Key::new(&self.bytes, probe)
    }

    /// Returns an unused counter and marks it as used on disk first.
    ///
    /// # Errors
    /// The counter's file cannot be written, or no counter is left.
    pub fn next_counter(&mut self) -> Result<u64, Failure> {
        let next = self.latest.checked_add(1);
        let next = next.ok_or_else(|| Failure::BadInput(format!("{}: full", self.counter_path.display())))?;
        self.set_latest(next)?;
        Ok(next)
    }

    /// Stores the latest counter that the probe reports.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn set_latest(&mut self, latest: u64) -> Result<(), Failure> {
        let write = || {
            let folder = self.counter_path.parent().filter(|folder| !folder.as_os_str().is_empty());
            let mut file = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
            writeln!(file, "{latest}")?;
            file.as_file().sync_all()?;
            file.persist(&self.counter_path).map_err(|e| e.error)
        };
        write().map_err(|e| Failure::output(&self.counter_path, &e))?;
        self.latest = latest;
        Ok(())
    }
}

fn bytes(digits: &str) -> Option<[u8; 32]> {
    let mut key = [0; 32];
    if digits.len() != 2 * key.len() || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    for (index, place) in key.iter_mut().enumerate() {
        *place = u8::from_str_radix(digits.get(2 * index..2 * index + 2)?, 16).ok()?;
    }
    Some(key)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_counter_is_never_given_twice_and_only_keys_are_keys() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("probe.key");
        assert!(matches!(KeyFile::open(&path), Err(Failure::Key { .. })));
        let sane = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1F\n";
        for (text, fine) in
            [("", false), ("00", false), (&"ff".repeat(32), false), (&sane.replace('0', "+"), false), (sane, true)]
        {
            fs::write(&path, text).unwrap();
            assert_eq!(KeyFile::open(&path).is_ok(), fine, "{text}");
        }
        let mut given = Vec::new();
        for _ in 0..3 {
            let mut key = KeyFile::open(&path).unwrap();
            given.extend([key.next_counter().unwrap(), key.next_counter().unwrap()]);
        }
        assert_eq!(given, [1, 2, 3, 4, 5, 6]);
    }
}
