//! Input that cannot be calibrated is refused with a reason.

use std::process::{Command, Output};

use meerkat_mwd::{SampleFlags, compensation::VectorModel};
use mwd::calibrate::{Verdict, calibrate};

use crate::turntable::{Probe, Random, all_around};

fn mwd(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mwd")).arg("calibrate").args(arguments).output().unwrap()
}

#[test]
fn without_rests_or_magnetometer_the_reason_is_told_and_no_record_written() {
    let mut random = Random::new(1);
    let mut probe = Probe::drawn(&mut random);
    probe.has_mag = false;
    let attitudes = all_around(24, &mut random);
    let mut trace = probe.turned(&attitudes, &mut random);
    trace.samples.iter_mut().enumerate().for_each(|(k, sample)| sample.gyro_rad_s[0] += (0.3 * k as f32) % 1.0);
    let directory = tempfile::tempdir().unwrap();
    let (path, record, json) =
        (directory.path().join("t.csv"), directory.path().join("r.toml"), directory.path().join("r.json"));
    trace.write(&path).unwrap();
    let output = mwd(&[path.to_str().unwrap(), "-o", record.to_str().unwrap(), "--json", json.to_str().unwrap()]);
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("no rest was found") && told.contains("no readings of a magnetometer"), "{told}");
    assert_eq!(output.status.code(), Some(2), "a record was asked for and there is none");
    assert!(!record.exists());
    let value: serde_json::Value = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
    assert_eq!(value["accel"]["verdict"], "kept");
    assert_eq!(mwd(&[path.to_str().unwrap()]).status.code(), Some(0), "a refusal is an answer");
}

#[test]
fn rests_with_clipped_readings_are_not_used() {
    let mut random = Random::new(2);
    let probe = Probe::drawn(&mut random);
    let attitudes = all_around(24, &mut random);
    let mut trace = probe.turned(&attitudes, &mut random);
    let whole = calibrate(std::slice::from_ref(&trace), None, None).unwrap().accel.unwrap();
    assert_eq!(whole.observations.len(), 24);
    trace.samples[150].accel_m_s2[2] = 19.6;
    let found = calibrate(std::slice::from_ref(&trace), None, None).unwrap();
    assert_eq!(found.accel.unwrap().observations.len(), 23);
    assert!(found.notes.iter().any(|note| note.contains("1 of the accelerometer")), "{:?}", found.notes);
    // A rail somewhere below the full scale that all rests touch.
    trace.samples.iter_mut().step_by(50).for_each(|sample| sample.accel_m_s2[1] = -19.6);
    let found = calibrate(&[trace], None, None).unwrap();
    assert!(found.accel.is_none());
    assert!(found.no_accel().contains("at full scale"), "{}", found.no_accel());
    assert_eq!(found.accel_model(), VectorModel::IDENTITY);
}

#[test]
fn what_is_missing_or_faulty_is_not_read() {
    let mut random = Random::new(3);
    let probe = Probe::drawn(&mut random);
    let attitudes = all_around(24, &mut random);
    let mut trace = probe.turned(&attitudes, &mut random);
    for (k, sample) in trace.samples.iter_mut().enumerate() {
        if k % 7 == 0 {
            sample.flags |= SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
            (sample.accel_m_s2, sample.mag_ut) = ([0.0; 3], [0.0; 3]);
        }
        if k % 11 == 0 {
            sample.flags |= SampleFlags::FAULT;
            (sample.accel_m_s2, sample.mag_ut) = ([1e3; 3], [1e3; 3]);
        }
    }
    let found = calibrate(&[trace], None, None).unwrap();
    assert!(found.accel.unwrap().is_new() && found.mag.unwrap().is_new());
}

#[test]
fn results_do_not_overwrite_what_is_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("t.csv");
    let mut random = Random::new(4);
    let attitudes = all_around(2, &mut random);
    Probe::drawn(&mut random).turned(&attitudes, &mut random).write(&path).unwrap();
    let path = path.to_str().unwrap();
    let output = mwd(&[path, "-o", path]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("overwrite"));
    std::fs::create_dir(directory.path().join("inner")).unwrap();
    let [one, same] = ["r.toml", "inner/../r.toml"].map(|name| directory.path().join(name));
    let output = mwd(&[path, "-o", one.to_str().unwrap(), "--json", same.to_str().unwrap()]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("overwrite another one"));
    assert_eq!(mwd(&[]).status.code(), Some(2), "no trace");
    assert_eq!(mwd(&["none.csv"]).status.code(), Some(2));
}

/// A matrix of a thousandth would fit it.
#[test]
fn a_field_in_nanotesla_is_refused_and_no_record_written() {
    let mut random = Random::new(5);
    let attitudes = all_around(24, &mut random);
    let mut trace = Probe::drawn(&mut random).turned(&attitudes, &mut random);
    trace.samples.iter_mut().for_each(|sample| sample.mag_ut.iter_mut().for_each(|x| *x *= 1e3));
    let directory = tempfile::tempdir().unwrap();
    let [path, record, old] = ["t.csv", "r.toml", "old.toml"].map(|name| directory.path().join(name));
    trace.write(&path).unwrap();
    // Nor does a record hide it that was made of the same unit.
    std::fs::write(&old, "[mag]\nmatrix = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]]\noffset = [0, 0, 0]\n").unwrap();
    let [path, record_path, old] = [&path, &record, &old].map(|path| path.to_str().unwrap());
    for more in [&[][..], &["--config", old]] {
        let output = mwd(&[&[path, "-o", record_path][..], more].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains("unit = \"nT\" in [mag]"), "{said}");
        assert!(!said.contains("--force") && !record.exists(), "{said}");
    }
    // Without a stated field, and for who reads no units, the fitted field is none of the earth's.
    (trace.keys.magnetic_field_ut, trace.keys.mag_full_scale_ut) = (None, None);
    let found = calibrate(&[trace], None, None).unwrap();
    let verdict = found.mag.unwrap().verdict;
    assert!(matches!(&verdict, Verdict::Kept(why) if why.contains("the earth's is 15 to 80")), "{verdict:?}");
}

/// A factory's record stays in a probe for ever: a file that lacks a sensor is refused before any port is opened.
#[test]
fn a_file_that_lacks_a_sensor_is_not_provisioned() {
    const SENSORS: [&str; 3] = [
        "[gyro]\np = [[1.01, 0, 0], [0, 1, 0], [0, 0, 1]]\nb_rad_s = [0.01, 0, 0]\n",
        "[accel]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\noffset = [0, 0.1, 0]\n",
        "[mag]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\noffset = [0, 3, 0]\n",
    ];
    let directory = tempfile::tempdir().unwrap();
    let (file, port) = (directory.path().join("calibration.toml"), directory.path().join("none.sock"));
    let provisioned = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        let port = format!("unix:{}", port.display());
        command.args(["provision", &port, "--serial", "17", "--calibration"]).arg(&file);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let [gyro, accel, mag] = SENSORS;
    for (text, missing) in [
        (String::new(), "no [gyro] and no [accel] and no [mag], and"),
        ("[identification]\nwindow_s = 40.0\n".to_owned(), "no [gyro] and no [accel] and no [mag], and"),
        ([accel, mag].concat(), "no [gyro], and"),
        ([gyro, accel].concat(), "no [mag], and"),
    ] {
        let (status, said) = provisioned(&text);
        assert!(status == Some(2) && said.contains(missing) && said.contains("cargo mwd calibrate"), "{text}: {said}");
        // It takes what it says to write out: only the port is missing then.
        let told = said.split_once("write that out:\n").unwrap().1.split_once("\nnext: ").unwrap().0;
        let (status, said) = provisioned(&[&text, told].concat());
        assert!(status == Some(3) && said.contains("none.sock: cannot be opened"), "{said}");
    }
    let (status, said) = provisioned(&SENSORS.concat().replace("offset", "ofset"));
    assert!(status == Some(2) && said.contains("calibration.toml: ") && said.contains("ofset"), "{said}");
}
