use super::models::{Chip, Dice};
use meerkat_mwd::{
    compensation::VectorModel,
    storage::{
        FactoryCalibration, FactoryKey, FactoryRecord, FactoryRecords, KEY_BYTES, Mounting, Provisioning, StorageError,
    },
};
use mock_flash::CUTS;

fn calibration(dice: &mut Dice) -> FactoryCalibration {
    let gyro = dice.model(0, 0, 0).gyro;
    let mut vector =
        |size| VectorModel { matrix: dice.model(0, 0, 0).gyro.p, offset: [(); 3].map(|()| dice.within(size)) };
    let (accel, mag) = (vector(0.5), vector(40.0));
    FactoryCalibration { gyro, accel, mag, serial_number: dice.below(u32::MAX) }
}

/// All records of a probe, in the order in which they are written.
fn records(dice: &mut Dice) -> [FactoryRecord; 3] {
    let mounting = Mounting { toolface_offset_rad: dice.within(6.0) };
    let key = core::array::from_fn(|k| (7 * k) as u8 ^ dice.below(8) as u8);
    [
        FactoryRecord::Calibration(calibration(dice)),
        FactoryRecord::Mounting(mounting),
        FactoryRecord::Key(FactoryKey(key)),
    ]
}

fn held(records: &FactoryRecords, like: &[FactoryRecord; 3]) -> [Option<FactoryRecord>; 3] {
    like.map(|record| records.of_kind(&record))
}

#[test]
fn what_the_factory_wrote_is_read_and_never_written_over() {
    let mut dice = Dice::new(31);
    let (first, second) = (records(&mut dice), records(&mut dice));
    let mut provisioning = Provisioning::new(Chip::new(1, 0));
    let weak = FactoryRecord::Key(FactoryKey([0xA5; KEY_BYTES]));
    assert_eq!(provisioning.write(&weak), Err(StorageError::WeakKey));
    for (record, other) in first.iter().zip(&second) {
        assert_eq!(provisioning.check(record), Err(StorageError::NotProvisioned));
        assert_eq!(provisioning.write(record), Ok(()));
        assert_eq!(provisioning.write(record), Ok(()), "the same again is no error");
        assert_eq!(provisioning.write(other), Err(StorageError::AlreadyProvisioned));
        assert_eq!(provisioning.check(record), Ok(()));
        assert_eq!(provisioning.check(other), Err(StorageError::AlreadyProvisioned));
    }
    let mut region = provisioning.into_region();
    let read = FactoryRecords::read(&mut region).unwrap();
    assert_eq!((held(&read, &first), read.damaged, read.unknown), (first.map(Some), 0, 0));
    assert_eq!(region.erases(), [0], "nothing erases it");
}

#[test]
fn with_the_key_a_probe_is_closed() {
    let [calibration, mounting, key] = records(&mut Dice::new(34));
    let mut provisioning = Provisioning::new(Chip::new(1, 0));
    provisioning.write(&key).unwrap();
    for record in [calibration, mounting] {
        assert_eq!(provisioning.write(&record), Err(StorageError::AlreadyProvisioned));
        assert_eq!(provisioning.check(&record), Err(StorageError::AlreadyProvisioned), "it cannot be written any more");
    }
}

#[test]
fn a_region_that_is_blank_has_neither_calibration_nor_key() {
    let read = FactoryRecords::read(&mut Chip::new(1, 0)).unwrap();
    assert_eq!((read.calibration, read.mounting, read.key, read.damaged), (None, None, None, 0));
}

/// At every word of all three records the power goes, in each way.
#[test]
fn a_factory_that_loses_power_repeats_all_and_a_rotten_record_is_not_believed() {
    let mut dice = Dice::new(32);
    let all = records(&mut dice);
    let mut whole = Provisioning::new(Chip::new(1, 0));
    all.iter().for_each(|record| whole.write(record).unwrap());
    let words = whole.into_region().operations();
    for operation in 0..words {
        for cut in CUTS {
            let mut region = Chip::new(1, operation);
            region.cut_in(operation, cut);
            let mut provisioning = Provisioning::new(region);
            let said = all.map(|record| provisioning.write(&record).is_ok());
            let mut region = provisioning.into_region();
            region.power_up();
            let read = held(&FactoryRecords::read(&mut region).unwrap(), &all);
            for ((said, read), record) in said.iter().zip(read).zip(all) {
                assert!(*said <= read.is_some() && read.is_none_or(|read| read == record));
            }
            let mut provisioning = Provisioning::new(region);
            assert!(all.iter().all(|record| provisioning.write(record).is_ok()), "{operation} {cut:?}");
            let mut region = provisioning.into_region();
            assert_eq!(held(&FactoryRecords::read(&mut region).unwrap(), &all), all.map(Some));
            // A record that has rotted is not read as something else.
            let bit = dice.below(8 * 160) as usize;
            region.bytes_mut().iter_mut().skip(bit / 8).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
            let rotten = held(&FactoryRecords::read(&mut region).unwrap(), &all);
            assert!(rotten.iter().zip(all).all(|(rotten, record)| rotten.is_none_or(|rotten| rotten == record)));
        }
    }
    println!("{} power cuts of a provisioning", 3 * words);
}

#[test]
fn a_record_that_is_none_is_not_written() {
    let mut bad = calibration(&mut Dice::new(33));
    bad.mag.matrix = [[0.0; 3]; 3];
    let mut provisioning = Provisioning::new(Chip::new(1, 0));
    let mounting = Mounting { toolface_offset_rad: f32::NAN };
    for record in [FactoryRecord::Calibration(bad), FactoryRecord::Mounting(mounting)] {
        assert!(matches!(provisioning.write(&record), Err(StorageError::Implausible(_))));
    }
    assert_eq!(provisioning.into_region().operations(), 0);
}
