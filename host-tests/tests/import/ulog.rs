//! PX4's ULog.

use tempfile::TempDir;

use crate::{
    files::{flies_as_the_original, imported, is_told_as_lost, mag, original},
    rig::program::mwd,
};

/// A ULog of the two topics, byte by byte after PX4's description of the format; one that PX4's own library wrote is in
/// `bindings/python/tests/test_foreign.py`.
#[test]
fn a_ulog() {
    let mut bytes = b"ULog\x01\x12\x35\x01".to_vec();
    bytes.extend(0_u64.to_le_bytes());
    let mut message = |kind: u8, body: &[u8]| {
        bytes.extend((body.len() as u16).to_le_bytes());
        bytes.push(kind);
        bytes.extend(body);
    };
    message(b'B', &[0; 40]);
    message(
        b'F',
        b"sensor_combined:uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;",
    );
    message(b'F', b"vehicle_magnetometer:uint64_t timestamp;float[3] magnetometer_ga;");
    for (id, name) in [(0_u16, "sensor_combined"), (1, "vehicle_magnetometer")] {
        let mut body = vec![0];
        body.extend(id.to_le_bytes());
        body.extend(name.as_bytes());
        message(b'A', &body);
    }
    for sample in &original().samples {
        let floats = |v: [f32; 3]| v.into_iter().flat_map(f32::to_le_bytes);
        let mut body = 0_u16.to_le_bytes().to_vec();
        body.extend(sample.t_us.to_le_bytes());
        body.extend(floats(sample.gyro_rad_s));
        body.extend(0_i32.to_le_bytes());
        body.extend(floats(sample.accel_m_s2));
        message(b'D', &body);
        if mag(sample, 0).is_some() {
            let mut body = 1_u16.to_le_bytes().to_vec();
            body.extend(sample.t_us.to_le_bytes());
            body.extend(floats(sample.mag_ut.map(|x| x / 100.0)));
            message(b'D', &body);
        }
    }
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("log.ulg");
    std::fs::write(&path, &bytes).unwrap();
    let told = imported(std::slice::from_ref(&path));
    assert_eq!(told.map.mag.unit.as_deref(), Some("gauss"));
    assert_eq!(told.lost, [""; 0]);
    flies_as_the_original(&told);
    // Cut off, as by a crash of the vehicle: the samples before are there, and it is told.
    std::fs::write(&path, &bytes[..bytes.len() / 2 + 7]).unwrap();
    let told = imported(std::slice::from_ref(&path));
    let half = told.trace.samples.len();
    assert!(half.abs_diff(original().samples.len() / 2) < 50, "{half}");
    is_told_as_lost(&told, "the ULog is cut off");
    let strict = mwd(&["import", path.to_str().unwrap(), "--strict"]);
    let said = String::from_utf8_lossy(&strict.stderr);
    assert!(strict.status.code() == Some(2) && said.contains("the ULog is cut off"), "{said}");
}
