//! Dose of vibration by level, and of shocks, kept over a loss of power.

use super::{
    ModelStore, StorageError,
    little_endian::{Reader, Writer},
    record::Kind,
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
    let times: [&[f32]; 3] = [&dose.axial_s, &dose.lateral_s, &dose.stick_slip_s];
    times.into_iter().all(are_times).then_some(dose)
}

#[inline(never)]
fn are_times(times: &[f32]) -> bool {
    times.iter().all(|time| time.is_finite() && *time >= 0.0)
}

impl<F: NorFlash, const SECTORS: usize> ModelStore<F, SECTORS> {
    /// Begins to store a dose; [`ModelStore::step`] programs it piece by piece. The dose stored before counts until the
    /// new one is whole.
    ///
    /// # Errors
    /// `Busy`: another record is being written. `Full`: the room left is reserved for models. Nothing is written.
    pub fn begin_dose(&mut self, dose: &VibrationDose) -> Result<(), StorageError<F::Error>> {
        self.begin_newest(Kind::DOSE, VERSION, granules_of::<F>() / 2, &|writer| lay_out(writer, dose))
    }

    /// Returns the newest dose; `None` if none was stored.
    #[inline(never)]
    pub fn read_dose(&mut self) -> Option<VibrationDose> {
        let header = self.read_newest(Kind::DOSE)?;
        header.payload(&self.buffer).filter(|_| header.version == VERSION).and_then(decode)
    }
}
