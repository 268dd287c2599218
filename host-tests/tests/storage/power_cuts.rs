//! The power goes at every word and at every erasure of a long sequence, and at random again and again.

use super::models::{Dice, Small, TEMPERATURES_C, open, prepare};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{Outcome, Progress, StorageError},
};
use mock_flash::CUTS;
use mwd::power_cuts::models::{Action, Promised, powered_up, run, script_cut_everywhere};

#[test]
fn after_a_cut_at_every_word_and_every_erasure_the_last_complete_model_is_there() {
    let left = script_cut_everywhere();
    for left in &left {
        println!("{} actions, {:?}", left.actions, left.starts());
        assert_eq!((left.starts().lost, &left.first), (0, &None));
    }
    println!("{} cuts", left.iter().map(|left| left.starts().all()).sum::<u64>());
    let [room, models, ..] = &left;
    let [_, torn, _] = models.cuts;
    assert!(torn.old > 1000 && room.actions == 9, "{torn:?}, {} times", room.actions);
}

#[test]
fn cut_at_random_thousands_of_times_it_loses_nothing_and_always_goes_on() {
    let (mut cuts, mut completed) = (0, 0);
    for seed in 0..6 {
        let mut dice = Dice::new(100 + seed);
        let mut store = open(Small::new(3, seed));
        prepare(&mut store);
        let (mut promised, mut t_us) = (Promised::default(), 0);
        for _ in 0..3000 {
            t_us += 1;
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let action = match dice.below(40) {
                0..20 => Action::Model(band, {
                    let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
                    dice.model(effects, band, t_us)
                }),
                20..28 => Action::Counter(promised.counter + 1 + u64::from(dice.below(5))),
                28 => Action::Retire,
                _ => Action::Prepare,
            };
            let after = promised.after(&action);
            // Mostly soon, so that preparing is cut off again and again.
            let soon = [4, 40, 400, 4000][dice.below(4) as usize];
            let cut = CUTS[dice.below(3) as usize];
            store.flash_mut().cut_in(u64::from(dice.below(soon)), cut);
            let said = run(&mut store, &action);
            if store.flash_mut().is_on() {
                match said {
                    Ok(()) => {
                        completed += 1;
                        promised = after;
                    }
                    Err(StorageError::Full) => {}
                    Err(e) => panic!("seed {seed}: {e:?}"),
                }
                store.flash_mut().power_up();
                assert!(promised.is_kept_by(&mut store), "seed {seed}, {action:?}");
                continue;
            }
            cuts += 1;
            store = powered_up(store);
            if !promised.is_kept_by(&mut store) {
                assert!(after.is_kept_by(&mut store), "seed {seed}, {action:?}");
                promised = after;
            }
        }
        prepare(&mut store);
        assert!(promised.is_kept_by(&mut store));
        assert_eq!(store.counts().abandoned, 0);
    }
    println!("{cuts} cuts, {completed} actions completed");
    assert!(cuts > 3000 && completed > 3000);
}

/// Between samples a model is written in pieces, and a command's counter may come between them.
#[test]
fn a_counter_that_comes_while_a_model_is_written_is_stored_and_so_is_the_model() {
    let mut dice = Dice::new(3);
    let model = dice.model(MAX_ACTIVE, 1, 1);
    let pieces_in_all = {
        let mut store = open(Small::new(3, 9));
        prepare(&mut store);
        store.begin_model(&model).unwrap();
        1 + std::iter::from_fn(|| (store.step() == Ok(Progress::More)).then_some(())).count()
    };
    assert!(pieces_in_all > 8);
    for pieces in 0..pieces_in_all {
        for cut_after_counter in [false, true] {
            let mut store = open(Small::new(3, 9));
            prepare(&mut store);
            store.begin_model(&model).unwrap();
            for _ in 0..pieces {
                assert_eq!(store.step(), Ok(Progress::More));
            }
            store.store_counter(5).unwrap();
            assert_eq!(store.begin_model(&model), Err(StorageError::Busy));
            if cut_after_counter {
                let mut restarted = powered_up(store);
                assert_eq!(restarted.read_counter(), 5);
                assert_eq!(restarted.restore(None).unwrap().outcome, Outcome::NothingStored);
                assert_eq!(restarted.scan_counts().damaged, u32::from(pieces > 0));
                continue;
            }
            while store.step() == Ok(Progress::More) {}
            let mut restarted = powered_up(store);
            assert_eq!(restarted.read_counter(), 5);
            let outcome = restarted.restore(None).unwrap().outcome;
            assert!(matches!(outcome, Outcome::Chosen { model: found, .. } if found == model));
        }
    }
}
