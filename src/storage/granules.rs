//! Flash as sectors of granules: addresses, blank checks, and a walk over the records.

use super::{
    StorageError,
    record::{GRANULE, Header, MAX_RECORD},
};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

const BLANK: [u8; GRANULE] = [0xFF; GRANULE];

/// Where a record begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub sector: u8,
    pub granule: u16,
}

impl Place {
    pub fn address<F: NorFlash>(self) -> u32 {
        u32::from(self.sector) * F::ERASE_SIZE as u32 + u32::from(self.granule) * GRANULE as u32
    }
}

/// What a walk found beside the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Walked {
    /// First granule of the blank ones at the end.
    pub free: u16,
    /// Runs of granules that are neither blank nor a record.
    pub damaged: u32,
}

/// Walks over the records in the granules from `first` to before `end` of what begins at `base`.
///
/// A record begins where a header with the right check does; what lies between two is a record that was cut off or has rotted.
#[inline(never)]
pub(super) fn walk<R: ReadNorFlash>(
    flash: &mut R,
    base: u32,
    (first, end): (u16, u16),
    buffer: &mut [u8; MAX_RECORD],
    each: &mut dyn FnMut(&Header, &[u8], u16),
) -> Result<Walked, R::Error> {
    let mut walked = Walked { free: first, damaged: 0 };
    let mut in_damage = false;
    let mut granule = first;
    while granule < end {
        let here = granule;
        granule += 1;
        let address = base + u32::from(here) * GRANULE as u32;
        let Some((head, tail)) = buffer.split_first_chunk_mut::<GRANULE>() else { break };
        flash.read(address, head)?;
        if *head == BLANK {
            in_damage = false;
            continue;
        }
        walked.free = granule;
        let header = Header::parse(head).filter(|header| header.granules() <= end - here);
        if let Some(header) = header {
            if let Some(rest) = tail.get_mut(..header.bytes() - GRANULE).filter(|rest| !rest.is_empty()) {
                flash.read(address + GRANULE as u32, rest)?;
            }
            if let Some(payload) = header.payload(buffer) {
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
    Ok(walked)
}

/// Whether so many granules are erased.
pub(super) fn is_blank<R: ReadNorFlash>(flash: &mut R, base: u32, granules: u16) -> Result<bool, R::Error> {
    for granule in 0..granules {
        let mut read = [0; GRANULE];
        flash.read(base + u32::from(granule) * GRANULE as u32, &mut read)?;
        if read != BLANK {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether the flash reads as these whole granules.
#[inline(never)]
pub(super) fn holds<R: ReadNorFlash>(flash: &mut R, address: u32, bytes: &[u8]) -> Result<bool, R::Error> {
    for (k, expected) in (0..).zip(bytes.chunks(GRANULE)) {
        let mut read = [0; GRANULE];
        flash.read(address + k * GRANULE as u32, &mut read)?;
        if read != *expected {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Programs whole granules and reads them back.
#[inline(never)]
pub(super) fn program<F: NorFlash>(flash: &mut F, address: u32, bytes: &[u8]) -> Result<(), StorageError<F::Error>> {
    flash.write(address, bytes).map_err(StorageError::Flash)?;
    match holds(flash, address, bytes) {
        Ok(true) => Ok(()),
        Ok(false) => Err(StorageError::NotVerified),
        Err(e) => Err(StorageError::Flash(e)),
    }
}
