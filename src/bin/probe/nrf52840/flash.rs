//! The end of the internal flash: twelve pages of 4 KiB for models, four to a sector, and four for the
//! factory's records, which nothing here writes.

use core::slice;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use nrf52840_hal::{
    nvmc::{Nvmc, NvmcError},
    pac::NVMC,
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

/// The factory's.
pub struct FactoryFlash(&'static [u8]);

/// Both; once, for there is one `NVMC`.
pub fn split(nvmc: NVMC) -> (ModelFlash, FactoryFlash) {
    let start = &raw mut symbols::_storage_start;
    // SAFETY: the linker keeps these bytes free of everything else, the owner of the only `NVMC` comes here once, and
    // the two slices do not overlap.
    #[allow(unsafe_code)]
    let (models, factory) = unsafe {
        (slice::from_raw_parts_mut(start, MODELS_BYTES), slice::from_raw_parts(start.add(MODELS_BYTES), FACTORY_BYTES))
    };
    (ModelFlash(Nvmc::new(nvmc, models)), FactoryFlash(factory))
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

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NvmcError> {
        self.0.erase(from, to)
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
        let from = offset as usize;
        let there =
            from.checked_add(bytes.len()).and_then(|end| self.0.get(from..end)).ok_or(NvmcError::OutOfBounds)?;
        bytes.copy_from_slice(there);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}
