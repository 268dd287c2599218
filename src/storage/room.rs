//! Room for the next record among the sectors of a store.

use super::{
    granules::Place,
    sector::{Sector, State},
    sector_size::granules_of,
};
use embedded_storage::nor_flash::NorFlash;

/// Returns the sector that is written to: the latest used one whose mark can be read.
pub(super) fn active(sectors: &[Sector]) -> Option<u8> {
    let used = (0..).zip(sectors).filter(|(_, sector)| sector.state == State::Used && sector.sequence > 0);
    used.max_by_key(|(_, sector)| sector.sequence).map(|(number, _)| number)
}

/// Returns the number of sectors that are erased and marked so.
pub(super) fn ready(sectors: &[Sector]) -> usize {
    sectors.iter().filter(|sector| sector.state == State::Ready).count()
}

/// Returns the used sector that was begun after one of this sequence and number, and its sequence.
pub(super) fn next_used(sectors: &[Sector], after: Option<(u32, u8)>) -> Option<(u8, u32)> {
    let used = (0..).zip(sectors).filter(|(_, sector)| sector.state == State::Used);
    let keys = used.map(|(number, sector)| (sector.sequence, number));
    keys.filter(|key| after.is_none_or(|after| *key > after)).min().map(|(sequence, number)| (number, sequence))
}

/// Takes room for a record. A ready sector is begun only while more than `reserve` are ready, and the last sector
/// that may be begun is filled only up to `margin` granules before its end.
#[inline(never)]
pub(super) fn take<F: NorFlash>(sectors: &mut [Sector], granules: u16, reserve: usize, margin: u16) -> Option<Place> {
    let may_begin = ready(sectors) > reserve;
    let fits = |free: u16| free + granules + if may_begin { 0 } else { margin } <= granules_of::<F>();
    let active = active(sectors);
    let active = active.filter(|number| sectors.get(usize::from(*number)).is_some_and(|s| fits(s.free)));
    let number = match active {
        Some(number) => number,
        None if may_begin => {
            let ready = (0..).zip(&*sectors).filter(|(_, sector)| sector.state == State::Ready);
            ready.min_by_key(|(_, sector)| sector.sequence)?.0
        }
        None => return None,
    };
    let sector = sectors.get_mut(usize::from(number))?;
    let place = Place { sector: number, granule: sector.free };
    sector.state = State::Used;
    sector.free += granules;
    Some(place)
}
