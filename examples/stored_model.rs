//! A model that survives: learnt, stored in flash, and flown from the first sample after the power was off.
//!
//! `cargo run --example stored_model --features storage`

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use meerkat_mwd::{
    Probe,
    compensation::{ActiveEffects, GyroModel, effects::LIBRARY},
    identification::{Decision, WindowReport},
    storage::{Limits, ModelStore, NotDrilling, Outcome, Preparation, StoreReason, StoredModel, fingerprint},
};

pub(crate) mod motion;

/// Three sectors of NOR flash in memory. On a chip this is its driver.
pub(crate) struct Flash(Vec<u8>);

/// The flash's error: an address that it does not have.
#[derive(Debug)]
pub(crate) struct OutOfFlash;

impl NorFlashError for OutOfFlash {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for Flash {
    type Error = OutOfFlash;
}

impl Flash {
    const SECTOR: usize = 16 * 1024;

    fn at(&mut self, from: u32, to: usize) -> Result<&mut [u8], OutOfFlash> {
        self.0.get_mut(from as usize..to).ok_or(OutOfFlash)
    }
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfFlash> {
        bytes.copy_from_slice(self.at(offset, offset as usize + bytes.len())?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = Self::SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfFlash> {
        self.at(from, to as usize)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfFlash> {
        // Programming clears bits.
        let stored = self.at(offset, offset as usize + bytes.len())?;
        stored.iter_mut().zip(bytes).for_each(|(stored, byte)| *stored &= byte);
        Ok(())
    }
}

/// Learns and stores models. Returns the last one stored, and the one that flies after the power was off.
pub(crate) fn after_power_off() -> Result<(GyroModel, GyroModel), Box<dyn std::error::Error>> {
    let config = motion::config();
    let limits = Limits::new(&config, &LIBRARY);

    let mut probe = Box::new(Probe::new());
    probe.configure(&config)?;
    let mut store = ModelStore::<_, 3>::open(Flash(vec![0; 3 * Flash::SECTOR]), limits).map_err(debug)?;
    // Erases, so only where nobody drills.
    while store.prepare(NotDrilling::PowerUp).map_err(debug)? == Preparation::More {}
    let mut stored = GyroModel::IDENTITY;
    for sample in motion::samples(90.0, |_| nalgebra::Vector3::zeros()) {
        probe.push(&sample);
        // The firmware stores what three windows have left as it is; see `StabilityGate`.
        if let Some(report) = probe.poll(probe.poll_budget())
            && report.decision == Decision::Accepted
        {
            store.store_model(&model(&probe, &report)).map_err(debug)?;
            stored = *probe.gyro_model();
        }
    }

    // The power goes and comes back: only the flash is left.
    let mut store = ModelStore::<_, 3>::open(store.into_flash(), limits).map_err(debug)?;
    let mut probe = Box::new(Probe::new());
    probe.configure(&config)?;
    let restoration = store.restore(None).map_err(debug)?;
    let Outcome::Chosen { model, .. } = restoration.outcome else {
        return Err(format!("nothing to restore: {:?}", restoration.outcome).into());
    };
    probe.restore(&model).map_err(debug)?;
    Ok((stored, *probe.gyro_model()))
}

fn model(probe: &Probe, report: &WindowReport) -> StoredModel {
    StoredModel {
        gyro: *probe.gyro_model(),
        sigma: report.sigma,
        effects: ActiveEffects::none(),
        library: fingerprint(probe.library(), probe.config()),
        temperature_c: None,
        t_us: report.t_end_us,
        reason: StoreReason::Command,
    }
}

fn debug(error: impl std::fmt::Debug) -> String {
    format!("{error:?}")
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (stored, restored) = after_power_off()?;
    println!("stored:   {stored:.4?}\nrestored: {restored:.4?}\ntrue:     {:.4?}", motion::TRUE);
    Ok(())
}
