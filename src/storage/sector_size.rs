//! Size of a sector: the flash's own erase size, or several of its pages.

use super::record::GRANULE;
use embedded_storage::nor_flash::NorFlash;

/// Size of sectors made of smaller pages, bytes: that of an STM32F4's sectors, which take the models of every
/// temperature and the filter's state.
const MADE_OF_PAGES: usize = 16 * 1024;
/// Smallest page that is a sector of its own, bytes.
const SMALLEST: usize = 8 * 1024;

/// Returns the bytes of a sector: the flash's erase size, or a multiple of it where that is small.
pub(super) const fn sector_bytes<F: NorFlash>() -> usize {
    if F::ERASE_SIZE >= SMALLEST {
        return F::ERASE_SIZE;
    }
    match MADE_OF_PAGES.checked_next_multiple_of(F::ERASE_SIZE) {
        Some(bytes) => bytes,
        None => 0,
    }
}

/// Returns the granules of a sector.
pub(super) const fn granules_of<F: NorFlash>() -> u16 {
    (sector_bytes::<F>() / GRANULE) as u16
}
