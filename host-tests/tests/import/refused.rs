//! Recordings that cannot be right are refused, with the fix that makes them right.

use meerkat_mwd::Sample;
use mwd::import::{ColumnMap, Import, Verdict, import};
use tempfile::TempDir;
use testbed::{
    simulate::{Scenario, simulate},
    trace::{
        Keys, Trace,
        recordings::{bundled, given},
    },
};

use crate::{
    files::{flies_as_the_original, imported, original, si, with_map, written},
    rig::files::scenario,
};

type Change = fn([f64; 3]) -> [f64; 3];

/// Text of the only wrong finding, and its fix.
fn wrong(told: &Import) -> (String, String) {
    let wrong: Vec<_> = told.findings.iter().filter(|finding| finding.verdict == Verdict::Wrong).collect();
    assert_eq!(wrong.len(), 1, "{:#?}", told.findings);
    (wrong[0].told.clone(), wrong[0].fix.clone().unwrap())
}

/// The fix of a finding, as lines of a map.
fn as_map(fix: &str) -> String {
    let (setting, section) = fix.rsplit_once(" in [").unwrap();
    format!("[{}\n{setting}\n", section)
}

/// Turned axes are refused by name, and with the fix as a map the flight is the original's.
#[test]
fn turned_axes_are_named_and_the_fix_makes_them_right() {
    let folder = TempDir::new().unwrap();
    const SAME: Change = |v| v;
    let cases: [(&str, [Change; 3]); 6] = [
        ("axes of the gyro", [|[x, y, z]| [-y, x, z], SAME, SAME]),
        ("axes of the gyro", [|[x, y, z]| [x, -y, z], SAME, SAME]),
        ("axes of the gyro", [|[x, y, z]| [x, z, y], SAME, SAME]),
        // An AK8963 in an MPU-9250, as it comes.
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [y, x, -z]]),
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [x, -y, -z]]),
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [x, y, -z]]),
    ];
    for (index, (what, changes)) in cases.into_iter().enumerate() {
        let path = written(&folder, &format!("{index}.csv"), &si(changes));
        let (told, fix) = wrong(&imported(std::slice::from_ref(&path)));
        assert!(told.starts_with(what), "{index}: {told}: {fix}");
        flies_as_the_original(&with_map(&path, &as_map(&fix)));
    }
}

#[test]
fn wrong_units_are_refused_with_the_right_one() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, "log.csv", &si([|v| v.map(f64::to_degrees), |v| v.map(|x| x / 9.806_65), |v| v]));
    for (map, fix) in [
        ("[gyro]\nunit = 'rad/s'", "unit = \"deg/s\" in [gyro]"),
        ("[accel]\nunit = 'm/s^2'", "unit = \"g\" in [accel]"),
        ("[mag]\nunit = 'nT'", "unit = \"uT\" in [mag]"),
    ] {
        assert_eq!(wrong(&with_map(&path, map)).1, fix);
    }
    flies_as_the_original(&with_map(&path, "[gyro]\nunit = 'deg/s'"));
}

#[test]
fn an_acceleration_without_gravity_and_a_dead_axis_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, "log.csv", &si([|v| v, |v| v, |[x, _, z]| [x, 12.0, z]]));
    let told = imported(&[path]);
    assert!(
        told.findings.iter().any(|f| f.told == "magnetometer y, column \"my\", never changes"),
        "{:?}",
        told.findings
    );
    let still: String = (0..2_000).map(|i| format!("{},0.01,0,0.0{},0.0{},0.01,0.02\n", i * 5, i % 3, i % 7)).collect();
    let path = written(&folder, "still.csv", &format!("t_ms,gx,gy,gz,ax,ay,az\n{still}"));
    let told = with_map(&path, "[accel]\nunit = 'm/s^2'");
    assert!(told.findings.iter().any(|f| f.fix.as_deref().is_some_and(|fix| fix.starts_with("gravity was taken out"))));
}

/// A rate that the pipeline does not take, gaps over a fifth of the time and repeated rows over one in twenty.
#[test]
fn a_clock_that_cannot_be_is_refused_with_what_to_look_at() {
    let folder = TempDir::new().unwrap();
    let text = si([|v| v; 3]);
    let (head, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    // A third of each second's rows is not there; every twelfth row is there twice.
    let slow: Vec<&str> = rows.iter().step_by(20).copied().collect();
    let in_gaps: Vec<&str> = rows.iter().enumerate().filter(|(row, _)| row % 285 < 190).map(|(_, row)| *row).collect();
    let repeated: Vec<&str> =
        rows.iter().enumerate().flat_map(|(row, text)| vec![*text; if row % 12 == 0 { 2 } else { 1 }]).collect();
    for (number, (rows, told, fix)) in [
        (slow, "rate 14.", "time_unit, now \"s\", or another column of time than \"t_s\""),
        (in_gaps, "gaps over three periods", "the gyro was not read all the time"),
        (repeated, "repeat a time", "the clock \"t_s\" is too coarse or not this sensor's"),
    ]
    .into_iter()
    .enumerate()
    {
        let path = written(&folder, &format!("{number}.csv"), &format!("{head}\n{}\n", rows.join("\n")));
        let import = imported(&[path]);
        let wrong: Vec<_> = import.findings.iter().filter(|finding| finding.verdict == Verdict::Wrong).collect();
        let is_it = |finding: &&mwd::import::Finding| {
            finding.told.contains(told) && finding.fix.as_deref().is_some_and(|text| text.contains(fix))
        };
        assert!(import.is_wrong() && wrong.iter().any(is_it), "{number}: {:#?}", import.findings);
    }
}

#[test]
fn a_message_names_what_is_there() {
    let folder = TempDir::new().unwrap();
    let said = |text: &str, map: &str| {
        let path = written(&folder, "log.csv", text);
        let map: ColumnMap = toml::from_str(map).unwrap();
        import(&[path], &map, &[]).map(|_| ()).unwrap_err().to_string()
    };
    let table = "t_s,a,b,c,d,e,f\n0,1,2,3,4,5,6\n0.01,1,2,3,4,5,6\n";
    let told = said(table, "");
    assert!(
        told.starts_with("no columns of the gyro are known") && told.contains("log: t_s, a, b, c, d, e, f"),
        "{told}"
    );
    let told = said(table, "[gyro]\ncolumns = ['a', 'b', 'x']");
    assert_eq!(told, "[gyro] of the map: there is no column \"x\"; there are t_s, a, b, c, d, e, f");
    let told = said(table, "[gyro]\ncolumns = ['a', 'b', 'c']\nunit = 'furlong'");
    assert!(told.contains("unit \"furlong\" is not known; known are rad/s, deg/s"), "{told}");
    let told = said("k,gx,gy,gz,ax,ay,az\n0,1,2,3,4,5,6\n", "");
    assert!(told.contains("rate_hz"), "{told}");
    let told = said("t_s,gx,gy,gz,ax,ay,az\n0,1,2,3,4,5,6\n0.01,1,oops,3,4,5,6\n", "");
    assert_eq!(told, "log: line 3, column gy: \"oops\" is not a number (1 such cells)");
    let told = said("t_s,gx,gx,gy,gz,ax,ay,az\n0,1,1,2,3,4,5,6\n0.01,1,1,2,3,4,5,6\n", "");
    assert_eq!(told, "log: two columns are named gx: leave out one");
    assert!(said("PK\u{3}\u{4}rest", "").ends_with("a zip archive: unpack it and name the files or their folder"));
}

/// Makes a file of a trace, imports it and returns what is said of saturation.
fn saturated(folder: &TempDir, trace: &Trace) -> Option<(Verdict, String)> {
    let path = folder.path().join("trace.csv");
    trace.write(&path).unwrap();
    let told = imported(&[path]);
    let finding = told.findings.iter().find(|finding| finding.told.contains("saturates"))?;
    Some((finding.verdict, finding.told.clone()))
}

fn drilled(seed: u64) -> Trace {
    let trace = simulate(&Scenario { duration_s: 120.0, ..scenario("drilling_45deg") }, seed).0;
    // Trace of a probe that does not state its full scale.
    Trace { keys: Keys { gyro_full_scale_rad_s: None, accel_full_scale_m_s2: None, ..trace.keys }, ..trace }
}

/// The larger of a size and a reading's.
fn larger(most: f32, reading: f32) -> f32 {
    if reading.abs() > most { reading.abs() } else { most }
}

/// Cuts readings off at the end of a range, and returns how many samples that changed.
fn clipped(trace: &mut Trace, of: fn(&mut Sample) -> &mut [f32; 3], end: f32) -> usize {
    let clip = |sample: &mut Sample| {
        let reading = of(sample);
        let before = *reading;
        *reading = reading.map(|x| if x.abs() > end { end.copysign(x) } else { x });
        *reading != before
    };
    trace.samples.iter_mut().map(clip).filter(|is_clipped| *is_clipped).count()
}

/// A range that ends within the motion is told wherever it ends, of any sensor, and with the samples that stay there.
#[test]
fn saturation_is_told_wherever_the_range_ends() {
    let folder = TempDir::new().unwrap();
    let gyro: fn(&mut Sample) -> &mut [f32; 3] = |sample| &mut sample.gyro_rad_s;
    let accel: fn(&mut Sample) -> &mut [f32; 3] = |sample| &mut sample.accel_m_s2;
    for seed in 1..=3 {
        let drilled = drilled(seed);
        assert_eq!(saturated(&folder, &drilled), None, "{seed}");
        let largest = |of: fn(&mut Sample) -> &mut [f32; 3]| {
            let mut samples = drilled.samples.clone();
            samples.iter_mut().flat_map(|sample| *of(sample)).fold(0.0_f32, larger)
        };
        // An end below the usual rate, at four fifths of the peak, and where few samples reach it.
        for (of, end) in [(gyro, 1.0), (gyro, 0.8 * largest(gyro)), (accel, 0.8 * largest(accel)), (accel, 15.0)] {
            let mut trace = drilled.clone();
            let count = clipped(&mut trace, of, end);
            let told = saturated(&folder, &trace);
            // Below that count chance may do it, as the gate's statistics say.
            if count < 30 {
                continue;
            }
            let (verdict, told) = told.unwrap_or_else(|| panic!("{seed}: {count} of {end} are not told"));
            assert!(told.contains(&format!("{count} samples stay at")), "{seed} {end} {count}: {told}");
            let is_wrong = count as f64 > 0.05 * trace.samples.len() as f64;
            assert_eq!(verdict == Verdict::Wrong, is_wrong, "{told}");
        }
    }
    // Readings of a hand at an end that 56 samples reach.
    let mut trace = original().clone();
    let mut sizes: Vec<f32> =
        trace.samples.iter().map(|sample| sample.accel_m_s2.into_iter().fold(0.0, larger)).collect();
    sizes.sort_unstable_by(f32::total_cmp);
    let end = sizes[sizes.len() - 57];
    let reach_it = sizes.iter().filter(|size| **size >= end).count();
    clipped(&mut trace, accel, end);
    let (verdict, told) = saturated(&folder, &trace).unwrap();
    assert!(verdict == Verdict::Note && told.contains(&format!("{reach_it} samples stay at")), "{reach_it}: {told}");
}

/// Recordings as they are, rests, smooth peaks in coarse digits and turns at one rate are no saturation.
#[test]
fn what_repeats_without_saturation_is_none() {
    let folder = TempDir::new().unwrap();
    for path in bundled().unwrap().into_iter().chain(given().unwrap()) {
        let told = imported(std::slice::from_ref(&path));
        assert!(told.findings.iter().all(|finding| !finding.told.contains("saturates")), "{:#?}", told.findings);
    }
    // Coarse digits: of a rest, of a slow swing, and of a table that turns at one rate.
    let swing = |k: usize| 1.5 * (0.004 * k as f64).sin();
    let noise = |k: usize, sigma: f64| sigma * ((k * k % 97) as f64 / 48.0 - 1.0);
    let coarse = |x: f64| (x / 0.01).round() * 0.01;
    type Rate = fn(usize) -> f64;
    let rates: [Rate; 3] = [|_| 0.3, |k| 1.5 * (0.004 * k as f64).sin(), |k| if k > 500 { 1.043 } else { 0.0 }];
    for (number, rate) in rates.into_iter().enumerate() {
        let rows: String = (0..6_000)
            .map(|k| {
                let [x, y, z] = [noise(k, 0.02), noise(k + 31, 0.02), rate(k) + noise(k + 7, 0.004)].map(coarse);
                let (ax, ay) = (coarse(noise(k, 0.03)), coarse(swing(k)));
                format!(
                    "{:.2},{x:.2},{y:.2},{z:.2},{ax:.2},{ay:.2},{:.2}\n",
                    k as f64 * 0.01,
                    coarse(9.8 + noise(k + 3, 0.004))
                )
            })
            .collect();
        let path = written(&folder, "coarse.csv", &format!("t_s,gx,gy,gz,ax,ay,az\n{rows}"));
        let told = with_map(&path, "[gyro]\nunit = 'rad/s'\n[accel]\nunit = 'm/s^2'\n");
        let of_it: Vec<_> = told.findings.iter().filter(|finding| finding.told.contains("saturates")).collect();
        assert!(of_it.is_empty(), "{number}: {of_it:#?}");
    }
}

/// Stamps with a date that go back by a day are no clock that passes midnight.
#[test]
fn dates_that_go_back_are_refused() {
    let folder = TempDir::new().unwrap();
    let plain = si([|v| v; 3]);
    let mut text = String::from("clock,gx,gy,gz,ax,ay,az,mx,my,mz\n");
    let rows = original().samples.len();
    for (row, (line, sample)) in plain.lines().skip(1).zip(&original().samples).enumerate() {
        let us = sample.t_us - original().first_us();
        let (day, s, us) = (if 2 * row < rows { 3 } else { 2 }, us / 1_000_000, us % 1_000_000);
        let cells = line.split_once(',').unwrap().1;
        text += &format!("2026-03-{day:02} {:02}:{:02}:{:02}.{us:06},{cells}\n", s / 3_600, s / 60 % 60, s % 60);
    }
    let path = written(&folder, "log.csv", &text);
    let told = imported(&[path]);
    let is_it = |finding: &&mwd::import::Finding| {
        finding.verdict == Verdict::Wrong && finding.told.contains("are out of order")
    };
    assert_eq!(told.findings.iter().filter(is_it).count(), 1, "{:#?}", told.findings);
}
