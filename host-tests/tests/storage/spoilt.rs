//! Flash that does not hold what was written, or holds what nobody should fly.

use super::models::{Chip, Dice, KIB, Store, TEMPERATURES_C, limits, open, prepare};
use meerkat_mwd::{
    Config,
    compensation::{ActiveEffects, Effect, FoundEffect, GyroModel, MAX_ACTIVE, effects::LIBRARY},
    storage::{Implausible, Limits, ModelStore, NotDrilling, Outcome, StorageError, StoredModel},
};
use mock_flash::MockFlash;
use rand_core::Rng;

type ChipStore = Store<4, { 16 * KIB }>;

fn prepared(seed: u64) -> ChipStore {
    let mut store = open(Chip::new(3, seed));
    prepare(&mut store);
    store
}

fn chosen(store: &mut ChipStore, t: Option<f32>) -> Option<StoredModel> {
    match store.restore(t).unwrap().outcome {
        Outcome::Chosen { model, .. } => Some(model),
        _ => None,
    }
}

/// Every byte of the newest record is spoilt in turn: the one before it is chosen, and the loss is counted.
#[test]
fn a_rotten_record_is_skipped_and_counted() {
    let mut dice = Dice::new(41);
    let mut store = prepared(1);
    let older = dice.model(3, 1, 1);
    store.store_model(&older).unwrap();
    let before = store.clone().into_flash().bytes_mut().to_vec();
    let newer = dice.model(3, 1, 2);
    store.store_model(&newer).unwrap();
    let after = store.clone().into_flash().bytes_mut().to_vec();
    let written: Vec<usize> = (0..after.len()).filter(|i| before[*i] != after[*i]).collect();
    assert!(written.len() > 150);
    let record = written[0]..=*written.last().unwrap();
    for at in record {
        let mut flash = store.clone().into_flash();
        // The padding at the end counts for nothing; every byte before it does.
        flash.bytes_mut()[at] ^= 1 << dice.below(8);
        let mut spoilt = open(flash);
        assert_eq!(chosen(&mut spoilt, None), Some(older), "byte {at}");
        assert_eq!((spoilt.scan_counts().damaged, spoilt.scan_counts().records), (1, 1), "byte {at}");
        // And it goes on.
        assert!(spoilt.store_model(&newer).is_ok());
        assert_eq!(chosen(&mut open(spoilt.into_flash()), None), Some(newer));
    }
}

#[test]
fn one_of_the_counters_two_copies_may_rot() {
    let mut dice = Dice::new(42);
    for _ in 0..200 {
        let mut store = prepared(1);
        store.store_counter(1 + u64::from(dice.0.next_u32())).unwrap();
        let before = store.clone().into_flash().bytes_mut().to_vec();
        let counter = store.read_counter() + 1 + u64::from(dice.0.next_u32());
        store.store_counter(counter).unwrap();
        let mut flash = store.into_flash();
        let written: Vec<usize> = (0..before.len()).filter(|i| before[*i] != flash.bytes_mut()[*i]).collect();
        let at = written[dice.below(written.len() as u32) as usize];
        flash.bytes_mut()[at] ^= 1 << dice.below(8);
        assert_eq!(open(flash).read_counter(), counter);
    }
}

#[test]
fn a_model_that_may_not_fly_is_refused_with_its_reason_when_it_is_written() {
    let mut dice = Dice::new(43);
    let good = dice.model(2, 0, 0);
    let mut store = prepared(1);
    let mut refused = 0;
    let mut reason = |spoil: &dyn Fn(&mut StoredModel)| {
        let mut model = good;
        spoil(&mut model);
        refused += 1;
        let before = store.flash_mut().operations();
        let said = store.store_model(&model);
        assert_eq!((store.flash_mut().operations(), store.counts().refused_implausible), (before, refused));
        match said {
            Err(StorageError::Implausible(reason)) => reason,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(reason(&|m| m.gyro.p[1][2] = f32::NAN), Implausible::NotAModel);
    assert_eq!(reason(&|m| m.gyro.b_rad_s[0] = f32::INFINITY), Implausible::NotAModel);
    assert_eq!(reason(&|m| m.gyro.p = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), Implausible::NotAModel);
    assert!(matches!(reason(&|m| m.gyro.p[2][2] = 1.31), Implausible::P { row: 2, column: 2, .. }));
    assert!(matches!(reason(&|m| m.gyro.p[0][1] = -0.16), Implausible::P { row: 0, column: 1, .. }));
    assert!(matches!(reason(&|m| m.gyro.b_rad_s[2] = 0.2), Implausible::Bias { axis: 2, .. }));
    assert_eq!(reason(&|m| m.sigma[7] = -1e-9), Implausible::Sigma { index: 7 });
    assert_eq!(reason(&|m| m.sigma[11] = f32::NAN), Implausible::Sigma { index: 11 });
    // A deviation beyond what the element may be off by (0.3 on P's diagonal, 0.15 off it) tells nothing of it.
    assert_eq!(reason(&|m| m.sigma[0] = 0.31), Implausible::Sigma { index: 0 });
    assert_eq!(reason(&|m| m.sigma[9] = f32::INFINITY), Implausible::Sigma { index: 9 });
    assert_eq!(reason(&|m| m.temperature_c = Some([30.0, 20.0])), Implausible::Temperature);
    assert_eq!(reason(&|m| m.temperature_c = Some([30.0, 2000.0])), Implausible::Temperature);
    assert_eq!(reason(&|m| m.library ^= 1), Implausible::OtherLibrary);
    let index = good.effects.iter().next().unwrap().index;
    assert_eq!(
        reason(&|m| {
            let twice = *good.effects.iter().next().unwrap();
            m.effects.add(twice);
        }),
        Implausible::Effect { index, parameter: None }
    );
    let with_first = |change: fn(&mut FoundEffect)| {
        move |m: &mut StoredModel| {
            let mut effects = ActiveEffects::none();
            for mut found in m.effects.iter().copied() {
                change(&mut found);
                effects.add(found);
            }
            m.effects = effects;
        }
    };
    fn largest(found: &FoundEffect) -> f32 {
        LIBRARY[usize::from(found.index)].parameters()[0].largest
    }
    let of = |parameter: u8| Implausible::Effect { index, parameter: Some(parameter) };
    assert_eq!(reason(&with_first(|found| found.parameters[0] = 1.01 * largest(found))), of(0));
    assert_eq!(reason(&with_first(|found| found.parameters[0] = f32::NAN)), of(0));
    assert_eq!(reason(&with_first(|found| found.sigma[0] = f32::NAN)), of(0));
    assert_eq!(reason(&with_first(|found| found.sigma[0] = -1.0)), of(0));
    // A number for which the effect has no parameter.
    let count = LIBRARY[usize::from(index)].parameters().len();
    if count < 9 {
        assert_eq!(reason(&with_first(|found| found.parameters[8] = 1.0)), of(8));
    }
    assert!(store.store_model(&good).is_ok());
}

/// A probe whose factory model is another one, as after the sensor was changed, does not fly the old
/// sensor's.
#[test]
fn a_model_that_may_not_fly_is_refused_with_its_reason_when_it_is_read() {
    let mut dice = Dice::new(44);
    let mut store = prepared(1);
    store.store_model(&dice.model(0, 2, 5)).unwrap();
    let mut config =
        Config { gyro: GyroModel { b_rad_s: [0.0, 0.2, 0.0], ..GyroModel::IDENTITY }, ..Config::default() };
    let mut other = ModelStore::<_, 3>::open(store.clone().into_flash(), Limits::new(&config, &LIBRARY)).unwrap();
    let restoration = other.restore(None).unwrap();
    assert!(matches!(restoration.outcome, Outcome::Implausible(Implausible::Bias { axis: 1, .. })));
    assert_eq!((restoration.choice, restoration.counts.implausible), (0, 1));
    // And one with effects that this library does not have.
    store.store_model(&dice.model(3, 2, 5)).unwrap();
    static OTHER: [&dyn Effect; 1] = [LIBRARY_FIRST];
    config.gyro = GyroModel::IDENTITY;
    let mut other = ModelStore::<_, 3>::open(store.into_flash(), Limits::new(&config, &OTHER)).unwrap();
    let restoration = other.restore(None).unwrap();
    assert_eq!(restoration.counts.first_implausible.map(|(_, reason)| reason), Some(Implausible::OtherLibrary));
    // The one before it, without effects, flies.
    assert!(matches!(restoration.outcome, Outcome::Chosen { model, .. } if model.effects.is_empty()));
}

const LIBRARY_FIRST: &dyn Effect = &meerkat_mwd::compensation::effects::MagLag;

/// CRC-32C of RFC 3720, written down here once more.
fn check(bytes: impl Iterator<Item = u8>) -> u32 {
    !bytes.fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0x82F6_3B78 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn a_version_from_the_future_is_refused_and_counted() {
    let mut dice = Dice::new(45);
    let mut store = prepared(1);
    let known = dice.model(1, 0, 1);
    store.store_model(&known).unwrap();
    store.store_model(&dice.model(1, 0, 2)).unwrap();
    let mut flash = store.into_flash();
    let bytes = flash.bytes_mut();
    // Sector 0: the mark, then the two records; the documented header is check, magic, kind, version, number,
    // length.
    let models = (0..16 * KIB).step_by(32).filter(|at| bytes[at + 4..].starts_with(&[0x4D, 0x57, 1, 2]));
    let at = models.max().unwrap();
    bytes[at + 7] = 3;
    let length = usize::from(u16::from_le_bytes([bytes[at + 12], bytes[at + 13]]));
    let sum = check(bytes[at + 4..at + 16 + length].iter().copied());
    bytes[at..at + 4].copy_from_slice(&sum.to_le_bytes());
    let mut store = open(flash);
    let counts = store.scan_counts();
    assert_eq!((counts.records, counts.damaged, counts.from_the_future), (2, 0, 1));
    assert_eq!(chosen(&mut store, None), Some(known));
}

/// Noise, noise over a store, and whole records with noise in them.
#[test]
fn whatever_is_in_the_flash_nothing_panics_and_it_can_be_used_again() {
    let mut dice = Dice::new(46);
    for round in 0..400 {
        let mut store = prepared(round);
        for t_us in 0..u64::from(dice.below(150)) {
            let band = dice.below(TEMPERATURES_C.len() as u32) as usize;
            let effects = dice.below(MAX_ACTIVE as u32 + 1) as usize;
            if store.store_model(&dice.model(effects, band, t_us)).is_err() {
                break;
            }
        }
        let mut flash = store.into_flash();
        let bytes = flash.bytes_mut();
        match round % 4 {
            0 => dice.0.fill_bytes(bytes),
            1 => {
                for _ in 0..1 + dice.below(200) {
                    let at = dice.below(bytes.len() as u32) as usize;
                    bytes[at] ^= 1 << dice.below(8);
                }
            }
            2 => {
                let (from, to) = (dice.below(bytes.len() as u32) as usize, dice.below(bytes.len() as u32) as usize);
                dice.0.fill_bytes(&mut bytes[from.min(to)..from.max(to)]);
            }
            // Records that are whole and say anything: any kind, version, number, length and payload.
            _ => {
                let mut at = 32 * dice.below(8) as usize;
                while at + 640 < bytes.len() {
                    let length = dice.below(600) as usize;
                    let record = &mut bytes[at..at + 640];
                    dice.0.fill_bytes(record);
                    record[4..6].copy_from_slice(&[0x4D, 0x57]);
                    record[6] = dice.below(8) as u8;
                    record[7] = dice.below(3) as u8;
                    record[12..14].copy_from_slice(&(length as u16).to_le_bytes());
                    let sum = check(record[4..16 + length].iter().copied());
                    record[..4].copy_from_slice(&sum.to_le_bytes());
                    at += 32 * (1 + dice.below(20) as usize);
                }
            }
        }
        let mut store: ChipStore = open(flash);
        for t in [None, Some(20.0), Some(f32::NAN), Some(f32::NEG_INFINITY), Some(1e30)] {
            if let Outcome::Chosen { model, .. } = store.restore(t).unwrap().outcome {
                assert_eq!(limits().check(&model), Ok(()));
            }
        }
        let counter = store.read_counter();
        for _ in 0..12 {
            store.prepare(NotDrilling::PowerUp).unwrap();
        }
        assert_eq!(store.read_counter(), counter, "round {round}");
        let model = dice.model(4, 0, 1);
        let stored = store.store_model(&model);
        // A number at its end is the only thing that can stop it.
        assert!(stored.is_ok(), "round {round}: {stored:?}");
        let _: MockFlash<4, { 16 * KIB }> = store.into_flash();
    }
}
