//! Numbers and places of the records of which only the newest of its kind counts.

use super::{granules::Place, record::Kind};

/// Kinds of such records.
pub(super) const KINDS: [Kind; 3] = [Kind::DOSE, Kind::CONFIGURE, Kind::CONFIGURE_SURVEY];

/// Number and place of the newest record of each kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Newest([Option<(u32, Place)>; KINDS.len()]);

impl Newest {
    pub const NONE: Self = Self([None; KINDS.len()]);

    pub fn of(&self, kind: Kind) -> Option<(u32, Place)> {
        KINDS.iter().zip(&self.0).find_map(|(own, newest)| newest.filter(|_| *own == kind))
    }

    /// Notes a record, unless a newer one is known; the last of equal numbers is a later copy. Returns false for any
    /// other kind.
    pub fn note(&mut self, kind: Kind, number: u32, place: Place) -> bool {
        let Some((_, newest)) = KINDS.iter().zip(&mut self.0).find(|(own, _)| **own == kind) else { return false };
        if newest.is_none_or(|(known, _)| known <= number) {
            *newest = Some((number, place));
        }
        true
    }

    /// Returns true if the newest of each kind has the same number in both.
    pub fn are_those_of(&self, other: &Self) -> bool {
        let number = |newest: &Option<(u32, Place)>| newest.map(|(number, _)| number);
        self.0.iter().map(number).eq(other.0.iter().map(number))
    }

    /// Forgets those in a sector.
    pub fn abandon(&mut self, sector: u8) {
        for newest in &mut self.0 {
            newest.take_if(|(_, place)| place.sector == sector);
        }
    }
}
