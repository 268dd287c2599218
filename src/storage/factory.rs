//! Factory's records: calibrations and the key of authenticated commands. The factory writes them once, in a region
//! apart from the probe's own records, which a flying firmware cannot write.

use super::{
    StorageError,
    granules::{program, walk},
    little_endian::{Reader, Writer},
    record::{GRANULE, Kind, MAX_RECORD, encode},
};
use crate::compensation::{GyroModel, VectorModel};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

/// Part of the region that is searched: room for both records and for several that were cut off.
const GRANULES: u16 = 64;

/// Bytes of a key.
pub const KEY_BYTES: usize = 32;

/// Fewest different bytes in a key. Of 32 bytes that are drawn at random fewer differ once in 10^24 times (256 choose
/// 11, times (11 / 256)^32); memory that nobody wrote, a counter or a repeated word has fewer.
const LEAST_DIFFERENT: usize = 12;

/// Returns true if bytes can be a key that was drawn at random.
#[must_use]
pub fn can_be_key(bytes: &[u8; KEY_BYTES]) -> bool {
    let firsts = bytes.iter().enumerate().filter(|(k, byte)| !bytes.iter().take(*k).any(|before| before == *byte));
    firsts.count() >= LEAST_DIFFERENT
}

/// Factory's calibration of a probe's sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// Content of the factory's region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FactoryRecords {
    /// Calibration; `None` if none is whole and usable.
    pub calibration: Option<FactoryCalibration>,
    /// Key; `None` if none was provisioned, and then no command that needs one is believed.
    pub key: Option<[u8; KEY_BYTES]>,
    /// Places where a record was cut off or has rotted.
    pub damaged: u32,
    /// Whole records that this firmware does not know.
    pub unknown: u32,
    /// First granule that can still be written.
    free: u16,
}

impl FactoryRecords {
    /// Reads the region, which this type cannot write.
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

impl FactoryCalibration {
    /// Returns true if every number is finite and every matrix can be inverted.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.gyro.is_valid() && self.accel.is_valid() && self.mag.is_valid()
    }
}

/// Writer of the factory's region, the only one; a firmware that flies has no use for it. It never overwrites and
/// never erases. Afterwards the chip itself has to protect the sector (STM32F4: option bytes, nWRP).
pub struct Provisioning<F> {
    region: F,
}

impl<F: NorFlash> Provisioning<F> {
    /// Takes a region; nothing is read or written yet.
    pub const fn new(region: F) -> Self {
        Self { region }
    }

    /// Writes the calibration.
    ///
    /// There is a calibration already, this one cannot be used, or the flash failed: then it can be tried again.
    /// There is one already, it cannot be used, or the flash failed: then it can be tried again.
    pub fn write_calibration(&mut self, factory: &FactoryCalibration) -> Result<(), StorageError<F::Error>> {
        if !factory.is_valid() {
            return Err(StorageError::Implausible(super::Implausible::NotAModel));
        }
        let records = FactoryRecords::read(&mut self.region)?;
        self.write(&records, records.calibration.is_some(), Kind::FACTORY, |writer| {
            let matrices = [&factory.gyro.p, &factory.accel.matrix, &factory.mag.matrix];
            matrices.into_iter().flatten().for_each(|row| writer.f32s(row));
            [&factory.gyro.b_rad_s, &factory.accel.offset, &factory.mag.offset]
                .into_iter()
                .for_each(|v| writer.f32s(v));
            writer.u32(factory.serial_number);
        })
    }

    /// Writes the key of authenticated commands.
    ///
    /// # Errors
    /// There is a key already, nobody drew these bytes at random, or the flash failed: then it can be tried again.
    pub fn write_key(&mut self, key: &[u8; KEY_BYTES]) -> Result<(), StorageError<F::Error>> {
        if !can_be_key(key) {
            return Err(StorageError::WeakKey);
        }
        let records = FactoryRecords::read(&mut self.region)?;
        self.write(&records, records.key.is_some(), Kind::KEY, |writer| writer.bytes(key))
    }

    fn write(
        &mut self,
        records: &FactoryRecords,
        is_there: bool,
        kind: Kind,
        payload: impl FnOnce(&mut Writer<'_>),
    ) -> Result<(), StorageError<F::Error>> {
        if is_there {
            return Err(StorageError::AlreadyProvisioned);
        }
        if !GRANULE.is_multiple_of(F::WRITE_SIZE) {
            return Err(StorageError::Geometry("of words of 1, 2, 4, 8, 16 or 32 bytes"));
        }
        let mut record = [0; MAX_RECORD];
        let granules = encode(&mut record, kind, 1, 0, payload).filter(|granules| records.free + granules <= GRANULES);
        let Some(granules) = granules else { return Err(StorageError::Full) };
        let bytes = record.get(..usize::from(granules) * GRANULE).unwrap_or_default();
        program(&mut self.region, u32::from(records.free) * GRANULE as u32, bytes)
    }

    /// Returns the region.
    pub fn into_region(self) -> F {
        self.region
    }
}
