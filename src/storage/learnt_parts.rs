//! State of the estimator's filter, stored in parts beside a model. The parts are written before the model, whose
//! record makes them count; parts without their model, or with one missing, are ignored.

use super::{
    ModelStore, StorageError,
    granules::Place,
    index::KEPT,
    little_endian::{Reader, Writer},
    programming::Programming,
    record::{GRANULE, Header, Kind, MAX_RECORD, encode},
    room,
    sector_size::granules_of,
    writing_learnt::WritingLearnt,
};
use crate::estimator::{Learnt, LearntHead, NUMBERS};
use embedded_storage::nor_flash::NorFlash;

/// Version of the layout of these parts.
pub(super) const VERSION: u8 = 1;
/// Numbers of the state in one part: 608 bytes, which with both headers is no more than the longest record.
const IN_A_PART: usize = 152;
/// Number of parts.
pub(super) const PARTS: usize = NUMBERS.div_ceil(IN_A_PART);
/// Largest number of granules of all parts.
pub(super) const GRANULES: u16 = (PARTS * MAX_RECORD / GRANULE) as u16;

/// Places of the parts.
type Places = [Place; PARTS];

/// Progress of writing the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum LearntProgress {
    /// Nothing is being written.
    Idle,
    /// The filter is being updated and nothing was written; [`Probe::poll`](crate::Probe::poll) finishes the update.
    Waiting,
    /// More is to be programmed; do not call `Probe::poll`, so that the filter stays as it is.
    More,
    /// All parts are there, and [`ModelStore::begin_model`] makes them count.
    Whole,
}

fn encode_part(writer: &mut Writer<'_>, learnt: &Learnt<'_>, part: u8) {
    writer.u8(part);
    writer.u8(PARTS as u8);
    writer.u16(NUMBERS as u16);
    writer.u32(learnt.head.fingerprint);
    writer.u32(learnt.head.update);
    let first = usize::from(part) * IN_A_PART;
    writer.f32s(&[learnt.head.motion_s]);
    (first..NUMBERS).take(IN_A_PART).for_each(|k| writer.f32s(&[learnt.number(k)]));
}

/// Returns a part's number and content; `None` for bytes that [`encode_part`] does not write.
fn decode_head(reader: &mut Reader<'_>) -> Option<(usize, LearntHead)> {
    let (part, parts, numbers) = (usize::from(reader.u8()?), usize::from(reader.u8()?), usize::from(reader.u16()?));
    let head = LearntHead { fingerprint: reader.u32()?, update: reader.u32()?, motion_s: reader.f32()? };
    (part < PARTS && parts == PARTS && numbers == NUMBERS).then_some((part, head))
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Begins to store the filter's state for the model that is stored next; [`ModelStore::step_learnt`] programs it
    /// piece by piece.
    ///
    /// # Errors
    /// `Busy`: a record is being written. `Full` (counted): no room, which is always so in sectors under 16 KiB; the
    /// model can then be begun at once, without the state. Nothing is written.
    pub fn begin_learnt(&mut self) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        if !self.has_room_for_parts() {
            self.counts.learnt_refused = self.counts.learnt_refused.saturating_add(1);
            return Err(StorageError::Full);
        }
        let number = self.index.last_number.saturating_add(1);
        self.index.last_number = number;
        self.writing_learnt = Some(WritingLearnt { number, update: None, part: 0, record: Programming::NOTHING });
        self.learnt_number = None;
        Ok(())
    }

    /// Programs the next 32 bytes of the filter's state, which is `None` while it is updated.
    ///
    /// # Errors
    /// The state is not stored, and the model will stand without it: the filter was updated meanwhile, no room is left,
    /// or the flash failed (counted).
    #[inline(never)]
    pub fn step_learnt(&mut self, learnt: Option<Learnt<'_>>) -> Result<LearntProgress, StorageError<F::Error>> {
        let Some(mut writing) = self.writing_learnt.take() else { return Ok(LearntProgress::Idle) };
        if writing.record.is_done() {
            let Some(learnt) = learnt else {
                if writing.update.is_some() {
                    return Err(StorageError::FilterWentOn);
                }
                self.writing_learnt = Some(writing);
                return Ok(LearntProgress::Waiting);
            };
            if *writing.update.get_or_insert(learnt.head.update) != learnt.head.update {
                return Err(StorageError::FilterWentOn);
            }
            let part = writing.part;
            let encoded =
                encode(&mut self.buffer, Kind::LEARNT, VERSION, writing.number, |w| encode_part(w, &learnt, part));
            let margin = half_of::<F>();
            let placed =
                encoded.and_then(|granules| Some((granules, room::take::<F>(&mut self.sectors, granules, 1, margin)?)));
            let Some((granules, place)) = placed else { return self.refuse_full() };
            writing.record = Programming::new(place, granules);
        }
        if self.program_next(&mut writing.record)? {
            writing.part += 1;
            if usize::from(writing.part) == PARTS {
                self.learnt_number = Some(writing.number);
                return Ok(LearntProgress::Whole);
            }
        }
        self.writing_learnt = Some(writing);
        Ok(LearntProgress::More)
    }

    /// Returns true if the filter's numbers are being written, so that it has to stay as it is: do not call
    /// [`Probe::poll`](crate::Probe::poll) meanwhile. Samples are pushed as ever.
    #[must_use]
    pub fn holds_filter(&self) -> bool {
        self.writing_learnt.is_some_and(|writing| writing.update.is_some())
    }

    /// Returns true if the filter's state is to be written, or is being written.
    #[must_use]
    pub const fn is_writing_learnt(&self) -> bool {
        self.writing_learnt.is_some()
    }

    /// Returns the head of the numbers stored with a model; `None` if there are none, or not all of them.
    ///
    /// # Errors
    /// Something is being written.
    pub fn learnt_with(&mut self, number: u32) -> Result<Option<LearntHead>, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        Ok(self.parts_of(number, None).map(|(head, _)| head))
    }

    /// Hands out all numbers stored with a model, each with its place in their order. Returns true if all were there.
    ///
    /// # Errors
    /// Something is being written.
    pub fn read_learnt(
        &mut self,
        number: u32,
        take: &mut dyn FnMut(usize, f32),
    ) -> Result<bool, StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let Some((head, places)) = self.parts_of(number, None) else { return Ok(false) };
        for (part, place) in places.into_iter().enumerate() {
            let header = self.read_record(place);
            let Some(payload) = header.and_then(|header| header.payload(&self.buffer)) else { return Ok(false) };
            let mut reader = Reader(payload);
            if decode_head(&mut reader) != Some((part, head)) {
                return Ok(false);
            }
            for k in (part * IN_A_PART..NUMBERS).take(IN_A_PART) {
                let Some(x) = reader.f32() else { return Ok(false) };
                take(k, x);
            }
        }
        Ok(true)
    }

    /// Finds the places of a model's parts, the latest copy of each, in all sectors but one; `None` if any is
    /// missing.
    #[inline(never)]
    fn parts_of(&mut self, number: u32, but: Option<u8>) -> Option<(LearntHead, Places)> {
        let mut found: [Option<(Place, LearntHead)>; PARTS] = [None; PARTS];
        self.each_record(but, &mut |header: &Header, payload, place| {
            if header.kind != Kind::LEARNT || header.version != VERSION || header.number != number {
                return;
            }
            let Some((part, head)) = decode_head(&mut Reader(payload)) else { return };
            if let Some(slot) = found.get_mut(part) {
                *slot = Some((place, head));
            }
        });
        let (_, head) = found.first().copied().flatten()?;
        let mut places = [Place { sector: 0, granule: 0 }; PARTS];
        for (slot, found) in places.iter_mut().zip(found) {
            *slot = found.filter(|(_, other)| *other == head)?.0;
        }
        Some((head, places))
    }

    /// Finds the newest kept model with all its parts, and their places; those that may fly come first.
    #[inline(never)]
    pub(super) fn newest_parts(&mut self, but: Option<u8>) -> Option<(u32, Places)> {
        let mut below = (true, u32::MAX);
        for _ in 0..KEPT {
            let ranks = self.index.kept.iter().flatten().map(|slot| (slot.may_fly, slot.number));
            below = ranks.filter(|rank| *rank < below).max()?;
            if let Some((_, places)) = self.parts_of(below.1, but) {
                return Some((below.1, places));
            }
        }
        None
    }

    /// Copies those parts of the newest complete model that are in this sector.
    #[inline(never)]
    pub(super) fn evacuate_parts(&mut self, from: u8) -> Result<(), StorageError<F::Error>> {
        let Some((_, places)) = self.newest_parts(None) else { return Ok(()) };
        for place in places.into_iter().filter(|place| place.sector == from) {
            if self.copy(place)?.is_none() {
                self.index.counts.damaged = self.index.counts.damaged.saturating_add(1);
            }
        }
        Ok(())
    }

    /// Returns true if all parts fit into room that models do not need: a sector can be begun while drilling, or half
    /// of the last one stays free.
    fn has_room_for_parts(&self) -> bool {
        let kept = KEPT as u16 * (MAX_RECORD / GRANULE) as u16;
        // A sector has to take all that counts: models, parts, the mark and single values.
        if GRANULES + kept + 8 > granules_of::<F>() {
            return false;
        }
        let active = room::active(&self.sectors).and_then(|number| self.sectors.get(usize::from(number)));
        room::ready(&self.sectors) > 1
            || active.is_some_and(|active| active.free + GRANULES + half_of::<F>() <= granules_of::<F>())
    }
}

/// Room that parts leave to models in the last sector.
const fn half_of<F: NorFlash>() -> u16 {
    granules_of::<F>() / 2
}
