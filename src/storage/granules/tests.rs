//! Tests the walk over every small sector that blank, noisy, unreadable, whole and torn pieces can make.

use super::*;
use crate::storage::record::{Kind, encode};
use embedded_storage::nor_flash::{ErrorType, NorFlashErrorKind};

/// Granules before the sector, in it, and behind it.
const BEFORE: usize = 1;
const SECTOR: usize = if cfg!(miri) { 2 } else { 6 };
const BEHIND: usize = 1;
const ALL: usize = BEFORE + SECTOR + BEHIND;

/// Piece of a test sector.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    Blank,
    Noise,
    Unreadable,
    /// Whole record of this many granules.
    Whole(usize),
    /// First granule of a record of this many, the rest of which was never written.
    Torn(usize),
}

const PIECES: [Piece; 9] = [
    Piece::Blank,
    Piece::Noise,
    Piece::Unreadable,
    Piece::Whole(1),
    Piece::Whole(2),
    Piece::Whole(3),
    Piece::Torn(2),
    Piece::Torn(3),
    Piece::Torn(MAX_RECORD / GRANULE),
];

impl Piece {
    const fn granules(self) -> usize {
        match self {
            Self::Whole(granules) => granules,
            _ => 1,
        }
    }
}

/// Flash with the sector between two granules that must not be read.
struct Flash {
    bytes: [[u8; GRANULE]; ALL],
    readable: [bool; ALL],
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let (from, to) = (offset as usize, offset as usize + bytes.len());
        assert!(from >= BEFORE * GRANULE && to <= (BEFORE + SECTOR) * GRANULE, "{from} to {to}: not of the sector");
        if self.readable[from / GRANULE..to.div_ceil(GRANULE)].iter().any(|readable| !readable) {
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes.as_flattened()[from..to]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        ALL * GRANULE
    }
}

/// Lays the pieces out and walks over them.
fn check(pieces: &[Piece]) {
    let mut flash = Flash { bytes: [BLANK; ALL], readable: [true; ALL] };
    let (mut at, mut free, mut damaged, mut in_damage) = (0, 0, 0, false);
    let (mut whole, mut is_read) = (heapless::Vec::<(u16, usize), SECTOR>::new(), false);
    for piece in pieces {
        let granules = &mut flash.bytes[BEFORE + at..];
        let mut record = [0; MAX_RECORD];
        match *piece {
            Piece::Blank => {}
            Piece::Noise => granules[0] = [0x5A; GRANULE],
            Piece::Unreadable => flash.readable[BEFORE + at] = false,
            Piece::Whole(length) | Piece::Torn(length) => {
                let payload = [at as u8; MAX_RECORD];
                let payload = &payload[..length * GRANULE - 16];
                assert_eq!(encode(&mut record, Kind::LEARNT, 1, 1, |it| it.bytes(payload)), Some(length as u16));
                let written = granules.iter_mut().zip(record.as_chunks().0).take(piece.granules());
                written.for_each(|(granule, bytes)| *granule = *bytes);
            }
        }
        match piece {
            Piece::Blank => in_damage = false,
            Piece::Whole(_) => {
                whole.push((at as u16, piece.granules())).unwrap();
                in_damage = false;
            }
            _ => {
                damaged += u32::from(!in_damage);
                in_damage = true;
            }
        }
        is_read |= *piece != Piece::Unreadable;
        at += piece.granules();
        if *piece != Piece::Blank {
            free = at;
        }
    }
    let mut found = heapless::Vec::<(u16, usize), SECTOR>::new();
    let mut each = |header: &Header, payload: &[u8], granule: u16| {
        assert!(payload.iter().all(|byte| *byte == granule as u8), "its own payload");
        found.push((granule, header.granules().into())).unwrap();
    };
    let base = (BEFORE * GRANULE) as u32;
    let walked = walk(&mut flash, base, (0, SECTOR as u16), &mut [0; MAX_RECORD], &mut each);
    assert_eq!(found, whole, "{pieces:?}");
    assert_eq!((walked.free, walked.damaged), (free as u16, damaged), "{pieces:?}");
    assert_eq!(walked.silent.is_some(), !is_read, "{pieces:?}");
}

/// Checks all sectors that begin with these pieces. Returns their number.
fn each_sector(pieces: &mut heapless::Vec<Piece, SECTOR>) -> u32 {
    let used: usize = pieces.iter().map(|piece| piece.granules()).sum();
    if used == SECTOR {
        check(pieces);
        return 1;
    }
    let mut sectors = 0;
    for piece in PIECES {
        if used + piece.granules() <= SECTOR {
            pieces.push(piece).unwrap();
            sectors += each_sector(pieces);
            pieces.pop();
        }
    }
    sectors
}

#[test]
fn a_walk_finds_every_whole_record_and_nothing_else_and_stays_within_its_sector() {
    let sectors = each_sector(&mut heapless::Vec::new());
    // Number s(n) of sectors of n granules: s(n) = 7 s(n - 1) + s(n - 2) + s(n - 3).
    assert_eq!(sectors, if cfg!(miri) { 50 } else { 131_364 });
}
