//! State of a sector and its mark. The mark is written after an erasure, because a sector that merely reads blank may
//! have been erased in part.

use super::{
    StorageError,
    granules::{Place, is_blank, program, read_record, walk},
    little_endian::Reader,
    record::{GRANULE, Kind, MAX_RECORD, encode},
    sector_size::{granules_of, sector_bytes},
};
use embedded_storage::nor_flash::NorFlash;

/// State of a sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// The sector has to be erased before use: an erasure was cut off, or the flash has never been used.
    Unready,
    /// The sector is erased, and marked as erased to the end.
    Ready,
    /// The sector holds records.
    Used,
    /// The sector did not read blank after an erasure, or did not take its mark.
    Bad,
}

/// Facts known of a sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sector {
    pub state: State,
    /// Sequence number that rises from erasure to erasure; 0 if the mark cannot be read.
    pub sequence: u32,
    /// Number of erasures, from the mark.
    pub erases: u32,
    /// First granule of the blank ones at the sector's end.
    pub free: u16,
    /// Pages erased so far of an erasure under way.
    pub pages: u16,
}

/// Findings in a sector when the storage is opened.
pub(super) struct Found<E> {
    pub sector: Sector,
    /// Last record, if free room follows it.
    pub last: Option<Place>,
    /// Number of damaged places.
    pub damaged: u32,
    /// Error if nothing at all could be read.
    pub silent: Option<E>,
}

impl Sector {
    pub const UNREADY: Self = Self { state: State::Unready, sequence: 0, erases: 0, free: 0, pages: 0 };

    /// Reads the mark at the sector's beginning: sequence number and erasures, or zeros. A sector that merely reads
    /// blank is not ready: an erasure that was cut off can leave bits that read as erased and do not last.
    pub fn read_mark<F: NorFlash>(flash: &mut F, base: u32, buffer: &mut [u8; MAX_RECORD]) -> (u32, u32) {
        let mark = read_record(flash, base, buffer).filter(|header| header.kind == Kind::MARK);
        let erases = mark.and_then(|header| Reader(header.payload(buffer)?).u32());
        mark.zip(erases).map_or((0, 0), |(header, erases)| (header.number, erases))
    }

    /// Reads a sector's state from its mark and its records.
    pub fn read<F: NorFlash>(flash: &mut F, number: u8, buffer: &mut [u8; MAX_RECORD]) -> Found<F::Error> {
        let base = Place { sector: number, granule: 0 }.address::<F>();
        let (sequence, erases) = Self::read_mark(flash, base, buffer);
        let mut last = None;
        let walked = walk(flash, base, (1, granules_of::<F>()), buffer, &mut |header, _, granule| {
            last = Some((granule, granule + header.granules()));
        });
        let state = match (sequence, last) {
            (1.., None) if walked.free == 1 => State::Ready,
            (_, Some(_)) => State::Used,
            // No record was ever completed in this sector.
            _ => State::Unready,
        };
        let ends_it = last.filter(|(_, end)| *end == walked.free);
        Found {
            sector: Self { state, sequence, erases, free: walked.free, pages: 0 },
            last: ends_it.map(|(granule, _)| Place { sector: number, granule }),
            damaged: walked.damaged,
            silent: walked.silent,
        }
    }

    /// Erases the sector's next page. After the last page marks the sector, or sets it to `Bad` if it is not blank.
    pub fn erase_page<F: NorFlash>(
        &mut self,
        flash: &mut F,
        base: u32,
        sequence: u32,
    ) -> Result<(), StorageError<F::Error>> {
        let granules = granules_of::<F>();
        let pages = if self.state == State::Unready { self.pages } else { 0 };
        *self = Self { state: State::Unready, sequence: 0, free: granules, pages, ..*self };
        let page = base + u32::from(pages) * F::ERASE_SIZE as u32;
        flash.erase(page, page + F::ERASE_SIZE as u32).map_err(StorageError::Flash)?;
        self.pages += 1;
        if usize::from(self.pages) * F::ERASE_SIZE < sector_bytes::<F>() {
            return Ok(());
        }
        self.pages = 0;
        self.erases = self.erases.saturating_add(1);
        self.state = State::Bad;
        if !is_blank(flash, base, granules) {
            return Ok(());
        }
        let mut mark = [0; GRANULE];
        let erases = self.erases;
        encode(&mut mark, Kind::MARK, 1, sequence, |writer| writer.u32(erases));
        program(flash, base, &mark)?;
        *self = Self { state: State::Ready, sequence, erases, free: 1, pages: 0 };
        Ok(())
    }
}
