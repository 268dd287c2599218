//! Random errors are recovered within the stated uncertainty.

use mwd::calibrate::{SensorCalibration, Verdict, calibrate};

use crate::turntable::{FIELD_UT, Probe, Random, all_around};

const SEEDS: u64 = 60;
const RESTS: usize = 24;

/// Number of the 95 % intervals that hold the truth.
fn covered(sensor: &SensorCalibration, truth: &[f64; 9]) -> usize {
    let (sigma, quantile) = (sensor.fit.sigma(), sensor.fit.quantile());
    (0..9).filter(|&k| (sensor.fit.x[k] - truth[k]).abs() < quantile * sigma[k]).count()
}

/// Asserts that 90 to 98 % of `count` intervals hold the truth.
fn assert_coverage(what: &str, covered: usize, count: usize) {
    let share = covered as f64 / count as f64;
    println!("{what}: {:.1} % of {count} intervals hold the truth", 100.0 * share);
    assert!((0.90..=0.98).contains(&share), "{what}: {share}");
}

#[test]
fn nine_in_ten_intervals_and_not_all_hold_the_truth() {
    let (mut calibrated, mut accel, mut mag, mut scaled) = (0, 0, 0, 0);
    for seed in 0..SEEDS {
        let mut random = Random::new(seed);
        let probe = Probe::drawn(&mut random);
        let attitudes = all_around(RESTS, &mut random);
        let mut trace = probe.turned(&attitudes, &mut random);
        let found = calibrate(std::slice::from_ref(&trace), None, None).unwrap();
        let sensor = found.accel.unwrap();
        calibrated += usize::from(sensor.verdict == Verdict::Calibrated);
        let check = sensor.held_out.as_ref().unwrap();
        assert!(check.after < 0.1 * check.before, "{check:?}");
        accel += covered(&sensor, &probe.accel_errors);
        let sensor = found.mag.unwrap();
        assert_eq!(sensor.verdict, Verdict::Calibrated, "seed {seed}");
        mag += covered(&sensor, &probe.mag_errors);

        trace.keys.magnetic_field_ut = None;
        let sensor = calibrate(&[trace], None, None).unwrap().mag.unwrap();
        assert!(!sensor.norm_known);
        let mean = 1.0 + (probe.mag_errors[..3].iter().sum::<f64>()) / 3.0;
        assert!((sensor.norm * mean / FIELD_UT - 1.0).abs() < 1e-3, "seed {seed}: {}", sensor.norm);
        // Without the field's strength only scales relative to their mean can be known.
        let mut relative = probe.mag_errors;
        relative[..3].iter_mut().for_each(|x| *x = (1.0 + *x) / mean - 1.0);
        relative[3..6].iter_mut().for_each(|x| *x /= mean);
        scaled += covered(&sensor, &relative);
    }
    // Some random sets of attitudes leave a direction uncertain by more than 0.3 deg, and are reported so.
    assert!(calibrated as u64 >= SEEDS * 9 / 10, "{calibrated}");
    let count = 9 * SEEDS as usize;
    assert_coverage("accelerometer", accel, count);
    assert_coverage("magnetometer", mag, count);
    assert_coverage("magnetometer in a field of unknown strength", scaled, count);
}

#[test]
fn a_rest_that_was_pushed_is_left_out() {
    let mut random = Random::new(100);
    let probe = Probe::drawn(&mut random);
    let attitudes = all_around(RESTS, &mut random);
    let mut trace = probe.turned(&attitudes, &mut random);
    // The fifth rest, 0.2 m/s^2 on one axis.
    for sample in &mut trace.samples[4 * 450..4 * 450 + 300] {
        sample.accel_m_s2[0] += 0.2;
    }
    let sensor = calibrate(&[trace], None, None).unwrap().accel.unwrap();
    assert_eq!(sensor.verdict, Verdict::Calibrated);
    assert_eq!(sensor.left_out(), 1);
    assert!(!sensor.fit.used[4]);
    assert!(covered(&sensor, &probe.accel_errors) >= 7);
}

#[test]
fn a_magnetometer_that_sits_askew_is_turned() {
    let mut inside = 0;
    for seed in 0..20 {
        let mut random = Random::new(200 + seed);
        let mut probe = Probe::drawn(&mut random);
        probe.mag_turn_rad = random.normal3() * 0.02;
        let attitudes = all_around(RESTS, &mut random);
        let found = calibrate(&[probe.turned(&attitudes, &mut random)], None, None).unwrap();
        let alignment = found.alignment.unwrap();
        assert_eq!(alignment.refused, None, "seed {seed}");
        assert!(alignment.scatter_rad.1 < 0.5 * alignment.scatter_rad.0, "{alignment:?}");
        let error = |k: usize| (alignment.turn_rad[k] - probe.mag_turn_rad[k]).abs();
        inside += (0..3).filter(|&k| error(k) < alignment.quantile * alignment.sigma_rad[k]).count();
    }
    // The magnetometer's own errors are not in these deviations, so fewer hold the truth than of the
    // parameters.
    assert!(inside >= 45, "{inside} of 60");
}

/// Traces from a weak and a strong field: each is fitted to its own.
#[test]
fn each_trace_has_the_field_of_its_place() {
    for seed in 0..5 {
        let mut random = Random::new(400 + seed);
        let mut probe = Probe::drawn(&mut random);
        let mut traces: Vec<_> = [35.0, 60.0]
            .into_iter()
            .map(|field_ut| {
                probe.field_ut = field_ut;
                let attitudes = all_around(RESTS / 2, &mut random);
                probe.turned(&attitudes, &mut random)
            })
            .collect();
        let found = calibrate(&traces, None, None).unwrap();
        let sensor = found.mag.as_ref().unwrap();
        assert_eq!(sensor.verdict, Verdict::Calibrated, "seed {seed}");
        assert_eq!((sensor.norms(), sensor.norm_known), ([35.0, 60.0], true));
        assert!(covered(sensor, &probe.mag_errors) >= 7, "seed {seed}: {:?}", sensor.fit.x);
        assert!(!found.notes.iter().any(|note| note.contains("one place")), "{:?}", found.notes);

        // A third one that states none could be of either place.
        traces.push(traces[0].clone());
        traces[2].keys.magnetic_field_ut = None;
        let sensor = calibrate(&traces, None, None).unwrap().mag.unwrap();
        assert!(
            matches!(&sensor.verdict, Verdict::Kept(why) if why.contains("one states none")),
            "{:?}",
            sensor.verdict
        );
    }
}

#[test]
fn traces_that_state_no_field_are_taken_to_be_of_one_place_and_that_is_said() {
    let mut random = Random::new(410);
    let probe = Probe::drawn(&mut random);
    let attitudes = all_around(RESTS, &mut random);
    let mut traces = vec![probe.turned(&attitudes, &mut random); 2];
    traces.iter_mut().for_each(|trace| trace.keys.magnetic_field_ut = None);
    let said =
        |traces: &[_]| calibrate(traces, None, None).unwrap().notes.iter().any(|note| note.contains("one place"));
    assert!(said(&traces) && !said(&traces[..1]));
}
