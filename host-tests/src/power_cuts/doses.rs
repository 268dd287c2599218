//! Cuts of a vibration dose that is stored.

use super::{
    Found, Left,
    drawn::{Small, open, prepare},
    everywhere, itself,
    models::{SmallStore, powered_up},
};
use meerkat_mwd::{
    storage::{Progress, StorageError},
    survey::VibrationDose,
};
use mock_flash::MockError;

/// Storage without a record.
#[must_use]
pub fn blank() -> SmallStore {
    let mut store = open(Small::new(3, 17));
    prepare(&mut store);
    store
}

/// The dose after so many hours.
#[must_use]
pub fn dose(hours: u32) -> VibrationDose {
    let seconds = |level: usize| 3_600.0 * hours as f32 / (1 + level) as f32;
    VibrationDose {
        axial_s: std::array::from_fn(seconds),
        lateral_s: std::array::from_fn(|level| 0.5 * seconds(level)),
        stick_slip_s: std::array::from_fn(|level| 0.25 * seconds(level)),
        shocks: 90 * hours,
        shocks_over: [9 * hours, 3 * hours, hours],
    }
}

/// Stores a dose.
///
/// # Errors
/// The flash failed, or there is no room.
pub fn keep(store: &mut SmallStore, dose: &VibrationDose) -> Result<(), StorageError<MockError>> {
    store.begin_dose(dose)?;
    loop {
        if store.step()? == Progress::DoseStored {
            return Ok(());
        }
    }
}

/// Cuts a first dose, a later one, and one after which the sectors are prepared, everywhere. After each cut room is
/// made, and the next dose stored.
#[must_use]
pub fn cut_everywhere() -> Left {
    let mut left = Left::default();
    for before in [0, 1, 30] {
        let mut store = blank();
        (1..=before).for_each(|hours| keep(&mut store, &dose(hours)).unwrap());
        let (old, new) = ((before > 0).then(|| dose(before)), Some(dose(before + 1)));
        let act = |flash: &mut Small| {
            let mut store = open(flash.clone());
            let is_kept = keep(&mut store, &dose(before + 1)).is_ok();
            *flash = store.into_flash();
            is_kept
        };
        let found = |mut flash: Small| {
            flash.power_up();
            let mut store = open(flash);
            let read = store.read_dose();
            prepare(&mut store);
            let after = store.read_dose();
            let goes_on =
                keep(&mut store, &dose(before + 2)).is_ok() && powered_up(store).read_dose() == Some(dose(before + 2));
            match read {
                _ if !goes_on || (after != read && after != old) => Found::Neither,
                read if read == new => Found::New,
                read if read == old => Found::Old,
                _ => Found::Neither,
            }
        };
        everywhere(&mut left, &store.into_flash(), itself, act, found);
    }
    left
}
