//! Factory's records: calibrations, identity and mounting, and the key of authenticated commands. The factory writes
//! them once, in a region apart from the probe's own records (`provisioning`).

use super::{
    StorageError,
    granules::walk,
    little_endian::{Reader, Writer},
    record::{GRANULE, Kind, MAX_RECORD},
};
use crate::{
    compensation::{GyroModel, VectorModel},
    config::SurveyConfig,
};
use embedded_storage::nor_flash::ReadNorFlash;

/// Granules of the region that are searched: room for all records and for several cut off by a loss of power.
pub(super) const GRANULES: u16 = 64;

/// Bytes of a key.
pub const KEY_BYTES: usize = 32;

/// Fewest different byte values in a key. 32 random bytes have fewer once in 10^24 times (256 choose 11, times (11 /
/// 256)^32); unwritten memory, a counter or a repeated word has fewer.
const LEAST_DIFFERENT: u32 = 12;

/// Returns true if bytes can be a key that was drawn at random.
#[must_use]
pub fn can_be_key(bytes: &[u8; KEY_BYTES]) -> bool {
    different_values(bytes) >= LEAST_DIFFERENT
}

// Once in the program.
#[inline(never)]
fn different_values(bytes: &[u8]) -> u32 {
    let (mut seen, mut count) = ([0_u32; 8], 0);
    for byte in bytes {
        let Some(seen) = seen.get_mut(usize::from(byte >> 5)) else { continue };
        count += u32::from(*seen & (1 << (byte & 31)) == 0);
        *seen |= 1 << (byte & 31);
    }
    count
}

/// Factory's calibration of a probe's sensors, and its identity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FactoryCalibration {
    /// Gyro model: flown until a better one is accepted, and the centre of the prior.
    pub gyro: GyroModel,
    /// Accelerometer.
    pub accel: VectorModel,
    /// Magnetometer.
    pub mag: VectorModel,
    /// Serial number of the probe.
    pub serial_number: u32,
}

/// Mounting of the probe in its housing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mounting {
    /// Added to every toolface, rad, within a whole turn: from the probe's x axis to the mark of the housing.
    pub toolface_offset_rad: f32,
}

impl Mounting {
    /// Returns true if surveys can be taken with this toolface offset.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let survey = SurveyConfig { toolface_offset_rad: self.toolface_offset_rad, ..SurveyConfig::default() };
        survey.validate().is_ok()
    }
}

/// Key of authenticated commands as it is written. It is never printed.
#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FactoryKey(pub [u8; KEY_BYTES]);

impl core::fmt::Debug for FactoryKey {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("FactoryKey")
    }
}

#[cfg(all(feature = "defmt", target_os = "none"))]
impl defmt::Format for FactoryKey {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "FactoryKey");
    }
}

/// One record of the factory's region.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FactoryRecord {
    /// Calibrations and identity.
    Calibration(FactoryCalibration),
    /// Mounting of the probe in its housing.
    Mounting(Mounting),
    /// Key of authenticated commands, the last record: with it the region is closed.
    Key(FactoryKey),
}

/// Content of the factory's region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FactoryRecords {
    /// Calibration; `None` if none is whole and usable.
    pub calibration: Option<FactoryCalibration>,
    /// Mounting; `None` if none is whole and usable.
    pub mounting: Option<Mounting>,
    /// Key; `None` if none was provisioned, and then commands that need one are refused.
    pub key: Option<[u8; KEY_BYTES]>,
    /// Places where a record was cut off or has rotted.
    pub damaged: u32,
    /// Whole records that this firmware does not know.
    pub unknown: u32,
    /// First granule that can still be written.
    pub(super) free: u16,
}

impl FactoryRecords {
    /// Reads the factory's region; this type cannot write it.
    ///
    /// # Errors
    /// Nothing of the region can be read, or it is too small.
    pub fn read<R: ReadNorFlash>(region: &mut R) -> Result<Self, StorageError<R::Error>> {
        if region.capacity() < usize::from(GRANULES) * GRANULE || !GRANULE.is_multiple_of(R::READ_SIZE) {
            return Err(StorageError::Geometry("of 2 KiB or more, read in words of 1 to 32 bytes"));
        }
        let mut records = Self::default();
        let mut buffer = [0; MAX_RECORD];
        let walked = walk(region, 0, (0, GRANULES), &mut buffer, &mut |header, payload, _| {
            // The first record of each kind counts: no later one can replace it.
            match (header.kind, header.version) {
                (Kind::FACTORY, 1) => records.calibration = records.calibration.or_else(|| calibration(payload)),
                (Kind::MOUNTING, 1) => records.mounting = records.mounting.or_else(|| mounting(payload)),
                (Kind::KEY, 1) => records.key = records.key.or_else(|| Reader(payload).bytes()),
                _ => records.unknown = records.unknown.saturating_add(1),
            }
        });
        if let Some(e) = walked.silent {
            return Err(StorageError::Flash(e));
        }
        (records.damaged, records.free) = (walked.damaged, walked.free);
        Ok(records)
    }

    /// Returns the region's record of the same kind as `record`.
    #[must_use]
    pub fn of_kind(&self, record: &FactoryRecord) -> Option<FactoryRecord> {
        match record {
            FactoryRecord::Calibration(_) => self.calibration.map(FactoryRecord::Calibration),
            FactoryRecord::Mounting(_) => self.mounting.map(FactoryRecord::Mounting),
            FactoryRecord::Key(_) => self.key.map(|key| FactoryRecord::Key(FactoryKey(key))),
        }
    }
}

impl FactoryRecord {
    /// Kind of the record in flash.
    pub(super) const fn kind(&self) -> Kind {
        match self {
            Self::Calibration(_) => Kind::FACTORY,
            Self::Mounting(_) => Kind::MOUNTING,
            Self::Key(_) => Kind::KEY,
        }
    }

    /// Writes the record's payload.
    pub(super) fn lay_out(&self, writer: &mut Writer<'_>) {
        match self {
            Self::Calibration(factory) => {
                let matrices = [&factory.gyro.p, &factory.accel.matrix, &factory.mag.matrix];
                matrices.into_iter().flatten().for_each(|row| writer.f32s(row));
                let vectors = [&factory.gyro.b_rad_s, &factory.accel.offset, &factory.mag.offset];
                vectors.into_iter().for_each(|v| writer.f32s(v));
                writer.u32(factory.serial_number);
            }
            Self::Mounting(mounting) => writer.f32s(&[mounting.toolface_offset_rad]),
            Self::Key(key) => writer.bytes(&key.0),
        }
    }
}

fn calibration(payload: &[u8]) -> Option<FactoryCalibration> {
    let mut reader = Reader(payload);
    let mut matrix = || Some([reader.f32s()?, reader.f32s()?, reader.f32s()?]);
    let [gyro, accel, mag] = [matrix()?, matrix()?, matrix()?];
    let calibration = FactoryCalibration {
        gyro: GyroModel { p: gyro, b_rad_s: reader.f32s()? },
        accel: VectorModel { matrix: accel, offset: reader.f32s()? },
        mag: VectorModel { matrix: mag, offset: reader.f32s()? },
        serial_number: reader.u32()?,
    };
    calibration.is_valid().then_some(calibration)
}

fn mounting(payload: &[u8]) -> Option<Mounting> {
    let [toolface_offset_rad] = Reader(payload).f32s()?;
    Some(Mounting { toolface_offset_rad }).filter(Mounting::is_valid)
}

impl FactoryCalibration {
    /// Returns true if every number is finite and every matrix can be inverted.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.gyro.is_valid() && self.accel.is_valid() && self.mag.is_valid()
    }
}
