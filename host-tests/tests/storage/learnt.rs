//! Learnt state of the filter, stored beside its model: restored to the bit, or not at all.

use super::{
    flight::{drilling, probe},
    models::{Chip, Dice, KIB, Small, Store, open, prepare},
};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    estimator::{NUMBERS, NotContinued},
    storage::{LearntProgress, NotDrilling, Outcome, Preparation, StorageError},
};
use mock_flash::CUTS;
use mwd::power_cuts::learnt::{ChipStore, Numbers, cut_everywhere, drilled, kept, store_both};

#[test]
fn what_was_learnt_comes_back_to_the_bit_with_its_model() {
    let (probe, _) = drilled(60.0, 1);
    let mut store: ChipStore = open(Chip::new(3, 1));
    prepare(&mut store);
    let model = Dice::new(1).model(2, 0, 1);
    store_both(&mut store, &probe, &model).unwrap();
    let numbers = Numbers::of(&probe);
    assert!(numbers.head.motion_s > 40.0 && numbers.bits.iter().filter(|x| **x != 0).count() > NUMBERS / 2);
    assert_eq!(kept(&mut open(store.clone().into_flash())), Some((model, Some(numbers.clone()))));
    // One without has none, and copies are as good as the original.
    let next = Dice::new(2).model(1, 1, 2);
    store.store_model(&next).unwrap();
    assert_eq!(kept(&mut store), Some((next, None)));
    let number = store.restore(Some(15.0)).unwrap();
    let Outcome::Chosen { number, .. } = number.outcome else { panic!("{number:?}") };
    for _ in 0..6 {
        for t_us in 0..60 {
            // Model of another temperature, or it would take the place of the one that has a learnt filter.
            store.store_model(&Dice::new(t_us).model(1, 1, t_us)).unwrap();
        }
        store = open(store.into_flash());
        prepare(&mut store);
        assert_eq!(Numbers::stored_with(&mut store, number).as_ref(), Some(&numbers));
    }
    assert!(store.erases().iter().all(|erases| *erases > 1));
}

#[test]
fn the_filter_goes_on_from_it_but_not_from_what_is_no_root_or_anothers() {
    let (ended, config) = drilled(60.0, 2);
    let numbers = Numbers::of(&ended);
    let begun = || probe(&config, None);
    let factory = Numbers::of(&begun());
    let mut next = begun();
    assert_eq!(numbers.give(&mut next), Ok(()));
    assert!(Numbers::of(&next).bits != factory.bits && Numbers::of(&next).head.motion_s == numbers.head.motion_s);
    let refused = |spoil: &dyn Fn(&mut Numbers)| {
        let (mut spoilt, mut next) = (numbers.clone(), begun());
        spoil(&mut spoilt);
        let refusal = spoilt.give(&mut next).unwrap_err();
        assert_eq!(Numbers::of(&next).bits, factory.bits, "{refusal:?}");
        assert_eq!(Numbers::of(&next).head.motion_s, 0.0);
        refusal
    };
    for x in [f32::NAN, f32::INFINITY, 1e30] {
        assert_eq!(refused(&|n| n.bits[100] = x.to_bits()), NotContinued::NotARoot, "{x}");
    }
    // The first of the diagonal, behind the 37 of the mean, and the last.
    for k in [37, NUMBERS - 1] {
        assert_eq!(refused(&|n| n.bits[k] = 0), NotContinued::NotARoot, "{k}");
    }
    assert_eq!(refused(&|n| n.head.motion_s = f32::NAN), NotContinued::NotARoot);
    assert_eq!(refused(&|n| n.head.fingerprint ^= 1), NotContinued::OtherFilter);
    let mut other = config;
    other.identification.prior_sigma_diagonal = 0.05;
    assert_eq!(numbers.give(&mut probe(&other, None)), Err(NotContinued::OtherFilter));
    let mut half = begun();
    let said = half.go_on(&numbers.head, |take| {
        take(3, 1.0);
        false
    });
    assert_eq!((said, Numbers::of(&half).bits), (Err(NotContinued::Incomplete), factory.bits));
    let (trace, _) = drilling(12.0, 2);
    next.push(&trace.samples[0]);
    assert_eq!(numbers.give(&mut next), Err(NotContinued::NotAtTheBeginning));
}

#[test]
fn after_a_cut_at_every_word_the_old_model_or_the_new_one_is_there_with_its_own() {
    let left = cut_everywhere();
    println!("{} words: {:?}", left.operations, left.starts());
    assert_eq!((left.starts().lost, &left.first), (0, &None));
    assert!(left.operations > 740 && left.starts().old > 2000 && left.starts().new > 0);
}

#[test]
fn a_cut_at_every_word_and_erasure_of_a_preparation_loses_nothing() {
    let (probe, _) = drilled(40.0, 5);
    let mut dice = Dice::new(4);
    let mut store: ChipStore = open(Chip::new(3, 1));
    prepare(&mut store);
    let model = dice.model(1, 0, 1);
    store_both(&mut store, &probe, &model).unwrap();
    // Models of another temperature into the second sector, so that the first one is to be erased.
    for t_us in 0..70 {
        store.store_model(&dice.model(2, 2, t_us)).unwrap();
    }
    store = open(store.into_flash());
    let of_first = |store: &mut ChipStore| match store.restore(Some(15.0)).unwrap().outcome {
        Outcome::Chosen { model, number, .. } => Some((model, Numbers::stored_with(store, number))),
        _ => None,
    };
    let before = of_first(&mut store);
    assert_eq!(before, Some((model, Some(Numbers::of(&probe)))));
    let mut complete = store.clone();
    assert!(prepare(&mut complete) > 0);
    assert_eq!(of_first(&mut complete), before);
    let operations = complete.flash_mut().operations() - store.flash_mut().operations();
    assert!(operations > 740, "{operations}");
    for operation in 0..operations {
        for cut in CUTS {
            let mut cut_off = store.clone();
            cut_off.flash_mut().cut_in(operation, cut);
            while matches!(cut_off.prepare(NotDrilling::PowerUp), Ok(Preparation::More)) {}
            let mut flash = cut_off.into_flash();
            flash.power_up();
            let mut restarted: ChipStore = open(flash);
            assert_eq!(of_first(&mut restarted), before, "operation {operation}, {cut:?}");
            if dice.below(20) == 0 {
                prepare(&mut restarted);
                assert_eq!(of_first(&mut restarted), before, "prepared: operation {operation}, {cut:?}");
            }
        }
    }
}

#[test]
fn a_filter_that_goes_on_meanwhile_spoils_it_and_the_model_stands_alone() {
    let (mut probe, _) = drilled(40.0, 6);
    let (trace, _) = drilling(45.0, 6);
    let mut store: ChipStore = open(Chip::new(3, 1));
    prepare(&mut store);
    store.begin_learnt().unwrap();
    assert!(!store.holds_filter());
    assert_eq!(store.step_learnt(None), Ok(LearntProgress::Waiting));
    for _ in 0..30 {
        assert_eq!(store.step_learnt(probe.learnt()), Ok(LearntProgress::More));
        assert!(store.holds_filter());
    }
    let model = Dice::new(5).model(0, 0, 1);
    assert_eq!(store.begin_model(&model), Err(StorageError::Busy));
    for sample in trace.samples.iter().filter(|sample| sample.t_us > 40_000_000) {
        probe.push(sample);
        probe.poll(probe.poll_budget());
    }
    while probe.learnt().is_none() {
        probe.poll(1);
    }
    let end =
        std::iter::repeat_with(|| store.step_learnt(probe.learnt())).find(|said| *said != Ok(LearntProgress::More));
    assert_eq!(end, Some(Err(StorageError::FilterWentOn)));
    assert!(!store.is_writing());
    store.store_model(&model).unwrap();
    assert_eq!(kept(&mut open(store.into_flash())), Some((model, None)));
}

#[test]
fn models_keep_half_of_the_last_sector_and_small_sectors_take_models_alone() {
    let (probe, _) = drilled(40.0, 7);
    let mut dice = Dice::new(6);
    let mut store: ChipStore = open(Chip::new(3, 1));
    prepare(&mut store);
    store.flash_mut().allow_erase(false);
    let mut sets = 0;
    while store_both(&mut store, &probe, &dice.model(0, 0, sets)).is_ok() {
        sets += 1;
    }
    let mut models = 0;
    while store.store_model(&dice.model(0, 0, models)).is_ok() {
        models += 1;
    }
    println!("{sets} sets and {models} models more without erasing");
    assert!(sets >= 6 && models >= 40);
    assert_eq!((store.counts().learnt_refused, store.counts().refused_full), (1, 1));
    let mut small: Store<4, { 8 * KIB }> = open(Small::new(3, 1));
    prepare(&mut small);
    assert_eq!(small.begin_learnt(), Err(StorageError::Full));
    assert!(small.store_model(&dice.model(MAX_ACTIVE, 0, 0)).is_ok());
}
