//! Dose of vibration by level, and of shocks, kept over a loss of power.

use super::{
    ModelStore, StorageError,
    little_endian::{Reader, Writer},
    record::{Kind, encode},
    room,
    sector_size::granules_of,
};
use crate::survey::VibrationDose;
use embedded_storage::nor_flash::NorFlash;

/// Version of the payload's layout.
const VERSION: u8 = 1;

fn lay_out(writer: &mut Writer<'_>, dose: &VibrationDose) {
    writer.f32s(&dose.axial_s);
    writer.f32s(&dose.lateral_s);
    writer.f32s(&dose.stick_slip_s);
    writer.u32(dose.shocks);
    dose.shocks_over.iter().for_each(|count| writer.u32(*count));
}

/// Returns the dose of a payload; `None` for bytes that do not encode a dose.
fn decode(payload: &[u8]) -> Option<VibrationDose> {
    let mut reader = Reader(payload);
    let dose = VibrationDose {
        axial_s: reader.f32s()?,
        lateral_s: reader.f32s()?,
        stick_slip_s: reader.f32s()?,
        shocks: reader.u32()?,
        shocks_over: [reader.u32()?, reader.u32()?, reader.u32()?],
    };
    let times = [&dose.axial_s, &dose.lateral_s, &dose.stick_slip_s];
    times.into_iter().flatten().all(|time| time.is_finite() && *time >= 0.0).then_some(dose)
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Begins to store a dose; [`ModelStore::step`] programs it piece by piece. The dose stored before counts until the
    /// new one is whole.
    ///
    /// # Errors
    /// `Busy`: another record is being written. `Full`: the room left is reserved for models. Nothing is written.
    #[inline(never)]
    pub fn begin_dose(&mut self, dose: &VibrationDose) -> Result<(), StorageError<F::Error>> {
        if self.is_writing() {
            return Err(StorageError::Busy);
        }
        let number = self.index.last_number.saturating_add(1);
        let encoded = encode(&mut self.buffer, Kind::DOSE, VERSION, number, |writer| lay_out(writer, dose));
        let granules = encoded.ok_or(StorageError::Full)?;
        let place =
            room::take::<F>(&mut self.sectors, granules, 1, granules_of::<F>() / 2).ok_or(StorageError::Full)?;
        self.index.last_number = number;
        // Parts of the estimator's state that wait for their model have an earlier number: they are given up.
        self.learnt_number = None;
        self.begin_writing(Kind::DOSE, number, place, granules);
        Ok(())
    }

    /// Returns the newest dose; `None` if none was stored.
    #[inline(never)]
    pub fn read_dose(&mut self) -> Option<VibrationDose> {
        loop {
            let (_, place) = self.index.dose?;
            if let Some(header) = self.read_record(place) {
                return header.payload(&self.buffer).filter(|_| header.version == VERSION).and_then(decode);
            }
            // The dose before counts again; each dose is dropped at most once.
            let before = self.index.dose;
            self.forget_rotten(place);
            if self.index.dose == before {
                return None;
            }
        }
    }
}
