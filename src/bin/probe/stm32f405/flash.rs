//! Sectors 1 to 3 of the internal flash, 16 KiB each, for models; and the factory's sector 11, which is only ever added
//! to. While a word is programmed or a sector erased, the chip fetches no instruction (RM0090 section 3.6).
//!
//! The driver does not name the chip, so that a host's test runs it on a model of the registers.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

const SECTOR: usize = 16 * 1024;
const WORD: usize = 4;
/// The flash in the address space.
const START: usize = 0x0800_0000;
/// The models' sectors: their first number, their offset from the flash's beginning, their size.
const FIRST_SECTOR: u32 = 1;
const MODELS: usize = 0x4000;
const MODELS_BYTES: usize = 3 * SECTOR;
/// The part of sector 11 that the factory's records may take.
const FACTORY: usize = 0xE_0000;
const FACTORY_BYTES: usize = SECTOR;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    OutOfBounds,
    NotAligned,
    /// The chip refused.
    Refused,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::Refused => NorFlashErrorKind::Other,
        }
    }
}

fn check(offset: u32, length: usize, (bytes, unit): (usize, usize)) -> Result<usize, FlashError> {
    let offset = offset as usize;
    if offset.checked_add(length).is_none_or(|end| end > bytes) {
        return Err(FlashError::OutOfBounds);
    }
    if offset.is_multiple_of(unit) && length.is_multiple_of(unit) { Ok(offset) } else { Err(FlashError::NotAligned) }
}

/// Bits of the control register `FLASH_CR` (RM0090 section 3.9.5).
mod control {
    pub const PROGRAM: u32 = 1 << 0;
    pub const ERASE_SECTOR: u32 = 1 << 1;
    /// Number of the sector to be erased, from this bit on.
    pub const SECTOR: u32 = 3;
    /// Parallelism of 32 bits, of the field's two bits.
    pub const WORDS: u32 = 0b10 << 8;
    pub const START: u32 = 1 << 16;
    pub const LOCK: u32 = 1 << 31;
}

/// Bits of the status register `FLASH_SR` (section 3.9.4).
mod status {
    /// Errors of write protection, alignment, parallelism and sequence.
    pub const ERRORS: u32 = 0b1111 << 4;
    pub const BUSY: u32 = 1 << 16;
}

/// Registers and memory of the flash.
pub trait Registers {
    /// Reads the control register.
    fn control(&self) -> u32;
    /// Writes the control register.
    fn set_control(&mut self, bits: u32);
    /// Writes the key register.
    fn set_key(&mut self, key: u32);
    /// Reads the status register.
    fn status(&self) -> u32;
    /// Writes the status register; a one clears an error.
    fn clear_status(&mut self, bits: u32);
    /// Reads a byte of the flash.
    fn load(&self, address: usize) -> u8;
    /// Writes a word into the flash, at an aligned address of a sector in which there is no code.
    fn store(&mut self, address: usize, word: u32);
    /// Runs an erasure, through which the core may stand still.
    fn across_a_stall<R>(&mut self, erase: impl FnOnce(&mut Self) -> R) -> R {
        erase(self)
    }
    /// Resets the data cache, which still has what the flash held before (section 3.5.2).
    fn forget_cached(&mut self);
}

fn copy(registers: &impl Registers, from: usize, bytes: &mut [u8]) {
    for (byte, address) in bytes.iter_mut().zip(from..) {
        *byte = registers.load(address);
    }
}

/// The factory's records.
pub struct FactoryFlash<R>(pub R);

impl<R> ErrorType for FactoryFlash<R> {
    type Error = FlashError;
}

impl<R: Registers> ReadNorFlash for FactoryFlash<R> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (FACTORY_BYTES, Self::READ_SIZE))?;
        copy(&self.0, START + FACTORY + offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        FACTORY_BYTES
    }
}

impl<R: Registers> NorFlash for FactoryFlash<R> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    /// Refuses: nothing erases what the factory wrote.
    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), FlashError> {
        Err(FlashError::Refused)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (FACTORY_BYTES, WORD))?;
        program_words(&mut self.0, START + FACTORY + offset, bytes)
    }
}

/// The models' sectors.
pub struct ModelFlash<R>(pub R);

impl<R> ErrorType for ModelFlash<R> {
    type Error = FlashError;
}

impl<R: Registers> ReadNorFlash for ModelFlash<R> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (MODELS_BYTES, Self::READ_SIZE))?;
        copy(&self.0, START + MODELS + offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        MODELS_BYTES
    }
}

impl<R: Registers> NorFlash for ModelFlash<R> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let from = check(from, to.saturating_sub(from) as usize, (MODELS_BYTES, SECTOR))?;
        for sector in from / SECTOR..to as usize / SECTOR {
            self.0.across_a_stall(|registers| erase_sector(registers, FIRST_SECTOR + sector as u32))?;
        }
        lock(&mut self.0);
        self.0.forget_cached();
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (MODELS_BYTES, WORD))?;
        program_words(&mut self.0, START + MODELS + offset, bytes)
    }
}

/// Unlocks the flash (RM0090 section 3.6.1).
fn unlock(registers: &mut impl Registers) {
    if registers.control() & control::LOCK != 0 {
        registers.set_key(0x4567_0123);
        registers.set_key(0xCDEF_89AB);
    }
}

fn lock(registers: &mut impl Registers) {
    registers.set_control(control::LOCK);
}

/// Erases 32 bits at a time (section 3.6.3), which 2.7 to 3.6 V allow (section 3.6.2): 500 ms at most, where bytes
/// take 800 ms (DS8626, flash memory programming).
fn erase_sector(registers: &mut impl Registers, sector: u32) -> Result<(), FlashError> {
    unlock(registers);
    let erase = control::WORDS | control::ERASE_SECTOR | sector << control::SECTOR;
    registers.set_control(erase);
    registers.set_control(erase | control::START);
    finish(registers)
}

/// Programs whole words of a sector in which there is no code, 32 bits at a time: a quarter of the time that bytes
/// take.
fn program_words(registers: &mut impl Registers, start: usize, bytes: &[u8]) -> Result<(), FlashError> {
    unlock(registers);
    let (words, _) = bytes.as_chunks::<WORD>();
    for (word, address) in words.iter().zip((start..).step_by(WORD)) {
        registers.set_control(control::WORDS | control::PROGRAM);
        registers.store(address, u32::from_le_bytes(*word));
        finish(registers)?;
    }
    lock(registers);
    registers.forget_cached();
    Ok(())
}

/// Waits until the chip has programmed or erased.
fn finish(registers: &mut impl Registers) -> Result<(), FlashError> {
    while registers.status() & status::BUSY != 0 {}
    if registers.status() & status::ERRORS == 0 {
        return Ok(());
    }
    registers.clear_status(status::ERRORS);
    lock(registers);
    Err(FlashError::Refused)
}
