//! The command counter, and what has been retired.

use super::{
    ModelStore, StorageError,
    granules::program,
    index::Single,
    record::{GRANULE, Kind, encode},
};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// The command counter; 0 before the first was stored.
    #[must_use]
    pub const fn read_counter(&self) -> u64 {
        match self.index.counter {
            Some(counter) => counter.value,
            None => 0,
        }
    }

    /// Stores the command counter, twice, before the command that it came with is done. At most 16 words are programmed.
    ///
    /// # Errors
    /// The counter that is stored stays: the new one is no higher, there is no room, or the flash failed.
    pub fn store_counter(&mut self, counter: u64) -> Result<(), StorageError<F::Error>> {
        let stored = self.read_counter();
        if counter <= stored {
            return Err(StorageError::CounterGoesBack { stored });
        }
        let sector = self.write_single(Kind::COUNTER, counter, 1)?;
        self.index.counter = Some(Single { value: counter, sector });
        Ok(())
    }

    /// From here on no model that is stored now is restored; nothing is erased.
    ///
    /// # Errors
    /// The models stay: one is being written, there is no room, or the flash failed.
    pub fn retire_models(&mut self) -> Result<(), StorageError<F::Error>> {
        self.retire_models_before(self.index.last_number.saturating_add(1))
    }

    /// The same for the models of lower numbers alone.
    ///
    /// # Errors
    /// As [`ModelStore::retire_models`].
    pub fn retire_models_before(&mut self, number: u32) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        // Parts without a model may be among those numbers.
        self.learnt_number = None;
        let last = u64::from(number.saturating_sub(1));
        let sector = self.write_single(Kind::RETIREMENT, last, 1)?;
        self.index.retired = Some(Single { value: last, sector });
        self.index.retire();
        Ok(())
    }

    /// Writes two records with one value each, so that one can rot; returns their sector.
    pub(super) fn write_single(
        &mut self,
        kind: Kind,
        value: u64,
        reserve: usize,
    ) -> Result<u8, StorageError<F::Error>> {
        let Some(place) = self.take_room(2, reserve, 0) else { return self.refuse_full() };
        let number = self.index.last_number.saturating_add(1);
        self.index.last_number = number;
        let mut record = [0; GRANULE];
        encode(&mut record, kind, 1, number, |writer| writer.u64(value));
        let first = program(&mut self.flash, place.address::<F>(), &record);
        let second = program(&mut self.flash, place.address::<F>() + GRANULE as u32, &record);
        match first.or(second) {
            Ok(()) => Ok(place.sector),
            Err(e) => self.failed(e),
        }
    }
}
