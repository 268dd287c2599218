//! Commands whose settings outlive the power: the newest of each, as it came.

use super::{
    ModelStore, Progress, StorageError,
    model_store::FOR_COUNTERS,
    record::{COMMANDS, Kind},
};
use embedded_storage::nor_flash::NorFlash;

/// Command whose newest one is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum StoredCommand {
    /// Configuration of the pipeline and of the surveys.
    Configure,
    /// Configuration of the surveys alone.
    ConfigureSurvey,
}

impl StoredCommand {
    const fn kind(self) -> Kind {
        match self {
            Self::Configure => Kind::CONFIGURE,
            Self::ConfigureSurvey => Kind::CONFIGURE_SURVEY,
        }
    }
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Stores a command's bytes at once, for use while nothing is sampled. The one before counts until this one is
    /// whole. Empty bytes say that nothing is set any more.
    ///
    /// # Errors
    /// The one before stays. `Busy`: another record is being written. `Full`: it is too long, or there is no room
    /// (counted). Or the flash failed (counted).
    #[inline(never)]
    pub fn store_command(&mut self, command: StoredCommand, bytes: &[u8]) -> Result<(), StorageError<F::Error>> {
        match self.begin_newest(command.kind(), COMMANDS, FOR_COUNTERS, &|writer| writer.bytes(bytes)) {
            Err(StorageError::Full) => return self.refuse_full(),
            begun => begun?,
        }
        while self.step()? != Progress::CommandStored {}
        Ok(())
    }

    /// Returns a command's bytes, and the number of their record, which is higher the later it was stored; `None` if
    /// none was stored, or by a firmware that lays it out otherwise, or while a record is being written.
    #[inline(never)]
    pub fn read_command(&mut self, command: StoredCommand) -> Option<(u32, &[u8])> {
        let header = self.read_newest(command.kind())?;
        let bytes = header.payload(&self.buffer).filter(|_| header.version == COMMANDS)?;
        Some((header.number, bytes))
    }
}
