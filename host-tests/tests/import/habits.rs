//! Habits of other loggers: files beside the sensors', counts without a unit, tables without time, axes of the
//! earth.

use std::fmt::Write;

use meerkat_mwd::{Sample, SampleFlags};
use mwd::import::{ColumnMap, import};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use tempfile::TempDir;

use crate::{
    files::{Written, accel, flies_as_the_original, gyro, imported, mag, original, rows, si, with_map, written},
    rig::program::mwd,
};

fn refused(path: &std::path::Path, map: &str) -> String {
    let map: ColumnMap = toml::from_str(map).unwrap();
    import(&[path.to_owned()], &map, &[]).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn files_without_a_sensor_are_passed_over_in_a_folder() {
    let folder = TempDir::new().unwrap();
    written(&folder, "Command.json", "{\n  \"name\": \"x\",\n  \"rate\": 256\n}\n");
    written(&folder, "Temperature.csv", "Timestamp (us),Temperature (degC)\n1000,21.5\n2000,21.6\n");
    written(&folder, "photo.bin", "\u{1}\0\0\0");
    written(&folder, "empty.csv", "");
    let alone = import(&[folder.path().to_owned()], &ColumnMap::default(), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(alone.contains("Command.json: no row of at least three numbers"), "{alone}");
    written(&folder, "Log.csv", &si([|v| v; 3]));
    let told = imported(&[folder.path().to_owned()]);
    flies_as_the_original(&told);
    for file in ["Command.json", "Temperature.csv", "photo.bin", "empty.csv"] {
        let is_it = |note: &&String| note.contains(file) && note.contains("not read");
        assert_eq!(told.trace.notes.iter().filter(is_it).count(), 1, "{file}: {:?}", told.trace.notes);
    }
    // A file that is named, and one whose table is damaged, stay errors.
    let named = import(&[folder.path().join("Command.json")], &ColumnMap::default(), &[]).map(|_| ()).unwrap_err();
    assert!(named.to_string().contains("no row of at least three numbers"), "{named}");
    written(&folder, "Mag.csv", "t,x,y,z\n1,2,3,4\n2,3\n3,4,5,6\n");
    let damaged = import(&[folder.path().to_owned()], &ColumnMap::default(), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(damaged.contains("Mag.csv: line 3: 2 cells"), "{damaged}");
}

/// The attitude that the gyro gives to row `k` of a slow turn, as four cells.
fn quaternion(k: usize) -> [f64; 4] {
    let q = UnitQuaternion::from_euler_angles(0.0, 0.2, 0.002 * k as f64);
    [q.w, q.i, q.j, q.k]
}

#[test]
fn a_reference_in_another_file_counts_at_the_times_that_are_the_gyros() {
    let folder = TempDir::new().unwrap();
    let (first, all) = (original().first_us(), &original().samples);
    let sensors = written(&folder, "log.csv", &si([|v| v; 3]));
    let attitude = |every: usize, late_us: u64| {
        let mut text = String::from("t_s,qw,qx,qy,qz\n");
        for (k, sample) in all.iter().enumerate().step_by(every) {
            let [w, x, y, z] = quaternion(k);
            writeln!(text, "{:.6},{w},{x},{y},{z}", (sample.t_us + late_us) as f64 * 1e-6).unwrap();
        }
        written(&folder, "attitude.csv", &text)
    };
    let told = |path| imported(&[sensors.clone(), path]).trace;
    let same = told(attitude(1, 0));
    assert_eq!(same.samples.len(), same.reference.len());
    assert!(same.reference.iter().enumerate().all(|(k, q)| *q == Some(quaternion(k))));
    let half = told(attitude(2, 0));
    let is_right = |(k, q): (usize, &Option<[f64; 4]>)| *q == (k % 2 == 0).then(|| quaternion(k));
    assert!(!half.reference.is_empty() && half.reference.iter().enumerate().all(is_right));
    let apart = told(attitude(1, 700));
    assert!(apart.reference.is_empty() && apart.first_us() == first);
    let why = apart.notes.iter().find(|note| note.starts_with("the reference attitude is left out")).unwrap();
    assert!(why.contains("0 of its") && why.contains("rows have a time of the gyro"), "{why}");
}

/// A reading in counts of so many of the trace's unit.
fn in_counts(of: fn(&Sample, usize) -> Option<f64>, axis: usize, unit: f64) -> impl Fn(&Sample) -> Option<f64> {
    move |sample| Some(of(sample, axis)? / unit)
}

#[test]
fn counts_without_a_unit_have_a_scale_in_the_map() {
    let folder = TempDir::new().unwrap();
    let time = |sample: &Sample| Some(sample.t_us as f64 * 1e-6);
    let g = [0, 1, 2].map(|axis| in_counts(gyro, axis, 0.000_25));
    let a = [0, 1, 2].map(|axis| in_counts(accel, axis, 0.061 * 9.806_65e-3));
    let m = [0, 1, 2].map(|axis| in_counts(mag, axis, 40.0));
    let columns: [Written; 10] = [
        ("t_s", &time),
        ("gyr_x", &g[0]),
        ("gyr_y", &g[1]),
        ("gyr_z", &g[2]),
        ("acc_x", &a[0]),
        ("acc_y", &a[1]),
        ("acc_z", &a[2]),
        ("Magnetometer X (a.u.)", &m[0]),
        ("Magnetometer Y (a.u.)", &m[1]),
        ("Magnetometer Z (a.u.)", &m[2]),
    ];
    let path = written(&folder, "log.csv", &rows(&original().samples, &columns, ',', '.'));
    // A scale counts in the trace's unit, or in the one that stands beside it.
    let map = "[gyro]\nscale = 0.00025\n[accel]\nscale = 0.061\nunit = 'mg'\n[mag]\nscale = 40\n";
    let told = with_map(&path, map);
    flies_as_the_original(&told);
    assert_eq!((told.map.mag.unit.as_deref(), told.map.to_toml().contains("scale = 40.0")), (Some("uT"), true));
    // The map that an import saves gives the same trace.
    assert_eq!(with_map(&path, &told.map.to_toml()).trace, told.trace);
    let unknown = refused(&path, "[mag]\nunit = 'a.u.'");
    assert!(unknown.contains("unit \"a.u.\" is not known; known are uT") && unknown.contains("scale = "), "{unknown}");
    for wrong in ["0", "-1.0", "inf"] {
        let told = refused(&path, &format!("[mag]\nscale = {wrong}"));
        assert!(told.contains("[mag]") && told.contains("scale must be a positive number"), "{told}");
    }
    // Without a scale the unit is told as a guess.
    let guessed = with_map(&path, &map.replace("[mag]\nscale = 40\n", ""));
    let note = guessed.trace.notes.iter().find(|note| note.contains("\"a.u.\" is no unit")).unwrap();
    assert!(note.contains("magnetometer") && note.contains("guess") && note.contains("scale = "), "{note}");
}

#[test]
fn sensors_of_one_table_have_the_gyros_rate_or_time() {
    let folder = TempDir::new().unwrap();
    let text = si([|v| v; 3]);
    let path = written(&folder, "log.csv", &text.replacen("t_s", "row", 1));
    let told = with_map(&path, "[gyro]\nrate_hz = 285.7142857142857\n");
    assert_eq!([&told.map.accel, &told.map.mag].map(|part| part.rate_hz), [Some(285.714_285_714_285_7); 2]);
    assert!(!told.is_wrong(), "{:#?}", told.findings);
    let told = with_map(&path, "[gyro]\ntime = 'row'\ntime_unit = 's'\n");
    assert_eq!([&told.map.accel, &told.map.mag].map(|part| part.time.as_deref()), [Some("row"); 2]);
    flies_as_the_original(&told);
    // The map's rate of a sensor wins, and so does a time that names it.
    let told = with_map(&path, "[gyro]\nrate_hz = 285.7\n[mag]\nrate_hz = 285.8\n");
    assert_eq!((told.map.accel.rate_hz, told.map.mag.rate_hz), (Some(285.7), Some(285.8)));
    let two: String = text
        .lines()
        .enumerate()
        .map(|(k, line)| format!("{},{line}\n", if k == 0 { "row" } else { &line[..8] }))
        .collect();
    let path = written(&folder, "two.csv", &two.replacen(",t_s", ",time_mag", 1));
    let told = with_map(&path, "[gyro]\ntime = 'row'\ntime_unit = 's'\n");
    assert_eq!([&told.map.accel, &told.map.mag].map(|part| part.time.as_deref()), [Some("row"), Some("time_mag")]);
}

#[test]
fn a_barometers_temperature_is_not_the_gyros() {
    let folder = TempDir::new().unwrap();
    let with = |name: &str| {
        let text: String = si([|v| v; 3])
            .lines()
            .enumerate()
            .map(|(k, line)| if k == 0 { format!("{line},{name}\n") } else { format!("{line},0.0\n") })
            .collect();
        imported(&[written(&folder, "log.csv", &text)]).trace
    };
    for name in ["baro_temp_celcius", "battery_temperature", "air_temp_celsius"] {
        let trace = with(name);
        assert!(trace.samples.iter().all(|sample| sample.flags.contains(SampleFlags::TEMPERATURE_MISSING)), "{name}");
        assert!(trace.notes.iter().any(|note| note.contains("not used") && note.contains(name)), "{:?}", trace.notes);
    }
    let trace = with("gyro_temp_c");
    assert!(trace.samples.iter().all(|sample| !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING)));
}

/// A slow turn about all axes in a field that dips by 60 deg; the reference counts from x north, y west, z up.
#[test]
fn a_reference_with_x_north_and_z_up_is_told_from_one_with_x_east() {
    let folder = TempDir::new().unwrap();
    let half_turn_about_x = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let enu = UnitQuaternion::new_unchecked(Quaternion::new(0.0, half, half, 0.0));
    let written_as = |to_ned: UnitQuaternion<f64>, has_field: bool, frame: &str| {
        let mut text = format!("# earth_frame = {frame}\nt_s,gx,gy,gz,ax,ay,az,mx,my,mz,qw,qx,qy,qz\n");
        let at = |k: u32| {
            let a = 0.002 * f64::from(k);
            UnitQuaternion::from_euler_angles(a, 0.7 * a.sin(), 0.3 * a)
        };
        for k in 0..2_000_u32 {
            let q = at(k);
            let rate = (q.inverse() * at(k + 1)).scaled_axis() * 100.0;
            let force = q.inverse() * Vector3::new(0.0, 0.0, -9.81);
            let field = q.inverse() * Vector3::new(25.0, 0.0, 43.3);
            let reference = to_ned.inverse() * q;
            let vector = |v: Vector3<f64>| format!("{:.6},{:.6},{:.6}", v.x, v.y, v.z);
            let field = if has_field { vector(field) } else { ",,".to_owned() };
            let [w, x, y, z] = [reference.w, reference.i, reference.j, reference.k];
            let t_s = 0.01 * f64::from(k);
            writeln!(text, "{t_s:.2},{},{},{field},{w:.7},{x:.7},{y:.7},{z:.7}", vector(rate), vector(force)).unwrap();
        }
        let path = written(&folder, "trace.csv", &text);
        String::from_utf8(mwd(&["replay", path.to_str().unwrap()]).stdout).unwrap()
    };
    assert!(written_as(enu, true, "NED").contains("earth_frame = ENU"));
    let told = written_as(half_turn_about_x, true, "NED");
    assert!(told.contains("earth_frame = NWU"), "{told}");
    assert!(!written_as(half_turn_about_x, true, "NWU").contains("off gravity"));
    // Without a field north is not known: both are named.
    let told = written_as(half_turn_about_x, false, "NED");
    assert!(told.contains("earth_frame = ENU, or NWU"), "{told}");
}
