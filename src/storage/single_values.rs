//! Single values: the command counter and the retirement of models. Each is written twice, so that one copy can rot.

use super::{
    ModelStore, StorageError,
    granules::program,
    record::{GRANULE, Kind, encode},
};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Returns the command counter; 0 before the first was stored.
    #[must_use]
    pub const fn read_counter(&self) -> u64 {
        match self.index.counter.value() {
            Some(counter) => counter,
            None => 0,
        }
    }

    /// Stores the command counter, twice, before its command is carried out. At most 16 words are programmed.
    ///
    /// # Errors
    /// The stored counter stays: the new one is no higher, there is no room, or the flash failed.
    pub fn store_counter(&mut self, counter: u64) -> Result<(), StorageError<F::Error>> {
        let stored = self.read_counter();
        if counter <= stored {
            return Err(StorageError::CounterGoesBack { stored });
        }
        self.write_single(Kind::COUNTER, counter, 1).or_else(|e| self.refused(e))
    }

    /// Retires all stored models: none is restored any more. Nothing is erased.
    ///
    /// # Errors
    /// The models stay: one is being written, there is no room, or the flash failed.
    pub fn retire_models(&mut self) -> Result<(), StorageError<F::Error>> {
        self.retire_models_before(self.index.last_number.saturating_add(1))
    }

    /// Retires only the models with numbers below `number`.
    ///
    /// # Errors
    /// As [`ModelStore::retire_models`].
    pub fn retire_models_before(&mut self, number: u32) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        // Parts of the filter's state that wait for their model may have a number in that range: they are given up.
        self.learnt_number = None;
        let last = u64::from(number.saturating_sub(1));
        self.write_single(Kind::RETIREMENT, last, 1).or_else(|e| self.refused(e))?;
        self.index.retire();
        Ok(())
    }

    /// Counts a value that is refused for want of room.
    fn refused(&mut self, error: StorageError<F::Error>) -> Result<(), StorageError<F::Error>> {
        if matches!(error, StorageError::Full) { self.refuse_full() } else { Err(error) }
    }

    /// Writes two records with one value each, so that one can rot.
    pub(super) fn write_single(
        &mut self,
        kind: Kind,
        value: u64,
        reserve: usize,
    ) -> Result<(), StorageError<F::Error>> {
        let place = self.take_room(2, reserve, 0).ok_or(StorageError::Full)?;
        let number = self.index.last_number.saturating_add(1);
        self.index.last_number = number;
        let mut record = [0; GRANULE];
        encode(&mut record, kind, 1, number, |writer| writer.u64(value));
        let first = program(&mut self.flash, place.address::<F>(), &record);
        let second = program(&mut self.flash, place.address::<F>() + GRANULE as u32, &record);
        let rising = if kind == Kind::COUNTER { &mut self.index.counter } else { &mut self.index.retired };
        // A single copy is found at the next power-up, so it counts from now on.
        for _ in [&first, &second].into_iter().filter(|written| written.is_ok()) {
            rising.note(value, place.sector);
        }
        first.and(second).or_else(|e| self.failed(e))
    }
}
