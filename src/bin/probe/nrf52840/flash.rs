//! The end of the internal flash: twelve pages of 4 KiB for models, four to a sector, and four for the
//! factory's records, which are only ever added to.

use super::timer;
use core::slice;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use nrf52840_hal::{
    nvmc::{Nvmc, NvmcError},
    pac::{NVMC, Peripherals},
};

const PAGE: usize = 4 * 1024;
const MODELS_BYTES: usize = 12 * PAGE;
const FACTORY_BYTES: usize = 4 * PAGE;

#[allow(unsafe_code)]
mod symbols {
    // SAFETY: the board's linker script defines it; only its address means anything.
    unsafe extern "C" {
        /// The region that the linker keeps free: 64 KiB.
        pub safe static mut _storage_start: u8;
    }
}

/// The models' pages.
pub struct ModelFlash(Nvmc<NVMC>);

/// The factory's pages.
pub struct FactoryFlash(Nvmc<NVMC>);

/// Returns both regions; once, for there is one `NVMC`.
pub fn split(nvmc: NVMC) -> (ModelFlash, FactoryFlash) {
    let start = &raw mut symbols::_storage_start;
    // SAFETY: the linker keeps these bytes free of everything else, the owner of the only `NVMC` comes here once, and
    // the two slices do not overlap.
    #[allow(unsafe_code)]
    let (models, factory) = unsafe {
        (
            slice::from_raw_parts_mut(start, MODELS_BYTES),
            slice::from_raw_parts_mut(start.add(MODELS_BYTES), FACTORY_BYTES),
        )
    };
    // SAFETY: both are called by the main loop alone, and each call leaves the registers as it found them.
    #[allow(unsafe_code)]
    let again = unsafe { Peripherals::steal() }.NVMC;
    (ModelFlash(Nvmc::new(nvmc, models)), FactoryFlash(Nvmc::new(again, factory)))
}

impl ErrorType for ModelFlash {
    type Error = NvmcError;
}

impl ReadNorFlash for ModelFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NvmcError> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for ModelFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    /// The core stands still for 85 ms a page (product specification, NVMC).
    fn erase(&mut self, from: u32, to: u32) -> Result<(), NvmcError> {
        timer::across_a_stall(|| self.0.erase(from, to))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NvmcError> {
        self.0.write(offset, bytes)
    }
}

impl ErrorType for FactoryFlash {
    type Error = NvmcError;
}

impl ReadNorFlash for FactoryFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NvmcError> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for FactoryFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    /// Refuses: nothing erases what the factory wrote.
    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), NvmcError> {
        Err(NvmcError::OutOfBounds)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NvmcError> {
        self.0.write(offset, bytes)
    }
}
