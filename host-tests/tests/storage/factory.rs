use super::models::{Chip, Dice};
use meerkat_mwd::{
    compensation::VectorModel,
    storage::{FactoryCalibration, FactoryRecords, KEY_BYTES, Provisioning, StorageError},
};
use mwd::target::mock_flash::CUTS;

fn calibration(dice: &mut Dice) -> FactoryCalibration {
    let gyro = dice.model(0, 0, 0).gyro;
    let mut vector =
        |size| VectorModel { matrix: dice.model(0, 0, 0).gyro.p, offset: [(); 3].map(|()| dice.within(size)) };
    let (accel, mag) = (vector(0.5), vector(40.0));
    FactoryCalibration { gyro, accel, mag, serial_number: dice.below(u32::MAX) }
}

#[test]
fn what_the_factory_wrote_is_read_and_never_written_over() {
    let mut dice = Dice::new(31);
    let (first, second) = (calibration(&mut dice), calibration(&mut dice));
    let (key, other): ([u8; KEY_BYTES], [u8; KEY_BYTES]) =
        (core::array::from_fn(|k| k as u8), core::array::from_fn(|k| 3 * k as u8));
    let mut provisioning = Provisioning::new(Chip::new(1, 0));
    provisioning.write_calibration(&first).unwrap();
    assert_eq!(provisioning.write_calibration(&second), Err(StorageError::AlreadyProvisioned));
    assert_eq!(provisioning.write_calibration(&first), Err(StorageError::AlreadyProvisioned));
    assert_eq!(provisioning.write_key(&[0xA5; KEY_BYTES]), Err(StorageError::WeakKey));
    provisioning.write_key(&key).unwrap();
    assert_eq!(provisioning.write_key(&other), Err(StorageError::AlreadyProvisioned));
    let mut region = provisioning.into_region();
    let records = FactoryRecords::read(&mut region).unwrap();
    assert_eq!((records.calibration, records.key, records.damaged, records.unknown), (Some(first), Some(key), 0, 0));
    assert_eq!(region.erases(), [0], "nothing erases it");
}

#[test]
fn a_region_that_is_blank_has_neither_calibration_nor_key() {
    let records = FactoryRecords::read(&mut Chip::new(1, 0)).unwrap();
    assert_eq!((records.calibration, records.key, records.damaged), (None, None, 0));
}

#[test]
fn a_factory_that_loses_power_can_try_again_and_a_rotten_record_is_not_believed() {
    let mut dice = Dice::new(32);
    let first = calibration(&mut dice);
    for operation in 0..48 {
        for cut in CUTS {
            let mut region = Chip::new(1, operation);
            region.cut_in(operation, cut);
            let mut provisioning = Provisioning::new(region);
            let said = provisioning.write_calibration(&first);
            let mut region = provisioning.into_region();
            region.power_up();
            let held = FactoryRecords::read(&mut region).unwrap().calibration;
            assert!(said.is_ok() <= held.is_some() && held.is_none_or(|held| held == first));
            let mut provisioning = Provisioning::new(region);
            let again = provisioning.write_calibration(&first);
            assert_eq!(again.is_ok(), held.is_none());
            let mut region = provisioning.into_region();
            assert_eq!(FactoryRecords::read(&mut region).unwrap().calibration, Some(first));
            // What has rotted is not read as something else.
            let bit = dice.below(8 * 160) as usize;
            region.bytes_mut().iter_mut().skip(bit / 8).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
            let rotten = FactoryRecords::read(&mut region).unwrap().calibration;
            assert!(rotten.is_none_or(|rotten| rotten == first));
        }
    }
}

#[test]
fn a_calibration_that_is_none_is_not_written() {
    let mut bad = calibration(&mut Dice::new(33));
    bad.mag.matrix = [[0.0; 3]; 3];
    let mut provisioning = Provisioning::new(Chip::new(1, 0));
    assert!(matches!(provisioning.write_calibration(&bad), Err(StorageError::Implausible(_))));
    assert_eq!(provisioning.into_region().operations(), 0);
}
