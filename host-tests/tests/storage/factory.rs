use super::models::{Chip, Dice};
use meerkat_mwd::storage::{
    FactoryKey, FactoryRecord, FactoryRecords, KEY_BYTES, Mounting, Provisioning, StorageError,
};
use mwd::power_cuts::factory_records::{calibration, cut_everywhere, held, records};

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
    let left = cut_everywhere();
    assert_eq!((left.starts().lost, &left.first), (0, &None));
    assert_eq!(left.actions, 3);
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
