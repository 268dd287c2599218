//! The records, written in large pieces.

use super::fault::Fault;
use core::ffi::CStr;
use meerkat_mwd::emulation::Record;
use semihosting::{fs::File, io::Write};

/// Size of the buffer; a record takes at most some 400 bytes of it.
pub const CAPACITY: usize = 2048;

pub struct RecordWriter {
    file: File,
    buffer: &'static mut [u8; CAPACITY],
    used: usize,
}

impl RecordWriter {
    pub fn create(path: &CStr, buffer: &'static mut [u8; CAPACITY]) -> Result<Self, Fault> {
        let file = File::create(path).map_err(|_| Fault::FlightNotWritten)?;
        Ok(Self { file, buffer, used: 0 })
    }

    pub fn write(&mut self, record: &Record) -> Result<(), Fault> {
        if !self.encode(record) {
            self.flush()?;
            if !self.encode(record) {
                return Err(Fault::RecordTooLarge);
            }
        }
        Ok(())
    }

    /// Writes what is still in the buffer.
    pub fn close(mut self) -> Result<(), Fault> {
        self.flush()
    }

    /// Encodes a record; returns true if it found room.
    fn encode(&mut self, record: &Record) -> bool {
        let room = self.buffer.get_mut(self.used..).unwrap_or_default();
        match postcard::to_slice(record, room) {
            Ok(encoded) => {
                self.used += encoded.len();
                true
            }
            Err(_) => false,
        }
    }

    fn flush(&mut self) -> Result<(), Fault> {
        let bytes = self.buffer.get(..self.used).unwrap_or_default();
        self.file.write_all(bytes).map_err(|_| Fault::FlightNotWritten)?;
        self.used = 0;
        Ok(())
    }
}
