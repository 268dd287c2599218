//! Size of a sector: the flash's own erase size, or several of its pages.

use super::record::GRANULE;
use embedded_storage::nor_flash::NorFlash;

/// Sectors made of smaller pages, bytes: those of the STM32F4, which take the models of every temperature and
/// what the filter has learnt.
const MADE_OF_PAGES: usize = 16 * 1024;
/// Smallest page that is a sector of its own, bytes.
const SMALLEST: usize = 8 * 1024;

/// Bytes of a sector: what the flash erases at a time, or several of that where it is small.
pub(super) const fn sector_bytes<F: NorFlash>() -> usize {
    if F::ERASE_SIZE >= SMALLEST {
        return F::ERASE_SIZE;
    }
    match MADE_OF_PAGES.checked_next_multiple_of(F::ERASE_SIZE) {
        Some(bytes) => bytes,
        None => 0,
    }
}

/// Granules of a sector.
pub(super) const fn granules_of<F: NorFlash>() -> u16 {
    (sector_bytes::<F>() / GRANULE) as u16
}
