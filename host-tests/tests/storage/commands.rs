//! Settings of commands: there after every power cut, and after whatever else is stored.

use super::models::{Dice, prepare};
use meerkat_mwd::{
    config::SurveyConfig,
    storage::StorageError,
    telemetry::{Command, MAX_PAYLOAD, encode_payload},
};
use mwd::power_cuts::{
    doses::blank,
    models::{SmallStore, powered_up},
    settings::{BOTH, cut_everywhere, drawn, longest_configuration, read},
};

#[test]
fn what_was_set_last_outlives_models_counters_and_erasures() {
    let (mut store, mut dice) = (blank(), Dice::new(8));
    let mut set = [None, None];
    assert_eq!(read(&mut store), set);
    for round in 1..600_u64 {
        if round % 7 == 0 {
            let (which, bytes) = (dice.below(2) as usize, drawn(&mut dice));
            if store.store_command(BOTH[which], &bytes) == Err(StorageError::Full) {
                prepare(&mut store);
                store.store_command(BOTH[which], &bytes).unwrap();
            }
            set[which] = Some(bytes);
        }
        if round % 50 == 0 {
            store.store_command(BOTH[1], &[]).unwrap_or_else(|_| {
                prepare(&mut store);
                store.store_command(BOTH[1], &[]).unwrap();
            });
            set[1] = Some(vec![]);
        }
        assert_eq!(read(&mut store), set, "round {round}");
        let model = dice.model(3, (round % 4) as usize, round);
        if store.store_model(&model).is_err() || store.store_counter(round).is_err() {
            prepare(&mut store);
        }
        if dice.below(10) == 0 {
            store = powered_up(store);
            assert_eq!(read(&mut store), set, "round {round}");
            prepare(&mut store);
        }
    }
    let erased = store.erases();
    println!("erasures {erased:?}");
    assert!(erased.iter().sum::<u32>() > 20);
    assert_eq!(read(&mut powered_up(store)), set);
}

#[test]
fn of_two_commands_the_later_has_the_higher_number_whatever_was_copied() {
    let (mut store, mut dice) = (blank(), Dice::new(9));
    for round in 1..200_u64 {
        let later = dice.below(2) as usize;
        for which in [1 - later, later] {
            let bytes = drawn(&mut dice);
            if store.store_command(BOTH[which], &bytes).is_err() {
                prepare(&mut store);
                store.store_command(BOTH[which], &bytes).unwrap();
            }
        }
        let _ = store.store_counter(round);
        store = powered_up(store);
        prepare(&mut store);
        let numbers = BOTH.map(|command| store.read_command(command).map(|(number, _)| number));
        assert!(numbers[later] > numbers[1 - later], "round {round}: {numbers:?}");
    }
}

#[test]
fn a_cut_at_any_word_leaves_the_command_before_or_the_new_one() {
    let left = cut_everywhere();
    assert_eq!((left.starts().lost, &left.first), (0, &None));
    assert!(left.actions == 3 && left.operations > 50, "{} words", left.operations);
}

/// The room that docs/security.md states.
#[test]
fn a_stored_configuration_takes_448_bytes_and_a_counter_64() {
    let (mut store, mut buffer) = (blank(), [0; MAX_PAYLOAD]);
    let bytes = encode_payload(&Command::Configure(longest_configuration()), &mut buffer).unwrap();
    let mut took = |change: &dyn Fn(&mut SmallStore)| {
        let before = store.flash_mut().operations();
        change(&mut store);
        4 * (store.flash_mut().operations() - before)
    };
    assert_eq!(took(&|store| store.store_command(BOTH[0], bytes).unwrap()), 448);
    assert_eq!(took(&|store| store.store_counter(1).unwrap()), 64);
}

/// The bytes of a stored command are read by a later firmware, too. Where this fails the layout of the configuration
/// has changed: raise `COMMANDS` in `src/storage/record.rs`, and put the new digest here.
#[test]
fn the_layout_of_a_stored_configuration_is_that_of_its_version() {
    let config = longest_configuration();
    let digest = |command: &Command| {
        let mut buffer = [0; MAX_PAYLOAD];
        let bytes = encode_payload(command, &mut buffer).unwrap();
        let fnv = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3);
        (bytes.len(), bytes.iter().fold(0xCBF2_9CE4_8422_2325, fnv))
    };
    let found = [digest(&Command::Configure(config)), digest(&Command::ConfigureSurvey(SurveyConfig::default()))];
    assert_eq!(found, [(418, 0x3110_97E1_9352_5045), (108, 0x3A2A_8E25_665B_4CBA)]);
}
