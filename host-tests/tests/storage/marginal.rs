//! Flash that a cut left between two states: a bit that reads as it likes, and words that the error
//! correction gives up on.

use super::models::{Chip, Dice, KIB, Small, Store, limits, open, prepare};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{ModelStore, NotDrilling, Outcome, Preparation, StoredModel},
};
use mock_flash::{CUTS, Cut};

type SmallStore = Store<4, { 8 * KIB }>;

/// Words of one record with a single value.
const WORDS_OF_A_RECORD: u64 = 8;
/// The last of them that is no padding: 16 bytes of header, 8 of payload.
const LAST_NUMBER: u64 = 5;
/// Counters that a sector of 8 KiB takes: its mark and two granules each.
const COUNTERS_OF_A_SECTOR: u64 = 127;

/// The power is back after a cut that left a bit of the last word marginal.
fn with_marginal_bit(store: SmallStore, dice: &mut Dice) -> SmallStore {
    let mut flash = store.into_flash();
    flash.power_up();
    let at = flash.last_touched() + dice.below(4) as usize;
    flash.make_marginal(at, dice.below(8) as u8);
    open(flash)
}

fn power_cycled(store: SmallStore) -> SmallStore {
    let mut flash = store.into_flash();
    flash.power_up();
    open(flash)
}

/// A store of as many counters as a sector takes; the power goes in a word of the next one. Gives it as it is
/// found after that, a bit of that word marginal, and the last counter that was completed.
fn cut_in_the_next_sector(seed: u64, word: u64, cut: Cut) -> (SmallStore, u64) {
    let mut store = open(Small::new(3, seed));
    prepare(&mut store);
    (1..=COUNTERS_OF_A_SECTOR).for_each(|counter| store.store_counter(counter).unwrap());
    store.flash_mut().cut_in(word, cut);
    let completed = COUNTERS_OF_A_SECTOR + u64::from(store.store_counter(COUNTERS_OF_A_SECTOR + 1).is_ok());
    (with_marginal_bit(store, &mut Dice::new(seed)), completed)
}

/// The lowest counter that is read at any of eight power-ups, each prepared.
fn lowest_counter(mut store: SmallStore) -> u64 {
    let mut lowest = store.read_counter();
    for _ in 0..8 {
        prepare(&mut store);
        lowest = lowest.min(store.read_counter());
        store = power_cycled(store);
        lowest = lowest.min(store.read_counter());
    }
    lowest
}

/// Whatever bit of the flash rots.
#[test]
fn a_bit_that_rots_takes_no_completed_counter_back() {
    const LAST: u64 = 3;
    let mut store = open(Small::new(3, 1));
    prepare(&mut store);
    (1..=LAST).for_each(|counter| store.store_counter(counter).unwrap());
    let mut flash = store.into_flash();
    let written: Vec<usize> = (0..flash.bytes_mut().len()).filter(|at| flash.bytes_mut()[*at] != 0xff).collect();
    assert!(written.len() > 100, "{}", written.len());
    for (at, bit) in written.iter().flat_map(|at| (0..8).map(move |bit| (*at, 1 << bit))) {
        flash.bytes_mut()[at] ^= bit;
        let store = open(flash);
        assert_eq!(store.read_counter(), LAST, "byte {at}, bit {bit:#x}");
        flash = store.into_flash();
        flash.bytes_mut()[at] ^= bit;
    }
}

/// The power goes in each word of a counter that begins a sector, and a bit of that word reads as it likes from
/// then on.
#[test]
fn a_counter_never_falls_whatever_a_marginal_bit_reads_as() {
    let (mut cases, mut fallen) = (0, 0);
    for round in 0..25 {
        for word in 0..2 * WORDS_OF_A_RECORD {
            let cut = if round % 2 == 0 { Cut::After } else { Cut::Torn };
            let (store, completed) = cut_in_the_next_sector(1_000 * round + word, word, cut);
            cases += 1;
            fallen += u32::from(lowest_counter(store) < completed);
        }
    }
    println!("{cases} cases; in {fallen} the counter fell");
    assert_eq!(fallen, 0);
}

/// The same where it hurts most: the first copy is whole but for one bit of its last number, and there is no second.
#[test]
fn a_counter_that_begins_a_sector_may_flicker_in_its_last_word() {
    let mut fallen = 0;
    for seed in 0..400 {
        let (store, completed) = cut_in_the_next_sector(seed, LAST_NUMBER, Cut::After);
        fallen += u32::from(lowest_counter(store) < completed);
    }
    assert_eq!(fallen, 0, "of 400 cases");
}

/// The same while a sector is prepared: a counter that was believed once is copied, and never falls.
#[test]
fn a_cut_while_it_is_prepared_and_a_marginal_bit_do_not_turn_the_counter_back() {
    let (mut cases, mut fallen) = (0, 0);
    for seed in 0..12 {
        let mut dice = Dice::new(seed);
        let mut store = open(Small::new(3, seed));
        prepare(&mut store);
        for counter in 1..=COUNTERS_OF_A_SECTOR + u64::from(dice.below(20)) {
            store.store_counter(counter).unwrap();
        }
        let completed = store.read_counter();
        let mut whole = store.clone();
        let before = whole.flash_mut().operations();
        prepare(&mut whole);
        let operations = whole.flash_mut().operations() - before;
        for operation in 0..operations {
            for cut in CUTS {
                let mut store = store.clone();
                store.flash_mut().cut_in(operation, cut);
                while let Ok(Preparation::More) = store.prepare(NotDrilling::PowerUp) {}
                let mut store = with_marginal_bit(store, &mut dice);
                let mut lowest = store.read_counter();
                for _ in 0..4 {
                    prepare(&mut store);
                    lowest = lowest.min(store.read_counter());
                    store = power_cycled(store);
                    lowest = lowest.min(store.read_counter());
                }
                cases += 1;
                fallen += u32::from(lowest < completed);
            }
        }
    }
    println!("{cases} cases; in {fallen} the counter fell");
    assert_eq!(fallen, 0);
}

/// One copy was cut off, the probe was powered up, and then a bit of the other rots.
#[test]
fn a_cut_and_a_flipped_bit_do_not_take_the_counter_back_by_one() {
    let mut fallen = 0;
    for word in 0..2 * WORDS_OF_A_RECORD {
        for bit in 0..8 * 24 {
            let mut store = open(Small::new(3, word));
            prepare(&mut store);
            store.store_counter(1).unwrap();
            let begin = store.flash_mut().last_touched() + 4;
            store.flash_mut().cut_in(word, Cut::After);
            let said = store.store_counter(2);
            store = power_cycled(store);
            prepare(&mut store);
            let believed = store.read_counter();
            assert!(said.is_err() || believed == 2);
            let mut flash = store.into_flash();
            flash.bytes_mut()[begin + bit / 8] ^= 1 << (bit % 8);
            fallen += u32::from(open(flash).read_counter() < believed);
        }
    }
    assert_eq!(fallen, 0, "times that a counter that was read at power-up fell");
}

fn chosen(store: &mut SmallStore) -> Option<StoredModel> {
    match store.restore(None).unwrap().outcome {
        Outcome::Chosen { model, .. } => Some(model),
        _ => None,
    }
}

/// A model that was cut off in one of its last bits reads whole at times: either it flies, or the one before
/// it does.
#[test]
fn a_torn_model_that_flickers_does_not_hide_the_whole_one_before_it() {
    let (mut cases, mut hidden) = (0, 0);
    for seed in 0..200 {
        let mut dice = Dice::new(seed);
        let mut store = open(Small::new(3, seed));
        prepare(&mut store);
        let older = dice.model(2, 1, 1);
        store.store_model(&older).unwrap();
        // In every second history the older one stands in a full sector, which is erased next.
        for counter in 1..=u64::from(dice.below(2)) * COUNTERS_OF_A_SECTOR {
            store.store_counter(counter).unwrap();
        }
        let newer = dice.model(2, 1, 2);
        let words = {
            let mut whole = store.clone();
            let before = whole.flash_mut().operations();
            whole.store_model(&newer).unwrap();
            whole.flash_mut().operations() - before
        };
        store.flash_mut().cut_in(words - 1 - u64::from(dice.below(8)), Cut::After);
        let _ = store.store_model(&newer);
        store = with_marginal_bit(store, &mut dice);
        for _ in 0..8 {
            prepare(&mut store);
            let model = chosen(&mut store);
            cases += 1;
            hidden += u32::from(model != Some(older) && model != Some(newer));
            store = power_cycled(store);
        }
    }
    println!("{cases} power-ups; in {hidden} no model flew");
    assert_eq!(hidden, 0);
}

/// The error correction gives up on words that a cut tore; the storage goes on, and what was completed is
/// there.
#[test]
fn words_that_cannot_be_read_are_damage_and_not_an_end() {
    let (mut cut_off, mut unusable, mut lost) = (0, 0, 0);
    for seed in 0..400 {
        let mut dice = Dice::new(seed);
        let mut flash = Small::new(3, seed);
        flash.correct_errors();
        let mut store = open(flash);
        prepare(&mut store);
        let (mut newest, mut counter) = ([None; 2], 0);
        for t_us in 0..200 {
            if t_us > 20 && dice.below(12) == 0 {
                store.flash_mut().cut_in(u64::from(dice.below(300)), Cut::Torn);
            }
            let band = dice.below(2) as usize;
            let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
            let model = dice.model(effects, band, t_us);
            let is_stored = store.store_model(&model).is_ok();
            let is_counted = dice.below(3) == 0 && store.store_counter(counter + 1).is_ok();
            if !is_stored {
                while let Ok(Preparation::More) = store.prepare(NotDrilling::PowerUp) {}
            }
            if is_stored {
                newest[band] = Some(model);
            }
            counter += u64::from(is_counted);
            if store.flash_mut().is_on() {
                continue;
            }
            cut_off += 1;
            let mut flash = store.clone().into_flash();
            flash.power_up();
            let Ok(reopened) = ModelStore::open(flash, limits()) else {
                unusable += 1;
                break;
            };
            store = reopened;
            let mut prepared = 0;
            while store.prepare(NotDrilling::PowerUp).unwrap() == Preparation::More {
                prepared += 1;
                assert!(prepared < 12, "it does not come to an end");
            }
            // A counter that was cut off after its first copy may count.
            lost += u32::from(store.read_counter() < counter);
            counter = store.read_counter();
            let there = |newest: &Option<StoredModel>| newest.is_none() || chosen(&mut store.clone()).is_some();
            lost += u32::from(!newest.iter().all(there));
        }
    }
    println!("{cut_off} cuts; {unusable} times the storage could not be opened, {lost} times something was lost");
    assert!(cut_off > 400);
    assert_eq!((unusable, lost), (0, 0));
}

/// A flash of which nothing at all can be read is a flash that fails, and nothing of it is erased.
#[test]
fn a_flash_that_gives_nothing_is_refused() {
    let mut flash = Chip::new(3, 1);
    flash.cut_in(0, Cut::Before);
    let mut store = open(flash);
    assert!(store.prepare(NotDrilling::PowerUp).is_err());
    assert!(ModelStore::<_, 3>::open(store.into_flash(), limits()).is_err());
}
