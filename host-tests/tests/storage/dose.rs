//! Vibration dose of the tool: it is there after every power cut, and takes no room from models.

use super::models::{Dice, KIB, Store, open, prepare};
use meerkat_mwd::{
    storage::{Progress, StorageError},
    survey::VibrationDose,
};
use mock_flash::{CUTS, MockError, MockFlash};

type SmallStore = Store<4, { 8 * KIB }>;

fn blank() -> SmallStore {
    let mut store = open(MockFlash::new(3, 17));
    prepare(&mut store);
    store
}

/// The dose after so many hours.
fn dose(hours: u32) -> VibrationDose {
    let seconds = |level: usize| 3_600.0 * hours as f32 / (1 + level) as f32;
    VibrationDose {
        axial_s: std::array::from_fn(seconds),
        lateral_s: std::array::from_fn(|level| 0.5 * seconds(level)),
        stick_slip_s: std::array::from_fn(|level| 0.25 * seconds(level)),
        shocks: 90 * hours,
        shocks_over: [9 * hours, 3 * hours, hours],
    }
}

fn keep(store: &mut SmallStore, dose: &VibrationDose) -> Result<(), StorageError<MockError>> {
    store.begin_dose(dose)?;
    loop {
        if store.step()? == Progress::DoseStored {
            return Ok(());
        }
    }
}

fn powered_up(store: SmallStore) -> SmallStore {
    let mut flash = store.into_flash();
    flash.power_up();
    open(flash)
}

#[test]
fn the_newest_dose_outlives_models_commands_and_erasures() {
    let (mut store, mut dice) = (blank(), Dice::new(5));
    assert_eq!(store.read_dose(), None);
    let (mut stored, mut refused) = (None, 0);
    for hours in 1..400 {
        match keep(&mut store, &dose(hours)) {
            Ok(()) => stored = Some(dose(hours)),
            Err(StorageError::Full) => refused += 1,
            Err(error) => panic!("{error:?}"),
        }
        assert_eq!(store.read_dose(), stored);
        if hours % 3 == 0 {
            // There is always room for a model and a command where there was some for a dose.
            let model = dice.model(3, (hours / 3 % 4) as usize, u64::from(hours));
            let kept = store.store_model(&model).is_ok();
            let counted = store.store_counter(u64::from(hours)).is_ok();
            assert!((kept && counted) || refused > 0, "{hours} h");
        }
        if hours % 40 == 0 {
            store = powered_up(store);
            prepare(&mut store);
        }
    }
    let erased = store.erases();
    println!("{refused} of 399 doses had no room; erasures {erased:?}");
    assert!(erased.iter().sum::<u32>() > 6);
    assert_eq!(powered_up(store).read_dose(), stored);
}

#[test]
fn a_cut_at_any_word_leaves_the_dose_before_or_the_new_one() {
    let mut cuts = 0;
    // Cuts of a first dose, of a later one, and of one after which the sectors are prepared.
    for before in [0, 1, 30] {
        let whole = |hours: u32| {
            let mut store = blank();
            (1..=hours).for_each(|hours| keep(&mut store, &dose(hours)).unwrap());
            store.into_flash()
        };
        let changed = |flash: MockFlash<4, { 8 * KIB }>| {
            let mut store = open(flash);
            let kept = keep(&mut store, &dose(before + 1)).is_ok();
            (store, kept)
        };
        let start = whole(before);
        let words = changed(start.clone()).0.into_flash().operations() - start.operations();
        assert_eq!(words, 32, "four granules");
        for operation in 0..words {
            for cut in CUTS {
                let mut flash = start.clone();
                flash.cut_in(operation, cut);
                let (store, kept) = changed(flash);
                let mut store = powered_up(store);
                let old = (before > 0).then(|| dose(before));
                let read = store.read_dose();
                assert!(
                    read == Some(dose(before + 1)) || (!kept && read == old),
                    "{before} {operation} {cut:?}: {read:?}"
                );
                prepare(&mut store);
                let after = store.read_dose();
                assert!(after == read || after == old, "{before} {operation} {cut:?}");
                // And it goes on.
                keep(&mut store, &dose(before + 2)).unwrap();
                assert_eq!(powered_up(store).read_dose(), Some(dose(before + 2)));
                cuts += 1;
            }
        }
    }
    println!("{cuts} power cuts while a dose is stored");
}

#[test]
fn what_can_be_no_dose_is_none() {
    let mut store = blank();
    keep(&mut store, &VibrationDose { axial_s: [f32::NAN; 8], ..dose(3) }).unwrap();
    assert_eq!(powered_up(store).read_dose(), None);
}
