//! Vibration dose of the tool: it is there after every power cut, and takes no room from models.

use super::models::{Dice, prepare};
use meerkat_mwd::{storage::StorageError, survey::VibrationDose};
use mwd::power_cuts::{
    doses::{blank, cut_everywhere, dose, keep},
    models::powered_up,
};

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
    let left = cut_everywhere();
    assert_eq!((left.starts().lost, &left.first), (0, &None));
    assert_eq!((left.actions, left.operations), (3, 3 * 32), "four granules each");
}

#[test]
fn what_can_be_no_dose_is_none() {
    let mut store = blank();
    keep(&mut store, &VibrationDose { axial_s: [f32::NAN; 8], ..dose(3) }).unwrap();
    assert_eq!(powered_up(store).read_dose(), None);
}
