//! Sectors 1 to 3 of the internal flash, 16 KiB each, for models; and the factory's sector 11, which is only ever added
//! to. While a word is programmed or a sector erased, the chip fetches no instruction (RM0090 section 3.6).

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use stm32f4xx_hal::pac::{FLASH, flash::cr::PSIZE};

const SECTOR: usize = 16 * 1024;
const WORD: usize = 4;
/// The flash in the address space.
const START: usize = 0x0800_0000;
/// The models' sectors: their first number, their offset from the flash's beginning, their size.
const FIRST_SECTOR: u8 = 1;
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

fn copy(from: usize, bytes: &mut [u8]) {
    for (byte, address) in bytes.iter_mut().zip(from..) {
        // SAFETY: the callers stay within the flash, which is always readable; volatile, for it changes behind the
        // compiler's back.
        #[allow(unsafe_code)]
        unsafe {
            *byte = (address as *const u8).read_volatile();
        }
    }
}

/// The factory's records.
pub struct FactoryFlash;

impl ErrorType for FactoryFlash {
    type Error = FlashError;
}

impl ReadNorFlash for FactoryFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (FACTORY_BYTES, Self::READ_SIZE))?;
        copy(START + FACTORY + offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        FACTORY_BYTES
    }
}

impl NorFlash for FactoryFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    /// Refuses: nothing erases what the factory wrote.
    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), FlashError> {
        Err(FlashError::Refused)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (FACTORY_BYTES, WORD))?;
        // SAFETY: the models' flash has the registers, too; both are called by the main loop alone, and each call
        // leaves them locked.
        #[allow(unsafe_code)]
        let registers = unsafe { FLASH::steal() };
        ModelFlash(registers).program_words(START + FACTORY + offset, bytes)
    }
}

/// The models' sectors.
pub struct ModelFlash(pub FLASH);

impl ErrorType for ModelFlash {
    type Error = FlashError;
}

impl ReadNorFlash for ModelFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (MODELS_BYTES, Self::READ_SIZE))?;
        copy(START + MODELS + offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        MODELS_BYTES
    }
}

impl NorFlash for ModelFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let from = check(from, to.saturating_sub(from) as usize, (MODELS_BYTES, SECTOR))?;
        for sector in from / SECTOR..to as usize / SECTOR {
            self.erase_sector(FIRST_SECTOR + sector as u8)?;
        }
        self.0.cr().modify(|_, w| w.ser().clear_bit().lock().set_bit());
        self.forget_cached();
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let offset = check(offset, bytes.len(), (MODELS_BYTES, WORD))?;
        self.program_words(START + MODELS + offset, bytes)
    }
}

impl ModelFlash {
    /// Programs whole words of a sector in which there is no code.
    fn program_words(&mut self, start: usize, bytes: &[u8]) -> Result<(), FlashError> {
        self.unlock();
        let (words, _) = bytes.as_chunks::<WORD>();
        for (word, address) in words.iter().zip((start..).step_by(WORD)) {
            self.program(address, u32::from_le_bytes(*word))?;
        }
        self.0.cr().modify(|_, w| w.pg().clear_bit().lock().set_bit());
        self.forget_cached();
        Ok(())
    }

    /// Unlocks the flash (RM0090 section 3.6.1).
    fn unlock(&mut self) {
        if self.0.cr().read().lock().bit_is_set() {
            for key in [0x4567_0123, 0xCDEF_89AB] {
                // SAFETY: the register takes any word, and these two in this order.
                #[allow(unsafe_code)]
                self.0.keyr().write(|w| unsafe { w.key().bits(key) });
            }
        }
    }

    /// Erases 32 bits at a time (section 3.6.3): 500 ms at most, where bytes take 800 ms (DS8626, flash memory
    /// programming).
    fn erase_sector(&mut self, sector: u8) -> Result<(), FlashError> {
        self.unlock();
        // SAFETY: the number is that of one of the models' sectors, in which there is no code.
        #[allow(unsafe_code)]
        self.0.cr().modify(|_, w| unsafe {
            w.psize().variant(PSIZE::Psize32).pg().clear_bit().ser().set_bit().snb().bits(sector)
        });
        self.0.cr().modify(|_, w| w.strt().set_bit());
        self.finish()
    }

    /// Programs 32 bits at a time, which 2.7 to 3.6 V allow (section 3.6.2): a quarter of the time that bytes take.
    fn program(&mut self, address: usize, word: u32) -> Result<(), FlashError> {
        self.0.cr().modify(|_, w| w.psize().variant(PSIZE::Psize32).ser().clear_bit().pg().set_bit());
        // SAFETY: the address is an aligned word of the models' or the factory's sectors, in which there is no code;
        // the flash is unlocked for programming.
        #[allow(unsafe_code)]
        unsafe {
            (address as *mut u32).write_volatile(word);
        }
        self.finish()
    }

    /// Waits until the chip has programmed or erased.
    fn finish(&mut self) -> Result<(), FlashError> {
        while self.0.sr().read().bsy().bit_is_set() {}
        let status = self.0.sr().read();
        let refused = status.pgserr().bit() || status.pgperr().bit() || status.pgaerr().bit() || status.wrperr().bit();
        if refused {
            // Writing a one clears an error; then the flash is locked again.
            self.0.sr().modify(|_, w| {
                w.pgserr().clear_bit_by_one();
                w.pgperr().clear_bit_by_one();
                w.pgaerr().clear_bit_by_one();
                w.wrperr().clear_bit_by_one()
            });
            self.0.cr().modify(|_, w| w.pg().clear_bit().ser().clear_bit().lock().set_bit());
            return Err(FlashError::Refused);
        }
        Ok(())
    }

    /// Resets the data cache, which still has what the flash held before (section 3.5.2).
    fn forget_cached(&mut self) {
        if self.0.acr().read().dcen().bit_is_set() {
            self.0.acr().modify(|_, w| w.dcen().clear_bit());
            self.0.acr().modify(|_, w| w.dcrst().set_bit());
            self.0.acr().modify(|_, w| w.dcrst().clear_bit());
            self.0.acr().modify(|_, w| w.dcen().set_bit());
        }
    }
}
