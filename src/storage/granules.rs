//! Flash as sectors of granules: addresses, blank checks, and a walk over the records.

use super::{
    StorageError,
    record::{GRANULE, Header, MAX_RECORD},
    sector_size::sector_bytes,
};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

const BLANK: [u8; GRANULE] = [0xFF; GRANULE];

/// Place where a record begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub sector: u8,
    pub granule: u16,
}

impl Place {
    pub fn address<F: NorFlash>(self) -> u32 {
        u32::from(self.sector) * sector_bytes::<F>() as u32 + u32::from(self.granule) * GRANULE as u32
    }
}

/// Findings of a walk beside the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Walked<E> {
    /// First granule of the blank ones at the end.
    pub free: u16,
    /// Runs of granules that are neither blank nor a record, or cannot be read.
    pub damaged: u32,
    /// Error if nothing at all could be read; `None` if something could.
    pub silent: Option<E>,
}

/// Reads, and retries once: a disturbed transfer does not mean that the word in flash is lost.
fn read<R: ReadNorFlash>(flash: &mut R, address: u32, bytes: &mut [u8]) -> Result<(), R::Error> {
    flash.read(address, bytes).or_else(|_| flash.read(address, bytes))
}

/// Walks over the records of the sector at `base`, in the granules from `first` to before `end`.
///
/// A record begins at a valid header, and its check holds. Granules that are neither blank nor in such a record are
/// damage: a record that was cut off or has rotted. So is a granule that cannot be read: flash with error correction
/// gives an error for a word that was torn (STM32H7, STM32G4: a double ECC error).
#[inline(never)]
pub(super) fn walk<R: ReadNorFlash>(
    flash: &mut R,
    base: u32,
    (first, end): (u16, u16),
    buffer: &mut [u8; MAX_RECORD],
    each: &mut dyn FnMut(&Header, &[u8], u16),
) -> Walked<R::Error> {
    let mut walked = Walked { free: first, damaged: 0, silent: None };
    let (mut in_damage, mut is_read) = (false, false);
    let mut granule = first;
    while granule < end {
        let here = granule;
        granule += 1;
        let address = base + u32::from(here) * GRANULE as u32;
        let Some((head, tail)) = buffer.split_first_chunk_mut::<GRANULE>() else { break };
        let header = match read(flash, address, head) {
            Ok(()) if *head == BLANK => {
                (in_damage, is_read) = (false, true);
                continue;
            }
            Ok(()) => {
                is_read = true;
                Header::parse(head).filter(|header| header.granules() <= end - here)
            }
            Err(e) => {
                walked.silent = Some(e);
                None
            }
        };
        walked.free = granule;
        if let Some(header) = header {
            let rest = tail.get_mut(..header.bytes() - GRANULE).filter(|rest| !rest.is_empty());
            let is_whole = rest.is_none_or(|rest| read(flash, address + GRANULE as u32, rest).is_ok());
            if let Some(payload) = header.payload(buffer).filter(|_| is_whole) {
                each(&header, payload, here);
                granule = here + header.granules();
                walked.free = granule;
                in_damage = false;
                continue;
            }
        }
        if !in_damage {
            walked.damaged = walked.damaged.saturating_add(1);
        }
        in_damage = true;
    }
    if is_read {
        walked.silent = None;
    }
    walked
}

/// Returns true if this many granules are erased; a granule that cannot be read counts as not erased.
pub(super) fn is_blank<R: ReadNorFlash>(flash: &mut R, base: u32, granules: u16) -> bool {
    (0..granules).all(|granule| {
        let mut bytes = [0; GRANULE];
        read(flash, base + u32::from(granule) * GRANULE as u32, &mut bytes).is_ok() && bytes == BLANK
    })
}

/// Returns true if the flash holds these bytes, a whole number of granules.
#[inline(never)]
pub(super) fn holds<R: ReadNorFlash>(flash: &mut R, address: u32, bytes: &[u8]) -> bool {
    (0..).zip(bytes.chunks(GRANULE)).all(|(k, expected)| {
        let mut there = [0; GRANULE];
        read(flash, address + k * GRANULE as u32, &mut there).is_ok() && there == *expected
    })
}

/// Reads the record at an address into the buffer; `None` if no whole record is there.
#[inline(never)]
pub(super) fn read_record<R: ReadNorFlash>(
    flash: &mut R,
    address: u32,
    buffer: &mut [u8; MAX_RECORD],
) -> Option<Header> {
    let (head, tail) = buffer.split_first_chunk_mut::<GRANULE>()?;
    read(flash, address, head).ok()?;
    let header = Header::parse(head)?;
    if let Some(rest) = tail.get_mut(..header.bytes() - GRANULE).filter(|rest| !rest.is_empty()) {
        read(flash, address + GRANULE as u32, rest).ok()?;
    }
    header.payload(buffer).map(|_| header)
}

/// Programs whole granules and reads them back.
#[inline(never)]
pub(super) fn program<F: NorFlash>(flash: &mut F, address: u32, bytes: &[u8]) -> Result<(), StorageError<F::Error>> {
    flash.write(address, bytes).map_err(StorageError::Flash)?;
    if holds(flash, address, bytes) { Ok(()) } else { Err(StorageError::NotVerified) }
}

#[cfg(test)]
mod tests;
