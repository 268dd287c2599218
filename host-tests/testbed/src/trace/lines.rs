//! Lines of a plain or gzip file with their numbers. Counted here, so that blank lines and carriage returns
//! do not shift the number that an error names.

use std::{
    ffi::OsStr,
    io::{self, BufRead, BufReader, Read},
    path::Path,
};

use flate2::bufread::MultiGzDecoder;

use super::error::{Fault, Located};
use crate::console;

/// Longest line accepted, bytes: a stream of zeros in a damaged gzip must not fill the memory.
const LONGEST_LINE: u64 = 1 << 16;
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// The lines of a file.
pub(super) struct Lines<R> {
    reader: R,
    gzip: bool,
    buffer: Vec<u8>,
    /// Number of the last line read, from 1.
    number: u64,
}

/// Opens a file; gzip is told by its first bytes or its name.
pub(super) fn open(path: &Path) -> Result<Lines<Box<dyn BufRead>>, Located> {
    let file = console::open(path).map_err(|e| Fault::NotOpened(e.to_string()).of_file())?;
    let reader = BufReader::with_capacity(1 << 16, file);
    of(reader, path.extension() == Some(OsStr::new("gz")))
}

/// Lines of what is read; gzip is told by its first bytes.
pub(super) fn of<'r>(mut reader: impl BufRead + 'r, is_gzip: bool) -> Result<Lines<Box<dyn BufRead + 'r>>, Located> {
    let start = reader.fill_buf().map_err(|e| Fault::NotRead(e.to_string()).of_file())?;
    if start.is_empty() {
        return Err(Fault::Empty.of_file());
    }
    let gzip = is_gzip || start.starts_with(&GZIP_MAGIC);
    let reader: Box<dyn BufRead + 'r> =
        if gzip { Box::new(BufReader::with_capacity(1 << 16, MultiGzDecoder::new(reader))) } else { Box::new(reader) };
    Ok(Lines::new(reader, gzip))
}

impl<R: BufRead> Lines<R> {
    pub const fn new(reader: R, gzip: bool) -> Self {
        Self { reader, gzip, buffer: Vec::new(), number: 0 }
    }

    /// The next line with its number from 1, without line end, byte order mark and surrounding blanks; `None`
    /// at the end.
    pub fn next_line(&mut self) -> Result<Option<(u64, &str)>, Located> {
        self.buffer.clear();
        let line = self.number + 1;
        let read = self.reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.buffer);
        let count = read.map_err(|error| io_fault(&error, self.gzip).at(line))?;
        if count == 0 {
            return Ok(None);
        }
        if count as u64 == LONGEST_LINE && !self.buffer.ends_with(b"\n") {
            return Err(Fault::LineTooLong(LONGEST_LINE).at(line));
        }
        self.number = line;
        let text = std::str::from_utf8(&self.buffer).map_err(|e| Fault::NotUtf8(e.valid_up_to() + 1).at(line))?;
        Ok(Some((line, text.trim_start_matches('\u{feff}').trim())))
    }
}

fn io_fault(error: &io::Error, gzip: bool) -> Fault {
    match error.kind() {
        io::ErrorKind::UnexpectedEof if gzip => Fault::TruncatedGzip,
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput if gzip => Fault::DamagedGzip(error.to_string()),
        _ => Fault::NotRead(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn carriage_returns_blank_lines_and_a_byte_order_mark_do_not_shift_the_numbers() {
        let mut lines = Lines::new("\u{feff}# a\r\n\r\nb\n\nc".as_bytes(), false);
        let mut seen = Vec::new();
        while let Some((number, line)) = lines.next_line().unwrap() {
            seen.push(format!("{number}:{line}"));
        }
        assert_eq!(seen, ["1:# a", "2:", "3:b", "4:", "5:c"]);
    }

    #[test]
    fn an_endless_line_is_refused() {
        let mut lines = Lines::new(io::BufReader::new(io::repeat(0)), false);
        assert!(matches!(lines.next_line().map_err(|e| e.fault), Err(Fault::LineTooLong(_))));
    }
}
