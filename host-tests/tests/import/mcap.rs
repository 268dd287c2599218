//! MCAP, of ROS 2 and of others.

use std::collections::BTreeMap;

use meerkat_mwd::Sample;
use tempfile::TempDir;

use crate::{
    files::{accel, flies_within, gyro, imported, is_told_as_lost, mag, original},
    rig::program::mwd,
};

/// An MCAP written by its own library: the gyro and the accelerometer as ROS 2 writes them, the field in JSON.
#[test]
fn an_mcap_of_ros_2_and_json() {
    use mcap::{Writer, records::MessageHeader};

    const IMU: &str = "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
                       geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
                       geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n\
                       ====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
                       ====\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n\
                       ====\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
    const DATE_S: u64 = 1_760_000_000;
    let mut writer = Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/Imu", "ros2msg", IMU.as_bytes()).unwrap();
    let imu = writer.add_channel(schema, "/imu/data", "cdr", &BTreeMap::new()).unwrap();
    let field = writer.add_channel(0, "/imu/mag", "json", &BTreeMap::new()).unwrap();
    let picture = writer.add_channel(0, "/camera", "protobuf", &BTreeMap::new()).unwrap();
    for (sequence, sample) in (0..).zip(&original().samples) {
        let t_ns = DATE_S * 1_000_000_000 + sample.t_us * 1_000;
        // Written a little later, and not evenly.
        let late_ns = 3_000_000 + u64::from(sequence % 7) * 500_000;
        let mut send = |channel_id: u16, data: &[u8]| {
            let header = MessageHeader { channel_id, sequence, log_time: t_ns + late_ns, publish_time: t_ns + late_ns };
            writer.write_to_known_channel(&header, data).unwrap();
        };
        let mut body = vec![0, 1, 0, 0];
        body.extend(((t_ns / 1_000_000_000) as i32).to_le_bytes());
        body.extend(((t_ns % 1_000_000_000) as u32).to_le_bytes());
        body.extend(4_u32.to_le_bytes());
        body.extend(b"imu\0");
        let doubles = |v: [f32; 3]| v.into_iter().flat_map(|x| f64::from(x).to_le_bytes());
        body.extend([0.0, 0.0, 0.0, 1.0].into_iter().chain([0.0; 9]).flat_map(f64::to_le_bytes));
        body.extend(doubles(sample.gyro_rad_s));
        body.extend([0.0; 9].into_iter().flat_map(f64::to_le_bytes));
        body.extend(doubles(sample.accel_m_s2));
        body.extend([0.0; 9].into_iter().flat_map(f64::to_le_bytes));
        send(imu, &body);
        if let (Some(x), Some(y), Some(z)) = (mag(sample, 0), mag(sample, 1), mag(sample, 2)) {
            let stamp = serde_json::json!({"sec": t_ns / 1_000_000_000, "nanosec": t_ns % 1_000_000_000});
            let [x, y, z] = [x, y, z].map(|microtesla| microtesla * 1e-6);
            let message = serde_json::json!({"header": {"stamp": stamp}, "magnetic_field": {"x": x, "y": y, "z": z}});
            send(field, message.to_string().as_bytes());
        }
        send(picture, &[1, 2, 3]);
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(&path, &bytes).unwrap();
    let told = imported(std::slice::from_ref(&path));
    assert_eq!(told.map.mag.unit.as_deref(), Some("T"));
    assert_eq!(told.map.gyro.table.as_deref(), Some("/imu/data"));
    assert!(!told.is_wrong(), "{:#?}", told.findings);
    assert_eq!(told.lost, [""; 0]);
    let unread = "drive.mcap: messages that are not understood are left out: /camera (protobuf)";
    assert!(told.trace.notes.iter().any(|note| note.ends_with(unread)), "{:?}", told.trace.notes);
    // The clock starts with the second of its first message, not with a date.
    let mut trace = told.trace;
    let second = original().first_us() / 1_000_000;
    trace.samples.iter_mut().for_each(|sample| sample.t_us += second * 1_000_000);
    flies_within(&trace, 0.01);
    // Cut off: what is there counts.
    std::fs::write(&path, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let told = imported(std::slice::from_ref(&path));
    let part = told.trace.samples.len();
    assert!(part > original().samples.len() / 2 && part < original().samples.len(), "{part}");
    is_told_as_lost(&told, "the MCAP is cut off");
    // All messages are there, and the end is not.
    std::fs::write(&path, &bytes[..bytes.len() - 8]).unwrap();
    is_told_as_lost(&imported(&[path]), "the MCAP is cut off");
}

/// A digit of one message that is another one: only the sum of its chunk tells.
#[test]
fn a_damaged_mcap_is_told() {
    use mcap::{WriteOptions, records::MessageHeader};

    let mut writer = WriteOptions::new().compression(None).create(std::io::Cursor::new(Vec::new())).unwrap();
    let imu = writer.add_channel(0, "/imu", "json", &BTreeMap::new()).unwrap();
    for (sequence, sample) in (0..).zip(&original().samples) {
        let three = |of: fn(&Sample, usize) -> Option<f64>| {
            let [x, y, z] = [0, 1, 2].map(|axis| of(sample, axis));
            serde_json::json!({"x": x, "y": y, "z": z})
        };
        let message = serde_json::json!({"gyro": three(gyro), "accel": three(accel), "mag": three(mag)});
        let (log_time, publish_time) = (sample.t_us * 1_000, sample.t_us * 1_000);
        let header = MessageHeader { channel_id: imu, sequence, log_time, publish_time };
        writer.write_to_known_channel(&header, message.to_string().as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let mut bytes = writer.into_inner().into_inner();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(&path, &bytes).unwrap();
    let whole = imported(std::slice::from_ref(&path));
    assert!(whole.lost.is_empty() && whole.trace.samples.len() == original().samples.len(), "{:?}", whole.lost);
    let (half, sought) = (bytes.len() / 2, b"\"x\":0.");
    let digit = half + bytes[half..].windows(sought.len()).position(|text| text == sought).unwrap() + sought.len();
    bytes[digit] = if bytes[digit] == b'9' { b'1' } else { bytes[digit] + 1 };
    std::fs::write(&path, &bytes).unwrap();
    let told = imported(std::slice::from_ref(&path));
    is_told_as_lost(&told, "the MCAP is damaged");
    let count = told.trace.samples.len();
    assert!(count > original().samples.len() / 3 && count < original().samples.len(), "{count}");
    assert_eq!(mwd(&["import", path.to_str().unwrap(), "--strict"]).status.code(), Some(2));
}
