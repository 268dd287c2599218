//! A flash with anything in it.

use super::flat_flash::FlatFlash;
use meerkat_mwd::{
    Config,
    compensation::effects::LIBRARY,
    storage::{FactoryRecords, Limits, ModelStore, NotDrilling, Outcome},
};

const SECTOR: usize = 8 * 1024;

/// Flash that holds these bytes from its beginning; the rest of it is erased. A model that is restored may fly, the
/// counter does not fall, and the flash can be prepared and written to.
///
/// # Panics
/// One of these does not hold.
pub fn stored_records(bytes: &[u8]) {
    let mut flash = FlatFlash::<SECTOR>(vec![0xFF; 3 * SECTOR]);
    for (place, byte) in flash.0.iter_mut().zip(bytes) {
        *place = *byte;
    }
    let _ = FactoryRecords::read(&mut flash);
    let limits = Limits::new(&Config::default(), &LIBRARY);
    let opened = ModelStore::<_, 3>::open(flash, limits);
    assert!(opened.is_ok(), "a flash that can be read is opened");
    let Ok(mut store) = opened else { return };
    for temperature_c in [None, Some(20.0), Some(f32::NAN)] {
        if let Ok(restoration) = store.restore(temperature_c)
            && let Outcome::Chosen { model, .. } = restoration.outcome
        {
            assert_eq!(limits.check(&model), Ok(()));
        }
    }
    let counter = store.read_counter();
    for _ in 0..12 {
        assert!(store.prepare(NotDrilling::PowerUp).is_ok());
    }
    assert_eq!(store.read_counter(), counter);
    if let Some(next) = counter.checked_add(1) {
        assert_eq!(store.store_counter(next), Ok(()));
    }
}
