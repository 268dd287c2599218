//! The written record is a configuration; the JSON's fields are those of its page.

use std::collections::BTreeSet;

use meerkat_mwd::{compensation::VectorModel, config::VectorErrors};
use mwd::calibrate::{calibrate, record, result};
use testbed::flight::configuration::of_file;

use crate::{
    rig::json_fields::{fields, part},
    turntable::{Probe, Random, all_around},
};

#[test]
fn the_record_comes_back_to_the_last_bit() {
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let probe = Probe::drawn(&mut random);
        let attitudes = all_around(24, &mut random);
        let trace = probe.turned(&attitudes, &mut random);
        let found = calibrate(std::slice::from_ref(&trace), None, None).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("factory.toml");
        record::write(&found, &file).unwrap();
        let config = of_file(&trace, Some(&file)).unwrap();
        assert_eq!((config.accel, config.mag), (found.accel_model(), found.mag_model()));
        assert!(config.accel != VectorModel::IDENTITY && config.mag != VectorModel::IDENTITY);
        let (left, sheet) = (config.identification.vector_errors, VectorErrors::default());
        let pairs = [
            (left.accel_matrix, sheet.accel_matrix),
            (left.accel_bias_m_s2, sheet.accel_bias_m_s2),
            (left.mag_matrix, sheet.mag_matrix),
            (left.hard_iron, sheet.hard_iron),
        ];
        assert!(pairs.iter().all(|(left, sheet)| left < sheet), "a calibration says less than a data sheet: {left:?}");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("1-sigma") && text.contains("held out"), "{text}");

        // Calibrated on top of itself, held-out readings do not improve by more than stated.
        let again = calibrate(&[trace], Some(&file), None).unwrap();
        let (old, new) = (config.accel, again.accel_model());
        let near = |axis: usize| (old.offset[axis] - new.offset[axis]).abs() < 1e-3;
        assert!((0..3).all(near), "{old:?} {new:?}");
    }
}

#[test]
fn a_sensor_without_new_values_keeps_those_of_the_old_record() {
    let mut random = Random::new(20);
    let mut probe = Probe::drawn(&mut random);
    probe.has_mag = false;
    let attitudes = all_around(24, &mut random);
    let trace = probe.turned(&attitudes, &mut random);
    let directory = tempfile::tempdir().unwrap();
    let (old, new) = (directory.path().join("old.toml"), directory.path().join("new.toml"));
    let left = "[identification.vector_errors]\nhard_iron = 0.07\n";
    let mag = "[mag]\nmatrix = [[1.1, 0, 0], [0, 1, 0], [0, 0, 1]]\noffset = [5.5, 0, 0]\n";
    std::fs::write(&old, [mag, left].concat()).unwrap();
    let found = calibrate(std::slice::from_ref(&trace), Some(&old), None).unwrap();
    record::write(&found, &new).unwrap();
    let config = of_file(&trace, Some(&new)).unwrap();
    assert_eq!(config.mag.offset, [5.5, 0.0, 0.0]);
    assert_eq!(config.identification.vector_errors.hard_iron, 0.07);
    assert_eq!(config.accel, found.accel_model());
}

/// `docs/json.md` names every field of the result, and no field that there is not.
#[test]
fn every_field_of_the_json_is_documented_and_no_other() {
    let mut random = Random::new(30);
    let probe = Probe::drawn(&mut random);
    let trace = probe.turned(&all_around(60, &mut random), &mut random);
    let found = calibrate(&[trace], None, Some(0.3)).unwrap();
    assert!(found.alignment.is_some() && found.later.is_some() && found.mag_later.is_some());
    let mut told = BTreeSet::new();
    fields(&result::value(&found), "", &mut told);
    assert_eq!(told, part("The JSON of a calibration"));
}
