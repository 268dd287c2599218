//! The recorded trace, read a kilobyte at a time: a semihosting call costs far more than to decode the twenty samples
//! in it.

use super::fault::Fault;
use core::ffi::CStr;
use semihosting::{fs::File, io::Read};
use serde::de::DeserializeOwned;

/// Bytes asked for in one call.
const READ: usize = 1024;
/// No item is longer than this in postcard's encoding (a `Config` takes under 500 bytes, a `Sample` at most 53).
const LONGEST_ITEM: usize = 1024;
/// Size of the buffer.
pub const CAPACITY: usize = READ + LONGEST_ITEM;

pub struct TraceReader {
    file: File,
    buffer: &'static mut [u8; CAPACITY],
    start: usize,
    end: usize,
    at_end_of_file: bool,
}

impl TraceReader {
    pub fn open(path: &CStr, buffer: &'static mut [u8; CAPACITY]) -> Result<Self, Fault> {
        let file = File::open(path).map_err(|_| Fault::TraceMissing)?;
        Ok(Self { file, buffer, start: 0, end: 0, at_end_of_file: false })
    }

    /// Returns the next item; `None` at the end of the file.
    pub fn next<T: DeserializeOwned>(&mut self) -> Result<Option<T>, Fault> {
        while self.end - self.start < LONGEST_ITEM && !self.at_end_of_file {
            self.refill()?;
        }
        let bytes = self.buffer.get(self.start..self.end).unwrap_or_default();
        if bytes.is_empty() {
            return Ok(None);
        }
        let (item, rest) = postcard::take_from_bytes(bytes).map_err(|_| Fault::TraceMalformed)?;
        self.start = self.end - rest.len();
        Ok(Some(item))
    }

    /// Moves what is left to the front, so that there is room for a whole read behind it.
    fn refill(&mut self) -> Result<(), Fault> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        let room = self.buffer.get_mut(self.end..self.end + READ).unwrap_or_default();
        let read = self.file.read(room).map_err(|_| Fault::TraceUnreadable)?;
        self.at_end_of_file = read == 0;
        self.end += read;
        Ok(())
    }
}
