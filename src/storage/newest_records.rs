//! Records of which only the newest of its kind counts: the dose of vibration, and what commands have set.

use super::{
    ModelStore, StorageError,
    granules::Place,
    little_endian::Writer,
    newest::KINDS,
    record::{Header, Kind, encode},
    room,
};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Begins to store a record; [`ModelStore::step`] programs it piece by piece. The one before counts until the new
    /// one is whole. `margin` granules stay free in the last sector that may be begun.
    #[inline(never)]
    pub(super) fn begin_newest(
        &mut self,
        kind: Kind,
        version: u8,
        margin: u16,
        payload: &dyn Fn(&mut Writer<'_>),
    ) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let number = self.index.last_number.saturating_add(1);
        let encoded = encode(&mut self.buffer, kind, version, number, payload);
        let granules = encoded.ok_or(StorageError::Full)?;
        let place = room::take::<F>(&mut self.sectors, granules, 1, margin).ok_or(StorageError::Full)?;
        self.index.last_number = number;
        // Parts of the estimator's state that wait for their model have an earlier number: they are given up.
        self.learnt_number = None;
        self.begin_writing(kind, number, place, granules);
        Ok(())
    }

    /// Reads the newest whole record of a kind into the buffer; `None` if there is none, and while the buffer holds a
    /// record that is being written.
    #[inline(never)]
    pub(super) fn read_newest(&mut self, kind: Kind) -> Option<Header> {
        if self.is_writing() {
            return None;
        }
        loop {
            let newest = self.index.newest.of(kind);
            let (_, place) = newest?;
            let header = self.read_record(place);
            if header.is_some() {
                return header;
            }
            // The one before counts again; each is dropped at most once.
            self.forget_rotten(place);
            if self.index.newest.of(kind) == newest {
                return None;
            }
        }
    }

    /// Copies them in the same way as the models. Returns false if one has rotted.
    pub(super) fn copy_newest(&mut self, from: u8) -> Result<bool, StorageError<F::Error>> {
        for kind in KINDS {
            let last_found = self.last_found;
            let goes = |place: &Place| place.sector == from || Some(*place) == last_found;
            let Some((number, place)) = self.index.newest.of(kind).filter(|(_, place)| goes(place)) else { continue };
            let Some(copy) = self.copy(place)? else {
                self.forget_rotten(place);
                return Ok(false);
            };
            self.last_found = self.last_found.filter(|last| *last != place);
            self.index.newest.note(kind, number, copy);
        }
        Ok(true)
    }
}
