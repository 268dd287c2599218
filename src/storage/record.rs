//! Layout of a record in flash: a header, its payload, and a check over both.

use super::little_endian::{Reader, Writer};
use crc::{Crc, NoTable};

/// Alignment of records, bytes: the largest word that a flash programs at a time (STM32H7: 256 bits), so that no word
/// is programmed twice and a torn record spoils none but itself.
pub(super) const GRANULE: usize = 32;

/// Longest record, bytes: a model with six effects of nine parameters takes 19 granules.
pub(super) const MAX_RECORD: usize = 20 * GRANULE;

const HEADER: usize = 16;
/// Length of the check, which stands first, so that the bytes it covers are one piece.
const CHECK: usize = 4;
/// Magic number "MW".
const MAGIC: u16 = 0x574D;

/// CRC-32C (Castagnoli; RFC 3720, section 12.1), bit by bit: a table would be 1 KiB of flash, and without one the
/// longest record takes a fifth of a millisecond.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&crc::CRC_32_ISCSI);

/// Version of the stored commands' encoding. Raise it when the configuration's layout changes: the check of a record
/// holds for bytes of any layout.
pub(super) const COMMANDS: u8 = 1;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind(pub u8);

impl Kind {
    pub const MODEL: Self = Self(1);
    pub const COUNTER: Self = Self(2);
    /// Retirement: models up to the number in it are not flown again.
    pub const RETIREMENT: Self = Self(3);
    /// Mark: the first granule of a sector.
    pub const MARK: Self = Self(4);
    pub const FACTORY: Self = Self(5);
    pub const KEY: Self = Self(6);
    /// Part of the filter's state when the model of the same number was stored.
    pub const LEARNT: Self = Self(7);
    /// Mounting of the probe in its housing.
    pub const MOUNTING: Self = Self(8);
    /// Dose of vibration and shocks so far.
    pub const DOSE: Self = Self(9);
    /// Command that configures the pipeline and the surveys.
    pub const CONFIGURE: Self = Self(13);
    /// Command that configures the surveys alone.
    pub const CONFIGURE_SURVEY: Self = Self(14);
    /// Image of the program.
    #[cfg(feature = "image-slots")]
    pub const IMAGE: Self = Self(10);
    /// An image was started on trial.
    #[cfg(feature = "image-slots")]
    pub const TRIAL: Self = Self(11);
    /// An image runs well.
    #[cfg(feature = "image-slots")]
    pub const CONFIRMED: Self = Self(12);
}

/// Header of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub kind: Kind,
    /// Version of the payload's layout.
    pub version: u8,
    /// Number that rises from record to record; a copy keeps the original's.
    pub number: u32,
    /// Length of the payload, bytes.
    length: u16,
    check: u32,
}

impl Header {
    /// Parses a header; `None` for bytes that are no header.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let mut reader = Reader(bytes);
        let check = reader.u32()?;
        let (magic, kind, version) = (reader.u16()?, Kind(reader.u8()?), reader.u8()?);
        let header = Self { kind, version, number: reader.u32()?, length: reader.u16()?, check };
        (magic == MAGIC && header.bytes() <= MAX_RECORD).then_some(header)
    }

    /// Length of the whole record, in whole granules.
    pub fn bytes(&self) -> usize {
        (HEADER + usize::from(self.length)).next_multiple_of(GRANULE)
    }

    pub fn granules(&self) -> u16 {
        // The length is at most `MAX_RECORD` bytes, or parsing would have failed.
        (self.bytes() / GRANULE) as u16
    }

    /// Returns the payload of a whole record with this header; `None` if the check fails.
    pub fn payload<'a>(&self, record: &'a [u8]) -> Option<&'a [u8]> {
        let covered = record.get(CHECK..HEADER + usize::from(self.length))?;
        (check(covered) == self.check).then(|| covered.get(HEADER - CHECK..)).flatten()
    }
}

#[inline(never)]
fn check(covered: &[u8]) -> u32 {
    CRC.checksum(covered)
}

/// Lays a record out in `record` and returns its length in granules; `None` if it does not fit.
pub(super) fn encode(
    record: &mut [u8],
    kind: Kind,
    version: u8,
    number: u32,
    payload: impl FnOnce(&mut Writer<'_>),
) -> Option<u16> {
    record.fill(0xFF);
    let mut writer = Writer::new(record.get_mut(HEADER..)?);
    payload(&mut writer);
    let length = writer.finish()?;
    let mut writer = Writer::new(record.get_mut(CHECK..HEADER)?);
    writer.u16(MAGIC);
    writer.u8(kind.0);
    writer.u8(version);
    writer.u32(number);
    writer.u16(u16::try_from(length).ok()?);
    let sum = check(record.get(CHECK..HEADER + length)?);
    Writer::new(record).u32(sum);
    Some(Header::parse(record)?.granules())
}

#[cfg(test)]
mod tests;
