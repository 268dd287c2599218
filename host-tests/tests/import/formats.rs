//! Files that are understood without a word from the user.

use std::collections::BTreeMap;

use meerkat_mwd::{Sample, SampleFlags};
use mwd::{
    import::{ColumnMap, Import, Verdict, import},
    trace::Trace,
};
use tempfile::TempDir;

use crate::{
    files::{
        Written, accel, flies_as, flies_as_the_original, flies_within, flight, gyro, imported, mag, original, rows, si,
        with_map, written,
    },
    rig::program::mwd,
};

const G: f64 = 9.806_65;

#[test]
fn degrees_gauss_and_milliseconds() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(sample.t_us as f64 * 1e-3);
    let g = [0, 1, 2].map(|axis| move |sample: &Sample| gyro(sample, axis).map(f64::to_degrees));
    let a = [0, 1, 2].map(|axis| move |sample: &Sample| accel(sample, axis).map(|x| x / G));
    let m = [0, 1, 2].map(|axis| move |sample: &Sample| mag(sample, axis).map(|x| x / 100.0));
    let columns: [Written; 10] = [
        ("time", &time),
        ("gyr_x", &g[0]),
        ("gyr_y", &g[1]),
        ("gyr_z", &g[2]),
        ("acc_x", &a[0]),
        ("acc_y", &a[1]),
        ("acc_z", &a[2]),
        ("mag_x", &m[0]),
        ("mag_y", &m[1]),
        ("mag_z", &m[2]),
    ];
    // No unit is named: sizes, the step of time and the turning of the field tell them.
    let path = written(&folder, "log.csv", &rows(&original().samples, &columns, ',', '.'));
    let told = imported(&[path]);
    flies_as_the_original(&told);
    assert_eq!(told.map.gyro.unit.as_deref(), Some("deg/s"));
    assert_eq!(told.map.gyro.time_unit.as_deref(), Some("ms"));
}

#[test]
fn decimal_commas_a_preamble_and_a_row_of_units() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(sample.t_us as f64);
    let g = [0, 1, 2].map(|axis| move |sample: &Sample| gyro(sample, axis).map(f64::to_degrees));
    let a = [0, 1, 2].map(|axis| move |sample: &Sample| accel(sample, axis).map(|x| x / G * 1e3));
    let m = [0, 1, 2].map(|axis| move |sample: &Sample| mag(sample, axis).map(|x| x * 1e3));
    let columns: [Written; 10] = [
        ("Zeit t", &time),
        ("gx", &g[0]),
        ("gy", &g[1]),
        ("gz", &g[2]),
        ("ax", &a[0]),
        ("ay", &a[1]),
        ("az", &a[2]),
        ("mx", &m[0]),
        ("my", &m[1]),
        ("mz", &m[2]),
    ];
    let text = rows(&original().samples, &columns, ';', ',');
    let (head, body) = text.split_once('\n').unwrap();
    let text = format!("Logger 7;serial 12\r\n\r\n{head}\r\nus;dps;dps;dps;mg;mg;mg;nT;nT;nT\r\n{body}");
    let told = imported(&[written(&folder, "log.txt", &text)]);
    assert_eq!(told.map.mag.unit.as_deref(), Some("nT"));
    flies_as_the_original(&told);
    // The map that an import saves gives the same trace.
    let again = with_map(&folder.path().join("log.txt"), &told.map.to_toml());
    assert_eq!(again.trace, told.trace);
}

#[test]
fn clock_times() {
    let folder = TempDir::new().unwrap();
    let plain = si([|v| v; 3]);
    let mut text = String::from("clock,gx,gy,gz,ax,ay,az,mx,my,mz\n");
    for (row, sample) in plain.lines().skip(1).zip(&original().samples) {
        // Over midnight.
        let us = sample.t_us + 86_370_000_000 - original().first_us();
        let (s, us) = (us / 1_000_000 % 86_400, us % 1_000_000);
        let cells = row.split_once(',').unwrap().1;
        text += &format!("{:02}:{:02}:{:02}.{us:06},{cells}\n", s / 3_600, s / 60 % 60, s % 60);
    }
    let mut told = imported(&[written(&folder, "log.csv", &text)]);
    let moved = told.trace.first_us() - original().first_us();
    told.trace.samples.iter_mut().for_each(|sample| sample.t_us -= moved);
    flies_as_the_original(&told);
}

/// The trace with every so manieth acceleration, on the line between in the rows between, and field.
fn thinned(trace: &Trace, accel: usize, mag: usize) -> Trace {
    let (mut thinned, all) = (trace.clone(), &trace.samples);
    for (row, sample) in thinned.samples.iter_mut().enumerate() {
        let (before, after) = (row - row % accel, row - row % accel + accel);
        match all.get(after) {
            Some(after) if row > before => {
                let before = &all[before];
                let share = (sample.t_us - before.t_us) as f64 / (after.t_us - before.t_us) as f64;
                sample.accel_m_s2 = std::array::from_fn(|axis| {
                    let (a, b) = (f64::from(before.accel_m_s2[axis]), f64::from(after.accel_m_s2[axis]));
                    (a + share * (b - a)) as f32
                });
            }
            None if row > before => sample.accel_m_s2 = all[before].accel_m_s2,
            _ => {}
        }
        if row % mag != 0 {
            sample.flags.insert(SampleFlags::MAG_MISSING);
            sample.mag_ut = [0.0; 3];
        }
    }
    thinned
}

/// Three files of a phone's logger: 286 Hz, 143 Hz and 48 Hz, by the nanoseconds of a date.
#[test]
fn three_files_of_different_rates_on_one_clock() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(1.7e18 + sample.t_us as f64 * 1e3);
    let file = |name: &str, of: fn(&Sample, usize) -> Option<f64>, every: usize| {
        let values = [0, 1, 2].map(|axis| move |sample: &Sample| of(sample, axis));
        let columns: [Written; 4] = [("time", &time), ("z", &values[2]), ("y", &values[1]), ("x", &values[0])];
        let samples: Vec<Sample> = original().samples.iter().step_by(every).copied().collect();
        written(&folder, name, &rows(&samples, &columns, ',', '.'))
    };
    let paths = [file("Accelerometer.csv", accel, 2), file("Gyroscope.csv", gyro, 1), file("Magnetometer.csv", mag, 6)];
    let mut told = imported(&paths);
    assert!(!told.is_wrong(), "{:#?}", told.findings);
    let fields = told.trace.samples.len() - told.trace.facts().count(meerkat_mwd::SampleFlags::MAG_MISSING);
    let all = original().samples.len() - original().facts().count(meerkat_mwd::SampleFlags::MAG_MISSING);
    assert!(fields.abs_diff(all / 6) < all / 60, "each field counts once: {fields} of {all}");
    // The nanoseconds of a date have 256 of them to a step.
    let moved = told.trace.first_us() as i64 - original().first_us() as i64;
    for (sample, original) in told.trace.samples.iter_mut().zip(&original().samples) {
        sample.t_us = (sample.t_us as i64 - moved) as u64;
        assert!(sample.t_us.abs_diff(original.t_us) <= 1);
        sample.t_us = original.t_us;
    }
    // Half the accelerations and a sixth of the fields, of a hand that turns fast.
    flies_within(&told.trace, 5.0);
    flies_as(&told.trace, &flight(&thinned(original(), 2, 6)), 0.01);
    // The same as a folder.
    assert_eq!(imported(&[folder.path().to_owned()]).map, told.map);
}

/// A magnetometer of 2 Hz and a thermometer of 1 Hz, in the seconds of the gyro, which no name tells.
#[test]
fn a_slow_sensors_time_has_the_unit_in_which_it_lasts_as_long_as_the_gyros() {
    let folder = TempDir::new().unwrap();
    let first = original().first_us();
    let time = move |sample: &Sample| Some((sample.t_us - first) as f64 * 1e-6);
    let warm = |_: &Sample| Some(21.5);
    let vectors = |of: fn(&Sample, usize) -> Option<f64>| [0, 1, 2].map(|axis| move |sample: &Sample| of(sample, axis));
    let (g, a, m) = (vectors(gyro), vectors(accel), vectors(mag));
    let all = &original().samples;
    // Of every half of a second, and of every second, the first sample.
    let every = |period_us: u64| -> Vec<Sample> {
        let number = |sample: &Sample| (sample.t_us - first) / period_us;
        let is_first = |(index, sample): &(usize, &Sample)| *index == 0 || number(sample) > number(&all[index - 1]);
        all.iter().enumerate().filter(is_first).map(|(_, sample)| *sample).collect()
    };
    let file = |name: &str, samples: &[Sample], columns: &[Written]| {
        let columns = [&[("time", &time as &dyn Fn(&Sample) -> _)], columns].concat();
        written(&folder, name, &rows(samples, &columns, ',', '.'))
    };
    let paths = [
        file("Gyroscope.csv", all, &[("x", &g[0]), ("y", &g[1]), ("z", &g[2])]),
        file("Accelerometer.csv", all, &[("x", &a[0]), ("y", &a[1]), ("z", &a[2])]),
        file("Magnetometer.csv", &every(500_000), &[("x", &m[0]), ("y", &m[1]), ("z", &m[2])]),
        file("Temperature.csv", &every(1_000_000), &[("temp_c", &warm), ("humidity", &warm)]),
    ];
    let told = imported(&paths);
    let units = [&told.map.gyro, &told.map.accel, &told.map.mag, &told.map.temperature];
    assert_eq!(units.map(|part| part.time_unit.as_deref()), [Some("s"); 4]);
    assert!(!told.is_wrong(), "{:#?}", told.findings);
    let fields = told.trace.samples.len() - told.trace.facts().count(SampleFlags::MAG_MISSING);
    assert!(fields.abs_diff(80) < 8, "{fields} fields in 40 s");
    // As the program guessed before, by a map: it is told what is wrong, and what mends it.
    let mut map = told.map.clone();
    map.mag.time_unit = Some("ms".into());
    let wrong = import(&paths, &map, &[]).unwrap();
    let finding =
        wrong.findings.iter().find(|finding| finding.told.starts_with("the magnetometer covers 0.0")).unwrap();
    assert_eq!(finding.verdict, Verdict::Wrong);
    assert!(finding.told.contains(" s of the gyro's 39.") || finding.told.contains(" s of the gyro's 40."));
    assert!(
        finding.fix.as_ref().is_some_and(|fix| fix.contains("time_unit = ") && fix.contains("[mag]")),
        "{finding:?}"
    );
}

/// A table with a time for each sensor, of which one starts later; with one for some sensors only it is asked which.
#[test]
fn a_sensor_has_the_time_that_names_it() {
    let folder = TempDir::new().unwrap();
    let names = "time_gyr,gx,gy,gz,time_acc,ax,ay,az,time_mag,mx,my,mz";
    let samples = &original().samples;
    let three = |of: fn(&Sample, usize) -> Option<f64>, sample: &Sample| {
        let cell = |axis| of(sample, axis).map_or_else(String::new, |x| format!("{x:.9}"));
        [cell(0), cell(1), cell(2)].join(",")
    };
    let table = |names: &str| {
        let mut text = format!("{names}\n");
        for (row, sample) in samples.iter().enumerate() {
            // The readings of a magnetometer that is a sixth as fast stand in the first rows, as MATLAB writes them.
            let field = samples.get(6 * row).filter(|sample| mag(sample, 0).is_some());
            let field = field.map_or_else(
                || ",,,".to_owned(),
                |sample| format!("{:.6},{}", sample.t_us as f64 * 1e-6, three(mag, sample)),
            );
            let t_s = sample.t_us as f64 * 1e-6;
            text += &format!("{t_s:.6},{},{t_s:.6},{},{field}\n", three(gyro, sample), three(accel, sample));
        }
        written(&folder, "log.csv", &text)
    };
    let told = imported(&[table(names)]);
    let times = [&told.map.gyro, &told.map.accel, &told.map.mag].map(|part| part.time.as_deref());
    assert_eq!(times, [Some("time_gyr"), Some("time_acc"), Some("time_mag")]);
    assert!(!told.is_wrong() && told.dropped() == 0, "{:#?}", told.findings);
    flies_as(&told.trace, &flight(&thinned(original(), 1, 6)), 0.01);
    // A time that names no sensor is that of all others.
    let told = imported(&[table(&names.replace("time_gyr", "time").replace("time_acc", "other"))]);
    let times = [&told.map.gyro, &told.map.accel, &told.map.mag].map(|part| part.time.as_deref());
    assert_eq!(times, [Some("time"), Some("time"), Some("time_mag")]);
    let refused = import(&[table(&names.replace("time_acc", "other"))], &ColumnMap::default(), &[]).unwrap_err();
    let expected =
        "[accel] log: the columns of time, time_gyr, time_mag, are of other sensors; name this one's by `time = \"";
    assert!(refused.to_string().starts_with(expected), "{refused}");
}

/// A trace of this program keeps what only its traces have, and what is not used is told.
#[test]
fn a_trace_keeps_its_flags_and_what_is_not_used_is_told() {
    let folder = TempDir::new().unwrap();
    let count = original().samples.len();
    let flags = |row: usize| if row % 100 == 7 { SampleFlags::FAULT } else { SampleFlags::empty() };
    let mut trace = Trace {
        driver_flags: Some((0..count).map(flags).collect()),
        movement: Some((0..count).map(|row| row > 3_000).collect()),
        rest: Some((0..count).map(|row| row < 2_500).collect()),
        ..original().clone()
    };
    trace.mark_clipped(&trace.keys.full_scale());
    let path = folder.path().join("trace.csv");
    trace.write(&path).unwrap();
    let mut lines: Vec<String> = std::fs::read_to_string(&path).unwrap().lines().map(str::to_owned).collect();
    let head = lines.iter().position(|line| !line.starts_with('#')).unwrap();
    for (row, line) in lines.iter_mut().enumerate().skip(head) {
        // The last column is empty.
        *line += if row == head { ",humidity,volts,spare" } else { ",40,3.3," };
    }
    // A row that is dropped takes its flags with it.
    lines.insert(head + 1_000, lines[head + 999].clone());
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]).trace;
    assert_eq!((told.samples.len(), &told.driver_flags), (count, &trace.driver_flags));
    assert!(told.movement == trace.movement && told.rest == trace.rest);
    assert!(told.samples.iter().zip(&trace.samples).all(|(a, b)| a.flags == b.flags));
    assert!(told.notes.contains(&"columns of log that are not used: humidity, volts".to_owned()), "{:?}", told.notes);
    // A column so named of another logger is not the trace's.
    lines[head] = lines[head].replace("t_s", "time_s");
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]).trace;
    assert_eq!((told.driver_flags, told.movement, told.rest), (None, None, None));
    let note = "columns of log that are not used: movement, rest, sample_flags, humidity, volts";
    assert!(told.notes.contains(&note.to_owned()), "{:?}", told.notes);
}

#[test]
fn repeated_and_late_rows_are_dropped_and_counted() {
    let folder = TempDir::new().unwrap();
    let mut lines: Vec<String> = si([|v| v; 3]).lines().map(str::to_owned).collect();
    lines.insert(2_001, lines[2_000].clone());
    lines.insert(3_000, lines[2_990].clone());
    let told = imported(&[written(&folder, "log.csv", &lines.join("\n"))]);
    assert_eq!(told.dropped(), 2);
    let counted = |finding: &mwd::import::Finding| finding.told.contains("2 rows dropped (1 repeat a time, 1 are late");
    assert!(told.findings.iter().any(|finding| finding.verdict == Verdict::Note && counted(finding)));
    flies_as_the_original(&told);
}

#[test]
fn a_text_that_is_cut_off_is_told() {
    let folder = TempDir::new().unwrap();
    let whole = si([|v| v; 3]);
    let path = written(&folder, "log.csv", whole.trim_end().rsplit_once(',').unwrap().0);
    is_told_as_lost(&imported(std::slice::from_ref(&path)), "the last line is cut off");
    let strict = mwd(&["import", path.to_str().unwrap(), "--strict"]);
    let said = String::from_utf8_lossy(&strict.stderr);
    assert!(strict.status.code() == Some(2) && said.contains("the last line is cut off"), "{said}");
}

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

/// What was lost of the only file is told as a note of the trace.
fn is_told_as_lost(told: &Import, what: &str) {
    let [lost] = &told.lost[..] else { panic!("{:?}", told.lost) };
    assert!(lost.contains(what) && told.trace.notes.contains(lost), "{lost}: {:?}", told.trace.notes);
}

/// A .mat with a structure of single and double arrays, one of which lies, byte by byte after MathWorks' description of
/// version 5; files that MATLAB itself wrote are in `bindings/python/tests/test_foreign.py`.
#[test]
fn a_mat_file() {
    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }
    fn array(class: u8, dimensions: [usize; 2], name: &str, parts: &[Vec<u8>]) -> Vec<u8> {
        let dimensions: Vec<u8> = dimensions.iter().flat_map(|size| (*size as u32).to_le_bytes()).collect();
        let head = [element(6, &[class, 0, 0, 0, 0, 0, 0, 0]), element(5, &dimensions), element(1, name.as_bytes())];
        element(14, &[head.concat(), parts.concat()].concat())
    }
    let samples = &original().samples;
    let count = samples.len();
    let time: Vec<u8> = samples.iter().flat_map(|s| (s.t_us as f64 * 1e-6).to_le_bytes()).collect();
    let column_major: Vec<u8> =
        (0..3).flat_map(|axis| samples.iter().flat_map(move |s| s.gyro_rad_s[axis].to_le_bytes())).collect();
    let row_major: Vec<u8> = samples.iter().flat_map(|s| s.accel_m_s2.map(f32::to_le_bytes)).flatten().collect();
    let field: Vec<u8> = (0..3)
        .flat_map(|axis| {
            samples.iter().flat_map(move |s| mag(s, axis).map_or(f32::NAN, |_| s.mag_ut[axis]).to_le_bytes())
        })
        .collect();
    let fields = [
        array(6, [count, 1], "", &[element(9, &time)]),
        array(7, [count, 3], "", &[element(7, &column_major)]),
        array(7, [3, count], "", &[element(7, &row_major)]),
        array(7, [count, 3], "", &[element(7, &field)]),
        array(6, [1, 1], "", &[element(9, &100.0_f64.to_le_bytes())]),
    ];
    let names: Vec<u8> = ["time", "gyro", "acc", "mag", "fs"]
        .iter()
        .flat_map(|name| {
            let mut name = name.as_bytes().to_vec();
            name.resize(8, 0);
            name
        })
        .collect();
    let parts = [vec![element(5, &8_u32.to_le_bytes()), element(1, &names)], fields.to_vec()].concat();
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\x00\x01IM");
    bytes.extend(array(2, [1, 1], "imu", &parts));
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("log.mat");
    std::fs::write(&path, &bytes).unwrap();
    flies_as_the_original(&imported(std::slice::from_ref(&path)));
    // No cut and no flipped byte makes it panic.
    for cut in (0..2_000).chain((2_000..bytes.len()).step_by(4_001)) {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        let _ = mwd::import::import(std::slice::from_ref(&path), &Default::default(), &[]);
    }
}

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

/// A Parquet file with a clock of its own, a gyro in deg/s and gaps in the field.
#[test]
fn a_parquet_file() {
    use std::sync::Arc;

    use parquet::{
        data_type::{DoubleType, FloatType, Int64Type},
        file::{properties::WriterProperties, writer::SerializedFileWriter},
        schema::parser::parse_message_type,
    };

    let schema = "message readings { required int64 time (TIMESTAMP(MICROS, true)); required double gyr_x_dps; \
                  required double gyr_y_dps; required double gyr_z_dps; required float acc_x; required float acc_y; \
                  required float acc_z; optional double mag_x; optional double mag_y; optional double mag_z; }";
    let samples = &original().samples;
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("readings.parquet");
    let properties = WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut writer =
        SerializedFileWriter::new(std::fs::File::create(&path).unwrap(), schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for index in 0..10_usize {
        let axis = index.wrapping_sub(1) % 3;
        let mut column = group.next_column().unwrap().unwrap();
        match index {
            0 => {
                let times: Vec<i64> = samples.iter().map(|sample| sample.t_us as i64).collect();
                column.typed::<Int64Type>().write_batch(&times, None, None).unwrap();
            }
            1..=3 => {
                let rates: Vec<f64> = samples.iter().map(|s| f64::from(s.gyro_rad_s[axis]).to_degrees()).collect();
                column.typed::<DoubleType>().write_batch(&rates, None, None).unwrap();
            }
            4..=6 => {
                let forces: Vec<f32> = samples.iter().map(|s| s.accel_m_s2[axis]).collect();
                column.typed::<FloatType>().write_batch(&forces, None, None).unwrap();
            }
            _ => {
                let fields: Vec<Option<f64>> = samples.iter().map(|sample| mag(sample, axis)).collect();
                let levels: Vec<i16> = fields.iter().map(|field| i16::from(field.is_some())).collect();
                let there: Vec<f64> = fields.into_iter().flatten().collect();
                column.typed::<DoubleType>().write_batch(&there, Some(&levels), None).unwrap();
            }
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    let told = imported(std::slice::from_ref(&path));
    assert_eq!(told.map.gyro.unit.as_deref(), Some("deg/s"));
    flies_as_the_original(&told);
    std::fs::write(&path, b"PAR1 and then nothing").unwrap();
    let refused = import(&[path], &ColumnMap::default(), &[]).unwrap_err().to_string();
    assert!(refused.contains("the Parquet file cannot be read"), "{refused}");
}
