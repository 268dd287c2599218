//! While drilling nothing is erased, and what finds no room is refused and counted.

use super::models::{Chip, Dice, KIB, Store, TEMPERATURES_C, open, prepare};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{ModelStore, NotDrilling, Outcome, Preparation, StorageError},
};
use mock_flash::{Cut, MockFlash};

#[test]
fn drilling_only_programs_words_until_there_is_no_room_and_then_refuses_and_counts() {
    let mut dice = Dice::new(11);
    let mut store: Store<4, { 16 * KIB }> = open(Chip::new(3, 2));
    prepare(&mut store);
    store.flash_mut().allow_erase(false);
    let (mut stored, mut last) = (0, None);
    loop {
        let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
        let model = dice.model(2, band, stored);
        match store.store_model(&model) {
            Ok(_) => (stored, last) = (stored + 1, Some(model)),
            Err(StorageError::Full) => break,
            Err(e) => panic!("{e:?}"),
        }
    }
    println!("{stored} models of two effects without erasing");
    assert!(stored > 100);
    assert_eq!((store.counts().refused_full, store.counts().stored), (1, stored as u32));
    // Commands still get their counter, for a while.
    for counter in 1..=16 {
        store.store_counter(counter).unwrap();
    }
    let outcome = store.restore(None).unwrap().outcome;
    assert!(matches!(outcome, Outcome::Chosen { model, .. } if Some(model) == last));
    // Not drilling any more.
    store.flash_mut().allow_erase(true);
    assert!(matches!(prepare(&mut store), 1..=2));
    assert_eq!((store.store_model(&last.unwrap()).is_ok(), store.read_counter()), (true, 16));
}

#[test]
fn a_flash_that_was_never_prepared_takes_nothing_and_says_so() {
    let mut store: Store<4, { 16 * KIB }> = open(Chip::new(3, 2));
    let model = Dice::new(1).model(0, 0, 0);
    assert_eq!(store.store_model(&model), Err(StorageError::Full));
    assert_eq!(store.store_counter(1), Err(StorageError::Full));
    assert_eq!(store.restore(None).unwrap().outcome, Outcome::NothingStored);
    assert_eq!(prepare(&mut store), 3);
    assert!(store.store_model(&model).is_ok());
}

#[test]
fn the_counter_only_rises() {
    let mut store: Store<4, { 16 * KIB }> = open(Chip::new(3, 2));
    prepare(&mut store);
    store.store_counter(7).unwrap();
    for lower in [7, 6, 0] {
        assert_eq!(store.store_counter(lower), Err(StorageError::CounterGoesBack { stored: 7 }));
    }
    store.store_counter(u64::MAX).unwrap();
    assert_eq!(open(store.into_flash()).read_counter(), u64::MAX);
}

#[test]
fn words_of_every_size_work_and_other_geometries_are_refused() {
    fn works<const WORD: usize>() {
        let mut store: Store<WORD, { 8 * KIB }> = open(MockFlash::new(3, 5));
        prepare(&mut store);
        let model = Dice::new(5).model(MAX_ACTIVE, 2, 9);
        store.store_model(&model).unwrap();
        let outcome = open(store.into_flash()).restore(Some(90.0)).unwrap().outcome;
        assert!(matches!(outcome, Outcome::Chosen { model: found, .. } if found == model));
    }
    works::<1>();
    works::<2>();
    works::<4>();
    works::<8>();
    works::<16>();
    works::<32>();
    let small = ModelStore::<_, 3>::open(MockFlash::<4, { 4 * KIB }>::new(3, 0), super::models::limits());
    assert!(matches!(small, Err(StorageError::Geometry(_))), "three sectors of 16 KiB take twelve pages");
    let few = ModelStore::<_, 3>::open(MockFlash::<4, { 16 * KIB }>::new(2, 0), super::models::limits());
    assert!(matches!(few, Err(StorageError::Geometry(_))));
    let wide = ModelStore::<_, 3>::open(MockFlash::<64, { 16 * KIB }>::new(3, 0), super::models::limits());
    assert!(matches!(wide, Err(StorageError::Geometry(_))));
}

#[test]
fn what_was_retired_is_not_restored_and_what_comes_after_is() {
    let mut dice = Dice::new(21);
    let mut store: Store<4, { 16 * KIB }> = open(Chip::new(3, 2));
    prepare(&mut store);
    for band in 0..4 {
        store.store_model(&dice.model(1, band, 0)).unwrap();
    }
    store.retire_models().unwrap();
    assert_eq!(store.restore(None).unwrap().outcome, Outcome::AllRetired);
    store = open(store.into_flash());
    assert_eq!(store.restore(Some(20.0)).unwrap().outcome, Outcome::AllRetired);
    assert_eq!(store.scan_counts().retired, 4);
    let model = dice.model(1, 3, 0);
    store.store_model(&model).unwrap();
    let restoration = open(store.into_flash()).restore(Some(20.0)).unwrap();
    assert!(matches!(restoration.outcome, Outcome::Chosen { model: found, .. } if found == model));
    assert_eq!(restoration.choice, 1);
}

#[test]
fn with_a_sector_that_no_longer_erases_the_other_two_go_on() {
    for stuck in 0..3 {
        let mut dice = Dice::new(22);
        let mut flash = Chip::new(3, 2);
        flash.wear_out(stuck);
        let mut store: Store<4, { 16 * KIB }> = open(flash);
        prepare(&mut store);
        assert_eq!(store.prepare(NotDrilling::Command), Ok(Preparation::Ready { bad: 1 }));
        let mut newest = [None; TEMPERATURES_C.len()];
        for t_us in 0..600 {
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let model = dice.model(2, band, t_us);
            if store.store_model(&model) == Err(StorageError::Full) {
                prepare(&mut store);
                store.store_model(&model).unwrap();
            }
            newest[band] = Some(model);
            if dice.below(40) == 0 {
                store = open(store.into_flash());
                prepare(&mut store);
            }
        }
        for (newest, t) in newest.into_iter().zip(TEMPERATURES_C) {
            let outcome = store.restore(Some(t)).unwrap().outcome;
            assert!(matches!(outcome, Outcome::Chosen { model, .. } if Some(model) == newest), "sector {stuck}");
        }
        assert_eq!(store.counts().abandoned, 0);
    }
}

/// Pages of 4 KiB, the nRF52840's and those of most external chips, make sectors of four; each call of
/// `prepare` erases one page.
#[test]
fn small_pages_make_sectors() {
    let mut dice = Dice::new(71);
    let mut store: Store<4, { 4 * KIB }> = open(MockFlash::new(12, 5));
    let mut erased = 0;
    while store.prepare(NotDrilling::PowerUp) == Ok(Preparation::More) {
        let erases: u32 = store.flash_mut().erases().iter().sum();
        assert!(erases <= erased + 1, "one page in a call");
        erased = erases;
    }
    assert_eq!(erased, 12);
    let mut newest = [None; TEMPERATURES_C.len()];
    for t_us in 0..2_000 {
        let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
        let model = dice.model(2, band, t_us);
        if store.store_model(&model) == Err(StorageError::Full) {
            while store.prepare(NotDrilling::Command) == Ok(Preparation::More) {}
            store.store_model(&model).unwrap();
        }
        newest[band] = Some(model);
        if dice.below(100) == 0 {
            store.store_counter(t_us + 1).unwrap();
            let counter = store.read_counter();
            // Cut off between two pages of a sector, too.
            store.flash_mut().cut_in(u64::from(dice.below(40)), Cut::Torn);
            while store.prepare(NotDrilling::PowerUp) == Ok(Preparation::More) {}
            let mut flash = store.into_flash();
            flash.power_up();
            store = open(flash);
            while store.prepare(NotDrilling::PowerUp) == Ok(Preparation::More) {}
            assert_eq!(store.read_counter(), counter);
        }
    }
    for (newest, t) in newest.into_iter().zip(TEMPERATURES_C) {
        let outcome = store.restore(Some(t)).unwrap().outcome;
        assert!(matches!(outcome, Outcome::Chosen { model, .. } if Some(model) == newest));
    }
}
