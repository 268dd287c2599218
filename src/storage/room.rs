//! Room for the next record.

use super::{ModelStore, granules::Place, sector::State, sector_size::granules_of};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Returns the sector that is written to: the latest used one whose mark can be read.
    pub(super) fn active(&self) -> Option<u8> {
        let used = (0..).zip(&self.sectors).filter(|(_, sector)| sector.state == State::Used && sector.sequence > 0);
        used.max_by_key(|(_, sector)| sector.sequence).map(|(number, _)| number)
    }

    pub(super) fn ready(&self) -> usize {
        self.sectors.iter().filter(|sector| sector.state == State::Ready).count()
    }

    /// Takes room for a record. A ready sector is begun only while more than `reserve` are ready, and the last sector
    /// that may be begun is filled only up to `margin` granules before its end.
    #[inline(never)]
    pub(super) fn take_room(&mut self, granules: u16, reserve: usize, margin: u16) -> Option<Place> {
        let may_begin = self.ready() > reserve;
        let fits = |free: u16| free + granules + if may_begin { 0 } else { margin } <= granules_of::<F>();
        let active = self.active();
        let active = active.filter(|number| self.sectors.get(usize::from(*number)).is_some_and(|s| fits(s.free)));
        let number = match active {
            Some(number) => number,
            None if may_begin => {
                let ready = (0..).zip(&self.sectors).filter(|(_, sector)| sector.state == State::Ready);
                ready.min_by_key(|(_, sector)| sector.sequence)?.0
            }
            None => return None,
        };
        let sector = self.sectors.get_mut(usize::from(number))?;
        let place = Place { sector: number, granule: sector.free };
        sector.state = State::Used;
        sector.free += granules;
        Some(place)
    }
}
