//! Two images of the program in an external NOR flash, as loader and program of the emulated MPS2 have it: mapped into
//! the address space to be read, and kept in the file `images.bin`, which outlives the emulator. Programming clears
//! bits, erasing sets them.
//!
//! `cut.bin`, four bytes, little-endian, if it is there: words programmed and pages erased from the power-up on, in
//! loader and program together, before the power is cut.

use core::ptr;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use meerkat_mwd::storage::Slot;
use semihosting::{
    fs::{File, OpenOptions},
    io::{Read, Seek, SeekFrom, Write},
    process,
};

/// Where the flash is mapped: the machine's PSRAM, which a reset leaves alone.
const MAPPED: usize = 0x2100_0000;
/// Two slots of 1 MiB.
pub const REGION: usize = 2 * 1024 * 1024;
const PAGE: usize = 64 * 1024;
const WORD: usize = 4;
/// Exit status of a run whose power was cut.
const POWER_CUT: i32 = 3;
/// Mark of words that a loader has written since power came.
const MAGIC: u32 = 0x6d77_6432;
/// Value of [`Handover::left`] where no power is cut.
const NEVER: u32 = u32::MAX;

/// Words behind the flash that loader and program share.
struct Handover {
    magic: u32,
    /// Words and pages before the power is cut.
    left: u32,
    /// Slot of the image that runs: 0 or 1.
    running: u32,
}

#[allow(unsafe_code)]
fn handover() -> Handover {
    // SAFETY: aligned RAM behind the flash that only loader and program use, one after the other; any words are valid.
    unsafe { ptr::read_volatile((MAPPED + REGION) as *const Handover) }
}

#[allow(unsafe_code)]
fn hand_over(words: Handover) {
    // SAFETY: as above.
    unsafe { ptr::write_volatile((MAPPED + REGION) as *mut Handover, words) }
}

/// The slot that the loader has chosen; `None`: there was no loader.
#[allow(dead_code)] // The loader asks nobody.
pub fn running() -> Option<Slot> {
    match handover() {
        Handover { magic: MAGIC, running: 0, .. } => Some(Slot::First),
        Handover { magic: MAGIC, running: 1, .. } => Some(Slot::Second),
        _ => None,
    }
}

/// Notes the slot that is started.
#[allow(dead_code)] // The program starts nobody.
pub fn start(slot: Slot) {
    hand_over(Handover { running: u32::from(slot == Slot::Second), ..handover() });
}

/// The flash; there is one.
pub struct Images {
    file: File,
    bytes: &'static mut [u8],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImagesError {
    Arguments(NorFlashErrorKind),
    File,
}

impl Images {
    /// Opens the file; after power-up it is read into the mapped memory. Call it once in a program. `None`: there is
    /// no such file.
    pub fn open() -> Option<Self> {
        let mut file = OpenOptions::new().read(true).write(true).open(c"images.bin").ok()?;
        // SAFETY: 2 MiB of RAM that nothing else is linked to, of bytes that are zero at power-up.
        #[allow(unsafe_code)]
        let bytes = unsafe { core::slice::from_raw_parts_mut(MAPPED as *mut u8, REGION) };
        if handover().magic != MAGIC {
            file.read_exact(bytes).ok()?;
            let mut left = [0xFF; 4];
            if let Ok(mut cut) = File::open(c"cut.bin") {
                cut.read_exact(&mut left).ok()?;
            }
            hand_over(Handover { magic: MAGIC, left: u32::from_le_bytes(left), running: u32::MAX });
        }
        Some(Self { file, bytes })
    }

    /// Bytes from an address to the flash's end.
    #[allow(dead_code)] // The program reads through the slots.
    pub fn mapped(&self, from: u32) -> &[u8] {
        self.bytes.get(from as usize..).unwrap_or_default()
    }

    /// Counts one word or page more; returns false if the power goes in it.
    fn spend() -> bool {
        let words = handover();
        match words.left {
            NEVER => true,
            0 => false,
            left => {
                hand_over(Handover { left: left - 1, ..words });
                true
            }
        }
    }

    /// Writes bytes through to the file.
    fn keep(&mut self, from: usize, to: usize) -> Result<(), ImagesError> {
        let bytes = self.bytes.get(from..to).unwrap_or_default();
        self.file.seek(SeekFrom::Start(from as u64)).map_err(|_| ImagesError::File)?;
        self.file.write_all(bytes).map_err(|_| ImagesError::File)
    }
}

impl NorFlashError for ImagesError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            Self::File => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for Images {
    type Error = ImagesError;
}

impl ReadNorFlash for Images {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ImagesError> {
        let from = offset as usize;
        let there = self.bytes.get(from..from.saturating_add(bytes.len()));
        bytes.copy_from_slice(there.ok_or(ImagesError::Arguments(NorFlashErrorKind::OutOfBounds))?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        REGION
    }
}

impl NorFlash for Images {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), ImagesError> {
        embedded_storage::nor_flash::check_erase(self, from, to).map_err(ImagesError::Arguments)?;
        for page in (from as usize..to as usize).step_by(PAGE) {
            let whole = Self::spend();
            // Half of a page is erased when the power goes in the middle of it.
            let end = page + if whole { PAGE } else { PAGE / 2 };
            self.bytes.get_mut(page..end).unwrap_or_default().fill(0xFF);
            self.keep(page, end)?;
            if !whole {
                process::exit(POWER_CUT)
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ImagesError> {
        embedded_storage::nor_flash::check_write(self, offset, bytes.len()).map_err(ImagesError::Arguments)?;
        let from = offset as usize;
        let to = from + bytes.len();
        let mut end = to;
        for (word, new) in (from..to).step_by(WORD).zip(bytes.chunks(WORD)) {
            let whole = Self::spend();
            // Half of a word is programmed when the power goes in the middle of it.
            let programmed = if whole { WORD } else { WORD / 2 };
            let there = self.bytes.get_mut(word..word + programmed).unwrap_or_default();
            there.iter_mut().zip(new).for_each(|(there, new)| *there &= new);
            if !whole {
                end = word + programmed;
                break;
            }
        }
        self.keep(from, end)?;
        if end < to {
            process::exit(POWER_CUT)
        }
        Ok(())
    }
}
