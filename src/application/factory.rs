//! Factory records: calibration, mounting and key that the probe starts with, and their writing over the line.

use super::{Application, Board};
use crate::{
    config::{Config, ConfigError},
    storage::{FactoryRecord, FactoryRecords, Provisioning, StorageError},
    telemetry::{CommandRefusal, Key},
};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

/// Reads the factory's records; empty ones if they cannot be read.
#[must_use]
pub fn factory_records<R: ReadNorFlash>(region: &mut R) -> FactoryRecords {
    FactoryRecords::read(region).unwrap_or_default()
}

/// Puts the factory's calibration and mounting, where they are recorded, into a configuration.
pub const fn apply_factory_records(records: &FactoryRecords, config: &mut Config) {
    if let Some(calibration) = &records.calibration {
        (config.gyro, config.accel, config.mag) = (calibration.gyro, calibration.accel, calibration.mag);
    }
    if let Some(mounting) = &records.mounting {
        config.survey.toolface_offset_rad = mounting.toolface_offset_rad;
    }
}

/// Writes one of the factory's records into its region, or compares it with what the region holds.
///
/// # Errors
/// The reason of the refusal, for the sender of the command.
pub fn provision<F: NorFlash>(region: F, record: &FactoryRecord, only_check: bool) -> Result<(), CommandRefusal> {
    let mut provisioning = Provisioning::new(region);
    let done = if only_check { provisioning.check(record) } else { provisioning.write(record) };
    done.map_err(|error| match error {
        StorageError::AlreadyProvisioned => CommandRefusal::AlreadyProvisioned,
        StorageError::NotProvisioned => CommandRefusal::NothingThere,
        StorageError::WeakKey | StorageError::Implausible(_) => CommandRefusal::Malformed,
        _ => CommandRefusal::StorageFailed,
    })
}

impl<B: Board> Application<'_, B> {
    /// Writes a record and uses it from now on; a calibration starts the pipeline afresh. A record that the region
    /// holds already changes nothing.
    pub(super) fn provision(&mut self, record: &FactoryRecord, only_check: bool) -> Result<(), CommandRefusal> {
        match self.board.provision(record, true) {
            // It can be written.
            Err(CommandRefusal::NothingThere) if !only_check => {}
            // The record that the region holds is in use already: to use it again would start a flight anew for whoever
            // sends it. What cannot be written changes nothing.
            held => return held,
        }
        if let (FactoryRecord::Calibration(_) | FactoryRecord::Mounting(_), Some(memory)) =
            (record, &mut self.statics.memory)
        {
            // A stored command holds a calibration and a mounting, too, which would fly again after the next start.
            memory.forget_commands()?;
        }
        self.board.provision(record, false)?;
        // The record was checked before it was written.
        let bounds = |_: ConfigError| CommandRefusal::Malformed;
        match record {
            FactoryRecord::Calibration(factory) => {
                let (gyro, accel, mag) = (factory.gyro, factory.accel, factory.mag);
                self.configure(&Config { gyro, accel, mag, ..self.statics.config() }).map_err(bounds)?;
            }
            FactoryRecord::Mounting(mounting) => {
                let Config { earth, mut survey, .. } = self.statics.config();
                survey.toolface_offset_rad = mounting.toolface_offset_rad;
                self.statics.surveyor.configure(&earth, &survey).map_err(bounds)?;
            }
            FactoryRecord::Key(key) => {
                self.statics.commands.provision(Key::new(&key.0, self.board.identity()));
            }
        }
        Ok(())
    }
}
