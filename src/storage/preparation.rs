//! Preparation: the only place where sectors are erased, never while drilling. Records that count are copied out of a
//! sector before it is erased.

use super::{
    ModelStore, StorageError,
    granules::{Place, program},
    index::{Index, KEPT, Slot},
    record::{GRANULE, Kind},
    room,
    sector::State,
    sector_size::granules_of,
};
use embedded_storage::nor_flash::NorFlash;

/// Promise of the caller that no sample matters now: erasing stops the processor for as long as the data sheet says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum NotDrilling {
    /// Before the first sample after power-up.
    PowerUp,
    /// On a command, which is refused while drilling.
    Command,
}

/// Progress of the preparation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Preparation {
    /// A page of a sector has been erased; there is more to do.
    More,
    /// All but one sector are ready or bad.
    Ready {
        /// Number of bad sectors.
        bad: u8,
    },
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Makes all sectors but one ready; records that count are copied first. Call it until it returns ready: each
    /// call erases at most one page of the flash, so that a watchdog can be fed between.
    ///
    /// # Errors
    /// A model is being written, or the flash failed. Stored records stay.
    #[inline(never)]
    pub fn prepare(&mut self, _why: NotDrilling) -> Result<Preparation, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        // A single copy left by a loss of power may not last, so it is written again. Without room for that, the older
        // values behind it are not erased.
        match self.rewrite_singles(None) {
            Ok(()) | Err(StorageError::Full) => {}
            Err(e) => return Err(e),
        }
        if let Some(unready) = self.first_of(State::Unready) {
            self.erase(unready)?;
            return Ok(Preparation::More);
        }
        let in_state = |state| self.sectors.iter().filter(|sector| sector.state == state).count();
        let (used, bad) = (in_state(State::Used), in_state(State::Bad));
        let oldest = self.first_of(State::Used).filter(|oldest| used > 1 || self.is_cramped(*oldest));
        let Some(oldest) = oldest else { return Ok(Preparation::Ready { bad: bad as u8 }) };
        match self.evacuate(oldest) {
            Ok(()) => self.erase(oldest)?,
            // Power cuts during one preparation after another have filled the room with torn copies.
            Err(StorageError::Full) => match self.redundant() {
                Some(redundant) => {
                    self.erase(redundant)?;
                    self.look_again();
                }
                None => self.abandon(oldest)?,
            },
            Err(e) => return Err(e),
        }
        Ok(Preparation::More)
    }

    /// Returns true if the only sector in use is over three quarters full, so that it has to be rewritten: other
    /// sectors are bad, and none could be begun while drilling.
    fn is_cramped(&self, number: u8) -> bool {
        let free = self.sectors.get(usize::from(number)).map_or(0, |sector| sector.free);
        room::ready(&self.sectors) == 1 && u32::from(free) * 4 > u32::from(granules_of::<F>()) * 3
    }

    /// Returns the first sector, in the order of erasure, that has this state.
    fn first_of(&self, state: State) -> Option<u8> {
        let those = (0..).zip(&self.sectors).filter(|(_, sector)| sector.state == state);
        those.min_by_key(|(_, sector)| sector.sequence).map(|(number, _)| number)
    }

    /// Erases the next page of a sector.
    fn erase(&mut self, number: u8) -> Result<(), StorageError<F::Error>> {
        let last = self.sectors.iter().map(|sector| sector.sequence).max().unwrap_or(0);
        let base = Place { sector: number, granule: 0 }.address::<F>();
        let elsewhere = |place: &Place| place.sector != number;
        self.rotten = self.rotten.map(|rotten| rotten.filter(elsewhere));
        self.last_found = self.last_found.filter(elsewhere);
        let Some(sector) = self.sectors.get_mut(usize::from(number)) else { return Ok(()) };
        let erased = sector.erase_page(&mut self.flash, base, last.saturating_add(1));
        erased.or_else(|e| self.failed(e))
    }

    /// Copies records that count and have no later copy.
    #[inline(never)]
    fn evacuate(&mut self, from: u8) -> Result<(), StorageError<F::Error>> {
        if let Some(sector) = self.sectors.get_mut(usize::from(from)) {
            sector.free = granules_of::<F>();
        }
        // A record that turns out to have rotted brings the one before it back into the index, which is then copied.
        for _ in 0..2 * KEPT {
            if self.copy_models(from)? && self.copy_newest(from)? {
                break;
            }
        }
        self.rewrite_singles(Some(from))?;
        // Parts come last: they are the longest, and the least loss.
        self.evacuate_parts(from)
    }

    /// Copies the models that are kept in a sector, which is about to be erased, to the end of the log; and with them
    /// the newest model that was found when the storage was opened. A power cut may have left a bit of it between 0 and
    /// 1, which will not read the same for ever. Returns true if all were whole.
    fn copy_models(&mut self, from: u8) -> Result<bool, StorageError<F::Error>> {
        for k in 0..KEPT {
            let goes = |slot: &Slot| slot.place.sector == from || Some(slot.place) == self.last_found;
            let Some(slot) = self.index.kept.get(k).copied().flatten().filter(goes) else { continue };
            let Some(place) = self.copy(slot.place)? else {
                self.forget_rotten(slot.place);
                return Ok(false);
            };
            self.last_found = self.last_found.filter(|last| *last != slot.place);
            if let Some(kept) = self.index.kept.get_mut(k) {
                *kept = Some(Slot { place, ..slot });
            }
        }
        Ok(true)
    }

    /// Forgets a record that was whole when the storage was opened and is not any more: the record before it counts
    /// again.
    #[inline(never)]
    pub(super) fn forget_rotten(&mut self, place: Place) {
        self.index.counts.damaged = self.index.counts.damaged.saturating_add(1);
        if let Some(free) = self.rotten.iter_mut().find(|rotten| rotten.is_none()) {
            *free = Some(place);
        }
        self.look_again();
        for slot in &mut self.index.kept {
            slot.take_if(|slot| slot.place == place);
        }
    }

    /// Reads all sectors anew; counters stay.
    pub(super) fn look_again(&mut self) {
        let Index { counts, last_number, .. } = self.index;
        self.index = Index { counts, last_number, ..self.scan(None) };
    }

    /// Writes anew each value without two whole copies in one sector, not counting the sector to be erased.
    #[inline(never)]
    fn rewrite_singles(&mut self, before_erasing: Option<u8>) -> Result<(), StorageError<F::Error>> {
        if let Some(counter) = self.index.counter.unsettled(before_erasing) {
            self.write_single(Kind::COUNTER, counter, 0)?;
        }
        if let Some(retired) = self.index.retired.unsettled(before_erasing) {
            self.write_single(Kind::RETIREMENT, retired, 0)?;
        }
        Ok(())
    }

    /// Copies a record as it is, number and check included, so that a copy and its original are the same model.
    /// Returns `None` if it has rotted.
    #[inline(never)]
    pub(super) fn copy(&mut self, from: Place) -> Result<Option<Place>, StorageError<F::Error>> {
        let Some(granules) = self.read_record(from).map(|header| header.granules()) else { return Ok(None) };
        let to = room::take::<F>(&mut self.sectors, granules, 0, 0).ok_or(StorageError::Full)?;
        let bytes = self.buffer.get(..usize::from(granules) * GRANULE).unwrap_or_default();
        match program(&mut self.flash, to.address::<F>(), bytes) {
            Ok(()) => Ok(Some(to)),
            Err(e) => self.failed(e),
        }
    }

    /// Returns the latest sector that can be erased because all its records that count stand elsewhere, too.
    #[inline(never)]
    fn redundant(&mut self) -> Option<u8> {
        let (all, parts) = (self.scan(None), self.newest_parts(None).map(|(number, _)| number));
        let mut before = u32::MAX;
        for _ in 0..SECTORS {
            let used = (0..).zip(&self.sectors).filter(|(_, sector)| sector.state == State::Used);
            let latest = used.filter(|(_, sector)| sector.sequence < before).max_by_key(|(_, sector)| sector.sequence);
            let (number, sector) = latest?;
            before = sector.sequence;
            if self.scan(Some(number)).holds_all_of(&all)
                && self.newest_parts(Some(number)).map(|(number, _)| number) == parts
            {
                return Some(number);
            }
        }
        None
    }

    /// Erases a sector and gives up its models, which are counted. Only a flash that has lost its marks needs this.
    #[inline(never)]
    fn abandon(&mut self, number: u8) -> Result<(), StorageError<F::Error>> {
        self.erase(number)?;
        while self.sectors.get(usize::from(number)).is_some_and(|sector| sector.state == State::Unready) {
            self.erase(number)?;
        }
        for slot in &mut self.index.kept {
            if slot.take_if(|slot| slot.place.sector == number).is_some() {
                self.counts.abandoned = self.counts.abandoned.saturating_add(1);
            }
        }
        self.index.newest.abandon(number);
        self.rewrite_singles(Some(number))
    }
}
