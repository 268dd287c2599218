//! Single values: the command counter and the retirement of models. Each is written twice, so that one copy can rot.

use super::{
    StorageError,
    granules::{Place, program},
    record::{GRANULE, Kind, encode},
};
use embedded_storage::nor_flash::NorFlash;

/// Single value in one sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Single {
    value: u64,
    sector: u8,
    copies: u8,
}

/// Value that only rises, and is written twice.
///
/// A single copy may come from a write that was cut off: it reads whole, but a bit of it may not last. It counts, and
/// the last value with two whole copies is kept until the new value has been written again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rising {
    latest: Option<Single>,
    settled: Option<Single>,
    /// Copy that was noted last.
    noted: Option<Single>,
}

impl Rising {
    pub const NONE: Self = Self { latest: None, settled: None, noted: None };

    /// Notes a whole copy of a value; for equal values the sector noted last counts.
    pub fn note(&mut self, value: u64, sector: u8) {
        let before = self.noted.filter(|noted| (noted.value, noted.sector) == (value, sector));
        let copies = before.map_or(1, |noted| noted.copies.saturating_add(1));
        let single = Single { value, sector, copies };
        self.noted = Some(single);
        let is_latest = |old: &Option<Single>| old.is_none_or(|old| value >= old.value);
        if is_latest(&self.latest) {
            self.latest = Some(single);
        }
        if copies > 1 && is_latest(&self.settled) {
            self.settled = Some(single);
        }
    }

    /// Returns the highest value with a whole copy.
    pub const fn value(&self) -> Option<u64> {
        match self.latest {
            Some(latest) => Some(latest.value),
            None => None,
        }
    }

    /// Returns the value to be written again before anything is erased or, with a sector, before that sector is erased;
    /// `None` if two copies of it stay.
    pub fn unsettled(&self, before_erasing: Option<u8>) -> Option<u64> {
        let latest = self.latest?;
        let settled = self.settled.filter(|settled| settled.value == latest.value);
        let stays = settled.is_some_and(|settled| Some(settled.sector) != before_erasing);
        (!stays).then_some(latest.value)
    }

    /// Returns true if the latest and the settled values are the same in both.
    pub fn says_the_same_as(&self, other: &Self) -> bool {
        let value = |single: Option<Single>| single.map(|single| single.value);
        value(self.latest) == value(other.latest) && value(self.settled) == value(other.settled)
    }

    /// Writes a value twice in a row, and counts each copy that is whole. One copy of two is an error; it is found at
    /// the next power-up, so it counts from now on.
    pub fn write<F: NorFlash>(
        &mut self,
        flash: &mut F,
        (kind, number): (Kind, u32),
        value: u64,
        place: Place,
    ) -> Result<(), StorageError<F::Error>> {
        let mut record = [0; GRANULE];
        encode(&mut record, kind, 1, number, |writer| writer.u64(value));
        let first = program(flash, place.address::<F>(), &record);
        let second = program(flash, place.address::<F>() + GRANULE as u32, &record);
        for _ in [&first, &second].into_iter().filter(|written| written.is_ok()) {
            self.note(value, place.sector);
        }
        first.and(second)
    }
}

#[cfg(test)]
mod tests;
