//! Traces that are written read back the same, and no damage makes the reader panic or let a bad number through.
#![allow(clippy::unwrap_used, missing_docs)]

mod rig;

use std::fs;

use meerkat_mwd::{Sample, SampleFlags, config::Motion};
use mwd::diagnosis::diagnosed;
use proptest::{collection::vec, option, prelude::*};
use tempfile::TempDir;
use testbed::{
    flight::{configuration::of_trace, fly_on, started},
    score::{Settings, score},
    trace::{BodyFrame, EarthFrame, Keys, Trace},
};

/// Any finite f32 by its bits: subnormals, both zeros and the extremes.
fn finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite())
}

fn vector() -> impl Strategy<Value = [f32; 3]> {
    [finite(), finite(), finite()]
}

fn sample() -> impl Strategy<Value = Sample> {
    let sensors = (option::of(vector()), option::of(vector()), option::of(vector()), option::of(finite()));
    sensors.prop_map(|(gyro, accel, mag, temperature)| {
        let mut flags = SampleFlags::empty();
        flags.set(SampleFlags::GYRO_MISSING, gyro.is_none());
        flags.set(SampleFlags::ACCEL_MISSING, accel.is_none());
        flags.set(SampleFlags::MAG_MISSING, mag.is_none());
        flags.set(SampleFlags::TEMPERATURE_MISSING, temperature.is_none());
        Sample {
            t_us: 0,
            gyro_rad_s: gyro.unwrap_or_default(),
            accel_m_s2: accel.unwrap_or_default(),
            mag_ut: mag.unwrap_or_default(),
            temperature_c: temperature.unwrap_or_default(),
            flags,
        }
    })
}

fn unit_quaternion() -> impl Strategy<Value = [f64; 4]> {
    [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0, -1.0..1.0].prop_filter_map("not zero", |q| {
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        (norm > 0.1).then(|| q.map(|x| x / norm))
    })
}

fn keys() -> impl Strategy<Value = Keys> {
    let positive = || option::of(1e-3..1e3_f64);
    let sentence = || option::of("[a-z]( ?[=#,\"a-z]){0,9}");
    let texts = (sentence(), sentence(), option::of("[A-Z0-9.]{1,9}"), any::<[bool; 3]>());
    let whose = (option::of("[A-Z0-9]{1,9}"), option::of(0..100_000_u64));
    let earth = (option::of(-180.0..180.0_f64), positive(), positive(), option::of(-90.0..90.0_f64));
    let true_p = option::of(proptest::array::uniform9(-2.0..2.0_f64));
    let sensors = ([positive(), positive(), positive()], option::of(0.0..0.1_f64), true_p);
    let motion = option::of(prop_oneof![Just(Motion::Hand), Just(Motion::DrillString)]);
    (texts, earth, option::of(-90.0..90.0_f64), sensors, motion, whose).prop_map(
        |(
            (source, changes, licence, [enu, tool, reference_north]),
            (declination, gravity, field, dip),
            latitude,
            (scales, delay, true_gyro_p),
            motion,
            (serial, day),
        )| {
            Keys {
                earth_frame: if enu { EarthFrame::Enu } else { EarthFrame::Ned },
                body_frame: if tool { BodyFrame::Tool } else { BodyFrame::Sensor },
                magnetic_declination_deg: declination,
                gravity_m_s2: gravity,
                magnetic_field_ut: field,
                dip_deg: dip,
                latitude_deg: latitude,
                gyro_full_scale_rad_s: scales[0],
                accel_full_scale_m_s2: scales[1],
                mag_full_scale_ut: scales[2],
                gyro_delay_s: delay,
                true_gyro_p,
                motion,
                serial,
                date: day.map(|day| chrono::NaiveDate::default() + chrono::Days::new(day)),
                reference_north,
                source,
                changes,
                licence,
            }
        },
    )
}

fn trace() -> impl Strategy<Value = Trace> {
    let row =
        (1..u64::MAX / 64, sample(), option::of(unit_quaternion()), any::<[bool; 2]>(), [finite(), finite(), finite()]);
    (keys(), vec(row, 1..20), any::<[bool; 4]>()).prop_map(|(keys, rows, [reference, movement, rest, true_rate])| {
        let mut trace = Trace { keys, ..Trace::default() };
        let mut t_us = 0;
        for (step, sample, ..) in &rows {
            t_us += step;
            trace.samples.push(Sample { t_us, ..*sample });
        }
        if reference {
            trace.reference = rows.iter().map(|row| row.2).collect();
        }
        trace.movement = movement.then(|| rows.iter().map(|row| row.3[0]).collect());
        trace.rest = rest.then(|| rows.iter().map(|row| row.3[1]).collect());
        trace.true_rate = true_rate.then(|| rows.iter().map(|row| row.4.map(f64::from)).collect());
        trace.mark_clipped(&trace.keys.full_scale());
        trace
    })
}

fn bits(trace: &Trace) -> Vec<[u32; 10]> {
    let of = |v: [f32; 3]| v.map(f32::to_bits);
    let sample = |s: &Sample| {
        let ([gx, gy, gz], [ax, ay, az], [mx, my, mz]) = (of(s.gyro_rad_s), of(s.accel_m_s2), of(s.mag_ut));
        [gx, gy, gz, ax, ay, az, mx, my, mz, s.temperature_c.to_bits()]
    };
    trace.samples.iter().map(sample).collect()
}

proptest! {
    #[test]
    fn a_written_trace_reads_back_to_the_last_bit(mut trace in trace(), gz: bool) {
        let directory = TempDir::new().unwrap();
        trace.path = directory.path().join(if gz { "trace.csv.gz" } else { "trace.csv" });
        trace.write(&trace.path).unwrap();
        let read = Trace::read(&trace.path).unwrap();
        prop_assert_eq!(bits(&read), bits(&trace));
        prop_assert_eq!(&read, &trace);
        let first = fs::read(&trace.path).unwrap();
        read.write(&trace.path).unwrap();
        prop_assert_eq!(fs::read(&trace.path).unwrap(), first);
    }

    #[test]
    fn damage_never_panics_and_never_lets_a_bad_number_through(
        trace in trace(),
        gz: bool,
        damage in vec((any::<prop::sample::Index>(), prop_oneof![any::<u8>(), prop::sample::select(&b",\n\r\"#=.-+eE0 \xef\xbb\xbf"[..])]), 1..8),
        keep in option::of(any::<prop::sample::Index>()),
    ) {
        let directory = TempDir::new().unwrap();
        let path = directory.path().join(if gz { "trace.csv.gz" } else { "trace.csv" });
        trace.write(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        for (place, byte) in damage {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if let Some(keep) = keep {
            bytes.truncate(keep.index(bytes.len()));
        }
        fs::write(&path, &bytes).unwrap();
        match Trace::read(&path) {
            Ok(read) => {
                prop_assert!(!read.samples.is_empty());
                prop_assert!(read.samples.windows(2).all(|pair| pair[0].t_us < pair[1].t_us));
                let readings = |s: &Sample| [s.gyro_rad_s, s.accel_m_s2, s.mag_ut, [s.temperature_c; 3]];
                let finite = read.samples.iter().flat_map(readings).flatten().all(f32::is_finite);
                prop_assert!(finite, "a non-finite reading got through");
                prop_assert!(read.reference.is_empty() || read.reference.len() == read.samples.len());
            }
            Err(error) => prop_assert!(error.to_string().starts_with(&path.display().to_string())),
        }
    }
}

#[test]
fn columns_come_in_any_order_with_quotes_blanks_and_carriage_returns() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("trace.csv");
    let text = "\u{feff}# Earth_note = a = b\r\n# gravity_m_s2 = 9.81\r\n# just words\r\n\
                \"az\", \"ay\" ,ax,gz,gy,gx,t_s,px,qz,qy,qx,qw,movement\r\n\
                9.5,0.25,-1,3,2,1,1e-3,far,0,0,0,1,1\r\n\
                9.5,,-1,3,,1,0.0020004,,0,0,0,,0\r\n\
                9.5,0,-1,3,2,1,0.003,,0,0,0,0,\r\n";
    fs::write(&path, text).unwrap();
    let trace = Trace::read(&path).unwrap();
    assert_eq!(trace.keys.gravity_m_s2, Some(9.81));
    assert_eq!(trace.samples.iter().map(|s| s.t_us).collect::<Vec<_>>(), [1_000, 2_000, 3_000]);
    assert_eq!(trace.samples[0].gyro_rad_s, [1.0, 2.0, 3.0]);
    assert_eq!(trace.samples[0].accel_m_s2, [-1.0, 0.25, 9.5]);
    let no_mag = SampleFlags::MAG_MISSING | SampleFlags::TEMPERATURE_MISSING;
    assert_eq!(trace.samples[0].flags, no_mag);
    assert_eq!(trace.samples[1].flags, no_mag | SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING);
    assert_eq!(trace.samples[1].gyro_rad_s, [0.0; 3]);
    assert_eq!(trace.reference, [Some([1.0, 0.0, 0.0, 0.0]), None, None]);
    assert_eq!(trace.movement, Some(vec![true, false, false]));
    assert_eq!(trace.rest, None);
    let notes = [
        "ignored keys: Earth_note",
        "ignored columns: px",
        "1 reference quaternions are far from unit norm and count as missing",
    ];
    assert_eq!(trace.notes, notes);
}

/// A recording with a reference, rests, a gap, and more bytes than stay in memory; and a trace that was simulated.
#[test]
fn a_trace_in_a_temporary_file_flies_and_scores_as_one_in_memory() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("long.csv.gz");
    let mut long = rig::files::recording(rig::files::FAST_ROTATION);
    let (period_us, span_us) = (u64::from(long.nominal_period_us()), long.duration_us());
    let copies: Vec<Trace> = (0..3).map(|_| long.clone()).collect();
    for (k, copy) in (1..).zip(copies) {
        // Each copy behind a gap of half a second.
        let later = |sample: Sample| Sample { t_us: sample.t_us + k * (span_us + period_us + 500_000), ..sample };
        long.samples.extend(copy.samples.into_iter().map(later));
        long.reference.extend(copy.reference);
        for (all, more) in [(&mut long.movement, copy.movement), (&mut long.rest, copy.rest)] {
            all.iter_mut().for_each(|all| all.extend(more.iter().flatten()));
        }
    }
    long.rest = Some(long.samples.iter().map(|sample| sample.t_us % 20_000_000 < 1_000_000).collect());
    long.write(&path).unwrap();
    let [held, spooled] = [Trace::read(&path).unwrap(), Trace::spooled(&path).unwrap()];
    assert!(spooled.is_spooled() && spooled.samples.is_empty() && held.len() > 100_000);
    assert!(held.rows().eq(spooled.rows()));
    assert_eq!(held.facts(), spooled.facts());
    let config = of_trace(&held);
    assert_eq!(config, of_trace(&spooled));
    let [in_memory, in_a_file] =
        [&held, &spooled].map(|trace| fly_on(started(&config, None, None).unwrap(), trace, |_| {}));
    assert!(in_a_file.outputs.is_empty() && in_memory.outputs().eq(in_a_file.outputs()));
    assert_eq!(in_memory.reports, in_a_file.reports);
    let scores = [(&held, &in_memory), (&spooled, &in_a_file)].map(|(trace, flight)| {
        (score(trace, flight, &Settings::of(trace, &config, flight)), diagnosed(trace, &config, flight).residual)
    });
    assert_eq!(scores[0], scores[1]);
    let of_held = scores[0].0.unwrap();
    assert!(of_held.orientation_2s_rms_deg.with_effects.is_some() && of_held.attitude_rms_deg.total.is_some());
    spooled.all_read().and(in_a_file.all_read()).unwrap();
}

#[test]
fn a_key_that_is_given_twice_is_told() {
    let text = "# dip_deg = 60\n# source = a\n# dip_deg = 70\n# note = b\n# note = c\nt_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n";
    let trace = Trace::of_bytes(text.as_bytes()).unwrap();
    assert_eq!(trace.keys.dip_deg, Some(70.0));
    assert_eq!(
        trace.notes,
        ["ignored keys: note, note", "keys given more than once, of which the last counts: dip_deg"]
    );
}
