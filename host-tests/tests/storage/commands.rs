//! Settings of commands: there after every power cut, and after whatever else is stored.

use super::models::{Dice, KIB, Store, open, prepare};
use meerkat_mwd::{
    Config,
    compensation::VectorModel,
    config::{FullScale, Latency, SurveyConfig},
    storage::{StorageError, StoredCommand},
    telemetry::{Command, MAX_PAYLOAD, encode_payload},
};
use mock_flash::{CUTS, MockFlash};
use rand_core::Rng;

type SmallStore = Store<4, { 8 * KIB }>;

const BOTH: [StoredCommand; 2] = [StoredCommand::Configure, StoredCommand::ConfigureSurvey];

fn blank() -> SmallStore {
    let mut store = open(MockFlash::new(3, 17));
    prepare(&mut store);
    store
}

fn powered_up(store: SmallStore) -> SmallStore {
    let mut flash = store.into_flash();
    flash.power_up();
    open(flash)
}

/// Bytes of any length that a command may have.
fn drawn(dice: &mut Dice) -> Vec<u8> {
    let length = 1 + dice.below(560);
    (0..length).map(|_| dice.0.next_u32() as u8).collect()
}

fn read(store: &mut SmallStore) -> [Option<Vec<u8>>; 2] {
    BOTH.map(|command| store.read_command(command).map(|(_, bytes)| bytes.to_vec()))
}

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
    let mut dice = Dice::new(10);
    let mut cuts = 0;
    for before in [0, 1, 30] {
        let mut store = blank();
        let mut last = None;
        for _ in 0..before {
            let bytes = drawn(&mut dice);
            if store.store_command(BOTH[0], &bytes).is_err() {
                prepare(&mut store);
                store.store_command(BOTH[0], &bytes).unwrap();
            }
            last = Some(bytes);
        }
        prepare(&mut store);
        let (start, new) = (store.into_flash(), drawn(&mut dice));
        let changed = |flash: MockFlash<4, { 8 * KIB }>| {
            let mut store = open(flash);
            let kept = store.store_command(BOTH[0], &new).is_ok();
            (store, kept)
        };
        let words = changed(start.clone()).0.into_flash().operations() - start.operations();
        for operation in 0..words {
            for cut in CUTS {
                let mut flash = start.clone();
                flash.cut_in(operation, cut);
                let (store, kept) = changed(flash);
                let mut store = powered_up(store);
                let [found, _] = read(&mut store);
                assert!(found.as_ref() == Some(&new) || (!kept && found == last), "{before} {operation} {cut:?}");
                prepare(&mut store);
                let [after, _] = read(&mut store);
                assert!(after == found || after == last, "{before} {operation} {cut:?}");
                cuts += 1;
            }
        }
    }
    println!("{cuts} power cuts while a command is stored");
}

/// The bytes of a stored command are read by a later firmware, too. Where this fails the layout of the configuration
/// has changed: raise `COMMANDS` in `src/storage/record.rs`, and put the new digest here.
#[test]
fn the_layout_of_a_stored_configuration_is_that_of_its_version() {
    let vector =
        VectorModel { matrix: [[1.5, 0.25, 0.0], [0.0, 1.25, 0.0], [0.5, 0.0, 2.0]], offset: [0.5, -0.25, 0.125] };
    let mut config = Config {
        accel: vector,
        mag: vector,
        full_scale: FullScale { gyro_rad_s: Some(8.0), accel_m_s2: Some(64.0), mag_ut: Some(512.0) },
        latency: Latency { gyro_s: Some(0.25), accel_s: Some(0.5), mag_s: Some(0.125) },
        ..Config::default()
    };
    config.earth.latitude_rad = Some(0.5);
    config.earth.declination_rad = Some(0.25);
    let digest = |command: &Command| {
        let mut buffer = [0; MAX_PAYLOAD];
        let bytes = encode_payload(command, &mut buffer).unwrap();
        let fnv = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3);
        (bytes.len(), bytes.iter().fold(0xCBF2_9CE4_8422_2325, fnv))
    };
    let found = [digest(&Command::Configure(config)), digest(&Command::ConfigureSurvey(SurveyConfig::default()))];
    assert_eq!(found, [(418, 0x3110_97E1_9352_5045), (108, 0x3A2A_8E25_665B_4CBA)]);
}
