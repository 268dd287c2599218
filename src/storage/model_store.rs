//! Store of accepted models and the command counter in a ring of flash sectors. `mod.rs` explains its use, its
//! timing, and power cuts; erasing is in `preparation.rs`, choosing a model in `restoration.rs`.

use super::{
    Limits, StorageError, StoredModel,
    granules::{Place, read_record, walk},
    index::{Index, KEPT, ScanCounts},
    programming::Programming,
    record::{GRANULE, Header, Kind, MAX_RECORD, encode},
    room,
    sector::{Sector, State},
    sector_size::{granules_of, sector_bytes},
    stored_model,
    writing_learnt::WritingLearnt,
};
use embedded_storage::nor_flash::NorFlash;

/// Granules at the end of the room that models leave free for counters: two for each of sixteen commands.
pub(super) const FOR_COUNTERS: u16 = 32;

/// Accepted models and the command counter, in a ring of equal sectors.
///
/// `flash` is the ring alone: `SECTORS` sectors from address 0, three or more. A sector is one erase unit of the flash
/// or, where that is under 8 KiB, as many as make 16 KiB.
#[derive(Clone)]
pub struct ModelStore<F, const SECTORS: usize = 3> {
    pub(super) flash: F,
    pub(super) limits: Limits,
    pub(super) sectors: [Sector; SECTORS],
    pub(super) index: Index,
    /// Record that is being written, or has been read.
    pub(super) buffer: [u8; MAX_RECORD],
    writing: Option<Writing>,
    pub(super) writing_learnt: Option<WritingLearnt>,
    /// Number of the filter's parts that are complete and wait for their model.
    pub(super) learnt_number: Option<u32>,
    /// Last record before the free room when the storage was opened: the power may have been cut in it.
    pub(super) last_found: Option<Place>,
    /// Places of records that were whole and are not any more.
    pub(super) rotten: [Option<Place>; KEPT],
    pub(super) counts: StoreCounts,
}

/// Model, dose or command on its way into the flash.
#[derive(Clone, Copy)]
struct Writing {
    kind: Kind,
    temperature_c: Option<[f32; 2]>,
    number: u32,
    record: Programming,
}

/// Counters of written and refused records since the storage was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoreCounts {
    /// Models stored.
    pub stored: u32,
    /// Models, counters and retirements refused for want of room.
    pub refused_full: u32,
    /// States of the filter, refused because models need the room.
    pub learnt_refused: u32,
    /// Models refused because they are outside the limits for restoring.
    pub refused_implausible: u32,
    /// Writes and erasures that failed, or did not read back.
    pub failed: u32,
    /// Models given up because the flash had lost its marks and no room was left to copy them.
    pub abandoned: u32,
}

/// Progress of writing a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Progress {
    /// Nothing is being written.
    Idle,
    /// More is to be programmed.
    More,
    /// The model is stored, and was read back.
    Stored {
        /// Number of the model.
        number: u32,
    },
    /// The dose is stored, and was read back.
    DoseStored,
    /// A command is stored, and was read back.
    CommandStored,
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Reads the flash; writes nothing.
    ///
    /// # Errors
    /// The flash's geometry does not fit, or it cannot be read.
    #[inline(never)]
    pub fn open(flash: F, limits: Limits) -> Result<Self, StorageError<F::Error>> {
        let problem = if F::ERASE_SIZE > 1 << 20 || !F::ERASE_SIZE.is_multiple_of(GRANULE) || sector_bytes::<F>() == 0 {
            Some("of pages of 32 bytes to 1 MiB")
        } else if SECTORS < 3 || SECTORS > 250 || flash.capacity() < SECTORS * sector_bytes::<F>() {
            Some("of at least three sectors, each of 8 KiB or more, or of pages that make 16 KiB")
        } else if !GRANULE.is_multiple_of(F::WRITE_SIZE) || !GRANULE.is_multiple_of(F::READ_SIZE) {
            Some("of words of 1, 2, 4, 8, 16 or 32 bytes")
        } else {
            None
        };
        if let Some(problem) = problem {
            return Err(StorageError::Geometry(problem));
        }
        let mut store = Self {
            flash,
            limits,
            sectors: [Sector::UNREADY; SECTORS],
            index: Index::empty(),
            buffer: [0; MAX_RECORD],
            writing: None,
            writing_learnt: None,
            learnt_number: None,
            last_found: None,
            rotten: [None; KEPT],
            counts: StoreCounts::default(),
        };
        let damaged = store.read_sectors()?;
        store.index = store.scan(None);
        store.index.counts.damaged = damaged;
        // The scan may have read a record whole that was damage when its sector was read.
        let ends = |(place, end): &(Place, u16)| {
            store.sectors.get(usize::from(place.sector)).is_some_and(|sector| sector.free == *end)
        };
        store.last_found = store.index.last.filter(ends).map(|(place, _)| place).or(store.last_found);
        Ok(store)
    }

    /// Takes the limits of another configuration and reads all sectors anew with them, if they allow other models.
    /// Models of the configuration before are not restored then, but they stay. A record that is being written is given
    /// up: it comes from the configuration before.
    #[inline(never)]
    pub fn set_limits(&mut self, limits: &Limits) {
        if self.limits.are(limits) {
            return;
        }
        (self.writing, self.writing_learnt, self.learnt_number) = (None, None, None);
        self.limits = *limits;
        self.look_again();
    }

    /// Reads the states of the sectors. Returns the number of damaged places in them. Fails if nothing at all can be
    /// read: a flash that does not answer must not count as empty and be erased.
    #[inline(never)]
    fn read_sectors(&mut self) -> Result<u32, StorageError<F::Error>> {
        let (mut damaged, mut newest) = (0_u32, 0);
        let (mut is_read, mut silent) = (false, None);
        for (number, sector) in (0..).zip(&mut self.sectors) {
            let found = Sector::read(&mut self.flash, number, &mut self.buffer);
            *sector = found.sector;
            damaged = damaged.saturating_add(found.damaged);
            match found.silent {
                None => is_read = true,
                Some(e) => silent = Some(e),
            }
            if sector.state == State::Used && sector.sequence > newest {
                newest = sector.sequence;
                self.last_found = found.last.or(self.last_found);
            }
        }
        match silent {
            Some(e) if !is_read => Err(StorageError::Flash(e)),
            _ => Ok(damaged),
        }
    }

    /// Builds the index of all sectors but one.
    #[inline(never)]
    pub(super) fn scan(&mut self, but: Option<u8>) -> Index {
        let (mut index, limits, rotten) = (Index::empty(), self.limits, self.rotten);
        self.each_record(but, &mut |header, payload, place| {
            if !rotten.contains(&Some(place)) {
                index.note(header, payload, place, &limits);
            }
        });
        index.retire();
        index
    }

    /// Visits every whole record of all sectors but one, in the order in which the sectors were begun, so that the
    /// latest copy comes last.
    #[inline(never)]
    pub(super) fn each_record(&mut self, but: Option<u8>, each: &mut dyn FnMut(&Header, &[u8], Place)) {
        let mut after = None;
        while let Some((number, sequence)) = room::next_used(&self.sectors, after) {
            after = Some((sequence, number));
            if Some(number) == but {
                continue;
            }
            let base = Place { sector: number, granule: 0 }.address::<F>();
            let extent = (1, granules_of::<F>());
            walk(&mut self.flash, base, extent, &mut self.buffer, &mut |header, payload, granule| {
                each(header, payload, Place { sector: number, granule });
            });
        }
    }

    /// Begins to store a model; [`ModelStore::step`] programs it piece by piece.
    ///
    /// # Errors
    /// Nothing is written: the model would not be restored, there is no room (both counted), or another one is being
    /// written.
    #[inline(never)]
    pub fn begin_model(&mut self, model: &StoredModel) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        if let Err(reason) = self.limits.check(model) {
            self.counts.refused_implausible = self.counts.refused_implausible.saturating_add(1);
            return Err(StorageError::Implausible(reason));
        }
        // The model takes the number of its waiting parts, which makes them count.
        let number = self.learnt_number.take().unwrap_or_else(|| self.index.last_number.saturating_add(1));
        let encoded = encode(&mut self.buffer, Kind::MODEL, stored_model::VERSION, number, |w| model.encode(w));
        let placed = encoded
            .and_then(|granules| Some((granules, room::take::<F>(&mut self.sectors, granules, 1, FOR_COUNTERS)?)));
        let Some((granules, place)) = placed else { return self.refuse_full() };
        if number > self.index.last_number {
            self.index.last_number = number;
        }
        self.begin_writing(Kind::MODEL, number, place, granules);
        if let Some(writing) = &mut self.writing {
            writing.temperature_c = model.temperature_c;
        }
        Ok(())
    }

    /// Has [`ModelStore::step`] program the record in the buffer.
    pub(super) const fn begin_writing(&mut self, kind: Kind, number: u32, place: Place, granules: u16) {
        let record = Programming::new(place, granules);
        self.writing = Some(Writing { kind, temperature_c: None, number, record });
    }

    /// Programs the next 32 bytes of the model, dose or command that is being written; after the last of them reads it
    /// back.
    ///
    /// # Errors
    /// The flash failed or does not hold what was written (counted): it is not stored and can be begun again.
    #[inline(never)]
    pub fn step(&mut self) -> Result<Progress, StorageError<F::Error>> {
        let Some(mut writing) = self.writing.take() else { return Ok(Progress::Idle) };
        if !self.program_next(&mut writing.record)? {
            self.writing = Some(writing);
            return Ok(Progress::More);
        }
        if self.index.newest.note(writing.kind, writing.number, writing.record.place) {
            return Ok(if writing.kind == Kind::DOSE { Progress::DoseStored } else { Progress::CommandStored });
        }
        self.index.keep(writing.number, writing.record.place, writing.temperature_c, true);
        self.counts.stored = self.counts.stored.saturating_add(1);
        Ok(Progress::Stored { number: writing.number })
    }

    /// Stores a model at once, for use while nothing is sampled. Returns the model's number.
    ///
    /// # Errors
    /// As [`ModelStore::begin_model`] and [`ModelStore::step`].
    pub fn store_model(&mut self, model: &StoredModel) -> Result<u32, StorageError<F::Error>> {
        self.begin_model(model)?;
        loop {
            if let Progress::Stored { number } = self.step()? {
                return Ok(number);
            }
        }
    }

    /// Reads a record into the buffer; `None` if no whole record is there.
    pub(super) fn read_record(&mut self, place: Place) -> Option<Header> {
        read_record(&mut self.flash, place.address::<F>(), &mut self.buffer)
    }

    /// Programs the next 32 bytes of the buffered record. After the last of them reads it back, and returns `true`.
    pub(super) fn program_next(&mut self, record: &mut Programming) -> Result<bool, StorageError<F::Error>> {
        record.next(&mut self.flash, &self.buffer).or_else(|e| self.failed(e))
    }

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

    /// Writes a single value twice; see [`Rising`](super::single_values::Rising).
    pub(super) fn write_single(
        &mut self,
        kind: Kind,
        value: u64,
        reserve: usize,
    ) -> Result<(), StorageError<F::Error>> {
        let place = room::take::<F>(&mut self.sectors, 2, reserve, 0).ok_or(StorageError::Full)?;
        self.index.last_number = self.index.last_number.saturating_add(1);
        let single = if kind == Kind::COUNTER { &mut self.index.counter } else { &mut self.index.retired };
        let written = single.write(&mut self.flash, (kind, self.index.last_number), value, place);
        written.or_else(|e| self.failed(e))
    }

    pub(super) fn refuse_full<T>(&mut self) -> Result<T, StorageError<F::Error>> {
        self.counts.refused_full = self.counts.refused_full.saturating_add(1);
        Err(StorageError::Full)
    }

    pub(super) fn failed<T>(&mut self, error: StorageError<F::Error>) -> Result<T, StorageError<F::Error>> {
        self.counts.failed = self.counts.failed.saturating_add(1);
        Err(error)
    }

    /// Returns true if a model, a dose, a command or the filter's state is being written.
    #[must_use]
    pub const fn is_writing(&self) -> bool {
        self.writing.is_some() || self.writing_learnt.is_some()
    }

    /// Returns the findings when the storage was opened.
    #[must_use]
    pub const fn scan_counts(&self) -> ScanCounts {
        self.index.counts
    }

    /// Returns the counters since the storage was opened.
    #[must_use]
    pub const fn counts(&self) -> StoreCounts {
        self.counts
    }

    /// Returns how often each sector, with all its pages, was erased, without erasures counted in a mark that cannot be
    /// read.
    #[must_use]
    pub fn erases(&self) -> [u32; SECTORS] {
        self.sectors.map(|sector| sector.erases)
    }

    /// Returns the flash's driver, to be used for anything but reading or writing; its content must not change.
    pub const fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Returns the flash.
    pub fn into_flash(self) -> F {
        self.flash
    }
}
