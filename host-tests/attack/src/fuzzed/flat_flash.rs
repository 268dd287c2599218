//! A NOR flash that does what a data sheet says and nothing else. The mock with power cuts draws a random number for
//! each byte that it erases, which was half of the time of a fuzzed history.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Word, bytes: a place may be programmed once between two erasures.
const WORD: usize = 4;

/// The flash, of sectors of `SECTOR` bytes.
pub(super) struct FlatFlash<const SECTOR: usize>(pub Vec<u8>);

impl<const SECTOR: usize> ErrorType for FlatFlash<SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const SECTOR: usize> ReadNorFlash for FlatFlash<SECTOR> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl<const SECTOR: usize> NorFlash for FlatFlash<SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        self.0[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let places = &mut self.0[offset as usize..][..bytes.len()];
        // Programmed twice, a word of a flash that corrects errors cannot be read any more.
        if places.iter().any(|place| *place != 0xFF) {
            return Err(NorFlashErrorKind::Other);
        }
        places.copy_from_slice(bytes);
        Ok(())
    }
}
