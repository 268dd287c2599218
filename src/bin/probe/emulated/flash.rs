//! Flash played by files, for the emulated chip's own is read-only: sectors 1 to 3, and the factory's region.
//! Programming clears bits, erasing sets them.

use crate::console::{Word::Text, complain};
use core::ffi::CStr;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use semihosting::{
    fs::{File, OpenOptions},
    io::{Read, Seek, SeekFrom, Write},
    process,
};

const SECTOR: usize = 16 * 1024;
/// The models' sectors.
pub const MODELS: (&CStr, usize) = (c"flash.bin", 3 * SECTOR);
/// The factory's region.
pub const FACTORY: (&CStr, usize) = (c"factory.bin", SECTOR);
const WORD: usize = 4;
/// Exit status of a run whose power was cut.
const POWER_CUT: i32 = 3;

pub struct FileFlash {
    file: File,
    bytes: usize,
    /// Words that are programmed, and sectors that are erased, before the power goes.
    left: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    OutOfBounds,
    NotAligned,
    File,
}

impl FileFlash {
    /// `None`: there is no such file, and the probe has no such memory.
    pub fn open((name, bytes): (&CStr, usize), power_cut_after: Option<u32>) -> Option<Self> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).open(name).ok()?;
        Some(Self { file, bytes, left: power_cut_after })
    }

    /// Counts one word or sector more; returns false if the power goes in it.
    fn spend(&mut self) -> bool {
        match &mut self.left {
            None => true,
            Some(0) => false,
            Some(left) => {
                *left -= 1;
                true
            }
        }
    }

    fn read_at(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.file.seek(SeekFrom::Start(offset.into())).map_err(|_| FlashError::File)?;
        self.file.read_exact(bytes).map_err(|_| FlashError::File)
    }

    fn write_at(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.file.seek(SeekFrom::Start(offset.into())).map_err(|_| FlashError::File)?;
        self.file.write_all(bytes).map_err(|_| FlashError::File)
    }

    fn cut(&self) -> ! {
        complain(&[Text("the power is cut")]);
        process::exit(POWER_CUT)
    }
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::File => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for FileFlash {
    type Error = FlashError;
}

fn check(offset: u32, length: usize, (bytes, unit): (usize, usize)) -> Result<(), FlashError> {
    let offset = offset as usize;
    if offset.checked_add(length).is_none_or(|end| end > bytes) {
        return Err(FlashError::OutOfBounds);
    }
    if offset.is_multiple_of(unit) && length.is_multiple_of(unit) { Ok(()) } else { Err(FlashError::NotAligned) }
}

impl ReadNorFlash for FileFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check(offset, bytes.len(), (self.bytes, Self::READ_SIZE))?;
        self.read_at(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.bytes
    }
}

impl NorFlash for FileFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check(from, to.saturating_sub(from) as usize, (self.bytes, SECTOR))?;
        let blank = [0xFF; 256];
        for block in (from..to).step_by(blank.len()) {
            // Half of a sector is erased when the power goes in the middle of it.
            if block as usize % SECTOR == SECTOR / 2 && !self.spend() {
                self.cut();
            }
            self.write_at(block, &blank)?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check(offset, bytes.len(), (self.bytes, WORD))?;
        for (at, word) in (offset..).step_by(WORD).zip(bytes.chunks(WORD)) {
            let mut there = [0; WORD];
            self.read_at(at, &mut there)?;
            let whole = self.spend();
            // Half of a word is programmed when the power goes in the middle of it.
            let programmed = if whole { WORD } else { WORD / 2 };
            for (there, new) in there.iter_mut().zip(word).take(programmed) {
                *there &= new;
            }
            self.write_at(at, &there)?;
            if !whole {
                self.cut();
            }
        }
        Ok(())
    }
}
