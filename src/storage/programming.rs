//! A record on its way from the buffer into the flash, 32 bytes at a time.

use super::{
    StorageError,
    granules::{Place, holds},
    record::{GRANULE, MAX_RECORD},
};
use embedded_storage::nor_flash::NorFlash;

/// Progress of a record that is being programmed.
#[derive(Clone, Copy)]
pub(super) struct Programming {
    pub place: Place,
    /// Granules of the record, and how many of them are programmed.
    granules: u16,
    done: u16,
}

impl Programming {
    /// Nothing is left to program.
    pub const NOTHING: Self = Self::new(Place { sector: 0, granule: 0 }, 0);

    /// Begins a record.
    pub const fn new(place: Place, granules: u16) -> Self {
        Self { place, granules, done: 0 }
    }

    /// Returns true if the whole record is programmed.
    pub const fn is_done(&self) -> bool {
        self.done == self.granules
    }

    /// Programs the next 32 bytes of the record, which begins the buffer. After the last of them reads it back, and
    /// returns `true`.
    pub fn next<F: NorFlash>(
        &mut self,
        flash: &mut F,
        buffer: &[u8; MAX_RECORD],
    ) -> Result<bool, StorageError<F::Error>> {
        let place = Place { granule: self.place.granule + self.done, ..self.place };
        let begin = usize::from(self.done) * GRANULE;
        let bytes = buffer.get(begin..begin + GRANULE).unwrap_or_default();
        flash.write(place.address::<F>(), bytes).map_err(StorageError::Flash)?;
        self.done += 1;
        if !self.is_done() {
            return Ok(false);
        }
        let bytes = buffer.get(..begin + GRANULE).unwrap_or_default();
        if holds(flash, self.place.address::<F>(), bytes) { Ok(true) } else { Err(StorageError::NotVerified) }
    }
}
