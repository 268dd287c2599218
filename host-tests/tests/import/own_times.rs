//! Sensors with times of their own, of other rates and units.

use meerkat_mwd::{Sample, SampleFlags};
use mwd::import::{ColumnMap, Verdict, import};
use tempfile::TempDir;
use testbed::trace::Trace;

use crate::files::{Written, accel, flies_as, flies_within, flight, gyro, imported, mag, original, rows, written};

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
    // First sample of every period: of half a second, and of a second.
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
