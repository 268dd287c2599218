//! Cuts while the factory writes its three records.

use super::{
    Found, Left,
    drawn::{Chip, Dice},
    everywhere, itself,
};
use meerkat_mwd::{
    compensation::VectorModel,
    storage::{FactoryCalibration, FactoryKey, FactoryRecord, FactoryRecords, Mounting, Provisioning},
};

/// A calibration that could be.
pub fn calibration(dice: &mut Dice) -> FactoryCalibration {
    let gyro = dice.model(0, 0, 0).gyro;
    let mut vector =
        |size| VectorModel { matrix: dice.model(0, 0, 0).gyro.p, offset: [(); 3].map(|()| dice.within(size)) };
    let (accel, mag) = (vector(0.5), vector(40.0));
    FactoryCalibration { gyro, accel, mag, serial_number: dice.below(u32::MAX) }
}

/// All records of a probe, in the order in which they are written.
pub fn records(dice: &mut Dice) -> [FactoryRecord; 3] {
    let mounting = Mounting { toolface_offset_rad: dice.within(6.0) };
    let key = core::array::from_fn(|k| (7 * k) as u8 ^ dice.below(8) as u8);
    [
        FactoryRecord::Calibration(calibration(dice)),
        FactoryRecord::Mounting(mounting),
        FactoryRecord::Key(FactoryKey(key)),
    ]
}

/// Those of these records that a region holds.
#[must_use]
pub fn held(records: &FactoryRecords, like: &[FactoryRecord; 3]) -> [Option<FactoryRecord>; 3] {
    like.map(|record| records.of_kind(&record))
}

/// Cuts the writing of each of the three records everywhere. After each cut the factory repeats all, and one bit of
/// what it wrote rots: then no record may be read as something else.
#[must_use]
pub fn cut_everywhere() -> Left {
    let mut dice = Dice::new(32);
    let all = records(&mut dice);
    let (mut left, mut region) = (Left::default(), Chip::new(1, 0));
    for (place, record) in all.iter().enumerate() {
        let act = |region: &mut Chip| write(region, std::slice::from_ref(record));
        let found = |mut region: Chip| {
            region.power_up();
            let read = held(&FactoryRecords::read(&mut region).unwrap(), &all);
            let is_repeated = write(&mut region, &all);
            let repeated = held(&FactoryRecords::read(&mut region).unwrap(), &all);
            let bit = dice.below(8 * 160) as usize;
            region.bytes_mut()[bit / 8] ^= 1 << (bit % 8);
            let rotten = held(&FactoryRecords::read(&mut region).unwrap(), &all);
            let is_not_another =
                rotten.iter().zip(all).all(|(rotten, record)| rotten.is_none_or(|rotten| rotten == record));
            let there = |records: usize| std::array::from_fn(|k| (k < records).then_some(all[k]));
            match read {
                _ if !is_repeated || repeated != there(3) || !is_not_another => Found::Neither,
                read if read == there(place + 1) => Found::New,
                read if read == there(place) => Found::Old,
                _ => Found::Neither,
            }
        };
        region = everywhere(&mut left, &region, itself, act, found);
    }
    left
}

/// Writes records; true if all were.
fn write(region: &mut Chip, records: &[FactoryRecord]) -> bool {
    let mut provisioning = Provisioning::new(region.clone());
    let are_written = records.iter().all(|record| provisioning.write(record).is_ok());
    *region = provisioning.into_region();
    are_written
}
