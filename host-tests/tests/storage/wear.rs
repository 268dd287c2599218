use super::models::{Chip, Dice, KIB, Store, TEMPERATURES_C, open, prepare};
use meerkat_mwd::{
    compensation::MAX_ACTIVE,
    storage::{Outcome, StorageError},
};

fn spread(wear: &[u64]) -> f64 {
    let mean = wear.iter().sum::<u64>() as f64 / wear.len() as f64;
    *wear.iter().max().unwrap() as f64 / mean
}

/// Prepared as soon as it is full, with power-ups at random, on the chip's sectors.
#[test]
fn ten_thousand_updates_wear_no_sector_more_than_half_as_much_again_as_the_mean() {
    for seed in [1, 2, 3] {
        let mut dice = Dice::new(seed);
        let mut store: Store<4, { 16 * KIB }> = open(Chip::new(3, seed));
        prepare(&mut store);
        let mut most_erased = 0;
        for update in 1..=10_000_u32 {
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
            let model = dice.model(effects, band, u64::from(update));
            if store.store_model(&model) == Err(StorageError::Full) {
                most_erased = most_erased.max(prepare(&mut store));
                store.store_model(&model).unwrap();
            }
            if dice.below(50) == 0 {
                store = open(store.into_flash());
                most_erased = most_erased.max(prepare(&mut store));
            }
            if update % 100 == 0 {
                store.store_counter(u64::from(update)).unwrap();
            }
            if update % 97 == 0 {
                let outcome = store.restore(None).unwrap().outcome;
                assert!(matches!(outcome, Outcome::Chosen { model: found, .. } if found == model));
            }
        }
        let marked = store.erases();
        let flash = store.into_flash();
        let erases: Vec<u64> = flash.erases().iter().map(|erases| u64::from(*erases)).collect();
        assert_eq!(flash.erases(), marked, "the marks know");
        println!(
            "seed {seed}: 10,000 updates; erasures {erases:?}, {:.3} x the mean; words {:?}, {:.3} x; at most {most_erased} erased at once",
            spread(&erases),
            flash.words(),
            spread(flash.words()),
        );
        assert!(spread(&erases) < 1.5 && spread(flash.words()) < 1.5);
        // Guaranteed are 10,000 (DS8626, endurance).
        assert!(erases.iter().all(|erases| *erases < 500));
        assert!(most_erased <= 2, "after a rollover one or two");
    }
}
