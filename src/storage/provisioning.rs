//! Provisioning: the factory's records are written once, and the region is closed with the key.
//!
//! A record that is there already is never written over. Writing the same record again succeeds and changes nothing:
//! after a loss of power the factory repeats all its writes, and a record that was cut off is written behind its torn
//! copy.

use super::{
    FactoryRecord, FactoryRecords, StorageError, can_be_key,
    factory::GRANULES,
    granules::program,
    record::{GRANULE, MAX_RECORD, encode},
};
use embedded_storage::nor_flash::NorFlash;

/// Writer of the factory's region, the only one. It never overwrites and never erases. Afterwards the chip itself has
/// to protect the sector (STM32F4: option bytes, nWRP).
pub struct Provisioning<F> {
    region: F,
}

/// A record as it is written, and its length; `None` if it does not fit.
struct Encoded {
    bytes: [u8; MAX_RECORD],
    granules: Option<u16>,
}

impl Encoded {
    #[inline(never)]
    fn of(record: &FactoryRecord) -> Self {
        let mut bytes = [0; MAX_RECORD];
        let granules = encode(&mut bytes, record.kind(), 1, 0, |writer| record.lay_out(writer));
        Self { bytes, granules }
    }
}

impl<F: NorFlash> Provisioning<F> {
    /// Takes a region; nothing is read or written yet.
    pub const fn new(region: F) -> Self {
        Self { region }
    }

    /// Compares a record with what the region holds.
    ///
    /// # Errors
    /// [`StorageError::NotProvisioned`]: the region holds none of this kind, and this one can be written;
    /// [`StorageError::AlreadyProvisioned`]: it holds a different one, or a key has closed it. The record is invalid,
    /// or the flash failed.
    #[inline(never)]
    pub fn check(&mut self, record: &FactoryRecord) -> Result<(), StorageError<F::Error>> {
        is_valid(record)?;
        let records = FactoryRecords::read(&mut self.region)?;
        let free = if records.key.is_some() { StorageError::AlreadyProvisioned } else { StorageError::NotProvisioned };
        let held = records.of_kind(record).ok_or(free)?;
        let is_same = Encoded::of(&held).bytes == Encoded::of(record).bytes;
        if is_same { Ok(()) } else { Err(StorageError::AlreadyProvisioned) }
    }

    /// Writes a record and reads it back. Does nothing if the same record is there.
    ///
    /// # Errors
    /// A different record of its kind is there, or a key has closed the region; the record is invalid; or the flash
    /// failed: then the write can be repeated.
    pub fn write(&mut self, record: &FactoryRecord) -> Result<(), StorageError<F::Error>> {
        match self.check(record) {
            Err(StorageError::NotProvisioned) => {}
            held => return held,
        }
        let records = FactoryRecords::read(&mut self.region)?;
        if !GRANULE.is_multiple_of(F::WRITE_SIZE) {
            return Err(StorageError::Geometry("of words of 1, 2, 4, 8, 16 or 32 bytes"));
        }
        let Encoded { bytes, granules } = Encoded::of(record);
        let granules = granules.filter(|granules| records.free + granules <= GRANULES);
        let Some(granules) = granules else { return Err(StorageError::Full) };
        let bytes = bytes.get(..usize::from(granules) * GRANULE).unwrap_or_default();
        program(&mut self.region, u32::from(records.free) * GRANULE as u32, bytes)?;
        self.check(record).map_err(|error| match error {
            StorageError::NotProvisioned | StorageError::AlreadyProvisioned => StorageError::NotVerified,
            error => error,
        })
    }

    /// Returns the region.
    pub fn into_region(self) -> F {
        self.region
    }
}

fn is_valid<E>(record: &FactoryRecord) -> Result<(), StorageError<E>> {
    let is_model = match record {
        FactoryRecord::Key(key) if !can_be_key(&key.0) => return Err(StorageError::WeakKey),
        FactoryRecord::Key(_) => true,
        FactoryRecord::Calibration(calibration) => calibration.is_valid(),
        FactoryRecord::Mounting(mounting) => mounting.is_valid(),
    };
    if is_model { Ok(()) } else { Err(StorageError::Implausible(super::Implausible::NotAModel)) }
}
