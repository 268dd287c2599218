//! Sensors that read the same for ever, and sensors that read nothing but zeros.

use meerkat_mwd::{Sample, attitude::AttitudeFlags, identification::Refusal};
use testbed::simulate::Scenario;

use crate::rig::{
    files::scenario,
    run::{Run, accepted, flagged, of_scenario, refusal, run, within},
};

const GYRO: usize = 0;
const ACCEL: usize = 1;
const MAG: usize = 2;

fn reading(sample: &mut Sample, sensor: usize) -> &mut [f32; 3] {
    match sensor {
        GYRO => &mut sample.gyro_rad_s,
        ACCEL => &mut sample.accel_m_s2,
        _ => &mut sample.mag_ut,
    }
}

/// The sensor keeps its reading of sample `from` until sample `to`.
fn frozen(run: &Run, sensor: usize, from: usize, to: usize) -> Vec<Sample> {
    let mut first = run.trace.samples[from];
    let kept = *reading(&mut first, sensor);
    run.with(|index, sample| {
        if (from..to).contains(&index) {
            *reading(sample, sensor) = kept;
        }
    })
}

#[test]
fn a_sensor_that_is_frozen_for_a_second_is_flagged_until_it_moves() {
    let run = run(30.0, 3);
    let second = 100;
    for sensor in [GYRO, ACCEL, MAG] {
        for (from, to) in [(0, 3_001), (1_500, 3_001), (1_500, 1_900), (1_500, 1_550)] {
            let flight = run.fly(&frozen(&run, sensor, from, to));
            let expected = (to - from).saturating_sub(1 + second);
            assert_eq!(flagged(&flight, AttitudeFlags::FROZEN_SENSOR), expected, "sensor {sensor}, {from} to {to}");
        }
    }
}

#[test]
fn a_frozen_gyro_is_never_identified_from() {
    for seed in [1, 2, 3] {
        let run = run(120.0, seed);
        let end = run.trace.samples.len();
        let flight = run.fly(&frozen(&run, GYRO, 0, end));
        assert_eq!(flight.reports.len(), 3);
        for report in &flight.reports {
            assert!(matches!(refusal(report), Some(Refusal::GyroUnusable { share }) if share > 0.97), "{report:?}");
            assert_eq!(report.flown, run.config.gyro);
        }
        // In the middle of the first window, and of the second: what was read before is enough, or is
        // refused.
        for from in [3_000, 6_000] {
            let flight = run.fly(&frozen(&run, GYRO, from, end));
            let last = flight.reports.last().unwrap();
            assert!(matches!(refusal(last), Some(Refusal::GyroUnusable { .. })), "{last:?}");
            run.never_worse_than_bias_only(&flight);
            let mut taken = flight.reports.iter().filter(|r| accepted(r));
            assert!(taken.all(|report| run.identified(report)), "seed {seed} gyro frozen from {from}");
        }
    }
}

/// A gyro that goes dead in the middle of a turn and reads zeros, or its bias, from then on.
#[test]
fn a_gyro_that_dies_to_zeros_while_turning_bends_nothing_that_flies() {
    for seed in [1, 2, 3, 4, 5, 6] {
        let run = run(120.0, seed);
        for dead in [[0.0; 3], run.truth.gyro.b_rad_s] {
            for (from, to) in [(3_000, 3_300), (3_000, 12_001), (4_700, 12_001), (6_000, 6_500)] {
                let samples =
                    run.with(|index, s| s.gyro_rad_s = if (from..to).contains(&index) { dead } else { s.gyro_rad_s });
                let flight = run.fly(&samples);
                let report = &flight.reports[0];
                assert!(run.identified(report), "seed {seed}, dead from {from} to {to}: {report:?}");
                run.never_worse_than_bias_only(&flight);
            }
        }
    }
}

#[test]
fn what_a_sensor_reads_in_its_first_frozen_moments_bends_nothing() {
    for seed in [1, 2, 3] {
        let run = run(56.0, seed);
        for sensor in [GYRO, ACCEL, MAG] {
            // Three seconds out of the drilling.
            let flight = run.fly(&frozen(&run, sensor, 3_000, 3_300));
            assert!(run.identified(&flight.reports[0]), "seed {seed} sensor {sensor}: {:?}", flight.reports[0]);
        }
    }
}

#[test]
fn with_a_frozen_gyro_the_attitude_knows_that_it_does_not_know_and_comes_back() {
    let run = run(120.0, 3).calibrated();
    let end = run.trace.samples.len();
    let dead = run.fly(&frozen(&run, GYRO, 6_000, end));
    let tilt = run.rms_deg(&dead, 65.0, 120.0).1;
    let ratio = run.worst_tilt_in_sigmas(&dead, 5.0);
    println!("dead gyro: tilt {tilt:.2} deg, worst {ratio:.2} sigma");
    assert!(tilt < 20.0 && ratio < 4.0);
    assert!(within(&dead, 65.0, 120.0).all(|o| o.attitude.unwrap().sigma_azimuth_rad > 1.0));

    let back = run.fly(&frozen(&run, GYRO, 6_000, 6_500));
    let (total, tilt) = run.rms_deg(&back, 67.0, 75.0);
    println!("two seconds after five frozen ones: {total:.2} deg, tilt {tilt:.2} deg");
    assert!(total < 3.0 && tilt < 1.5);
}

#[test]
fn a_frozen_accelerometer_bends_no_p_and_widens_the_tilt() {
    let run = run(120.0, 3);
    let end = run.trace.samples.len();
    for from in [0, 3_000, 6_000] {
        let flight = run.fly(&frozen(&run, ACCEL, from, end));
        let without = refusal(&flight.reports[0]) == Some(Refusal::NoAccelerometer);
        assert_eq!(without, from == 0, "{:?}", flight.reports[0]);
        assert!(flagged(&flight, AttitudeFlags::ACCEL_UNUSED) >= end - from - 12);
        run.never_worse_than_bias_only(&flight);
    }
    let run = run.calibrated();
    let flight = run.fly(&frozen(&run, ACCEL, 6_000, end));
    let (total, tilt) = run.rms_deg(&flight, 60.0, 120.0);
    let ratio = run.worst_tilt_in_sigmas(&flight, 5.0);
    println!("a minute without accelerometer: {total:.2} deg, tilt {tilt:.2} deg, worst {ratio:.2} sigma");
    assert!(tilt < 6.0 && ratio < 4.0);
}

/// Without a magnetometer no P flies, and none harms.
fn without_magnetometer(spoil: impl Fn(&Run) -> Vec<Sample>) {
    for name in ["drilling_45deg.toml", "drilling_vertical.toml"] {
        let run = of_scenario(&Scenario { duration_s: 120.0, ..scenario(name) }, 3);
        let flight = run.fly(&spoil(&run));
        let count = run.trace.samples.len();
        assert_eq!(flagged(&flight, AttitudeFlags::MAG_UNUSED | AttitudeFlags::NO_HEADING), count);
        assert!(flagged(&flight, AttitudeFlags::FROZEN_SENSOR) >= count - 101);
        run.never_worse_than_bias_only(&flight);
        let tilt = run.rms_deg(&flight, 60.0, 120.0).1;
        println!("{name}: tilt {tilt:.2} deg");
        assert!(tilt < 15.0);

        let restless = of_scenario(&Scenario { duration_s: 60.0, rest_s: 0.0, ..scenario(name) }, 3);
        let flight = restless.fly(&spoil(&restless));
        // Never at rest, and so nobody told the bias either: what flies is the factory's model.
        assert!(flight.reports.iter().all(|report| {
            matches!(refusal(report), Some(Refusal::NoMagnetometer { .. })) && report.flown == restless.config.gyro
        }));

        let mut uncalibrated = spoil(&run);
        uncalibrated.iter_mut().for_each(|s| s.accel_m_s2[2] -= 0.6);
        run.never_worse_than_bias_only(&run.fly(&uncalibrated));
    }
}

#[test]
fn an_all_zero_magnetometer_is_no_magnetometer() {
    without_magnetometer(|run| run.with(|_, s| s.mag_ut = [0.0; 3]));
}

#[test]
fn a_magnetometer_that_is_frozen_from_the_start_is_none_either() {
    without_magnetometer(|run| frozen(run, MAG, 0, run.trace.samples.len()));
}

#[test]
fn a_magnetometer_that_freezes_later_leaves_the_model_and_a_widening_heading() {
    let run = run(120.0, 3);
    let end = run.trace.samples.len();
    let flight = run.fly(&frozen(&run, MAG, 6_000, end));
    assert!(accepted(&flight.reports[0]));
    run.never_worse_than_bias_only(&flight);
    let run = run.calibrated();
    let flight = run.fly(&frozen(&run, MAG, 6_000, end));
    let (total, tilt) = run.rms_deg(&flight, 60.0, 120.0);
    println!("a minute without magnetometer: {total:.2} deg, tilt {tilt:.2} deg");
    assert!(total < 8.0 && tilt < 1.5);
    let sigma = |at_s: f64| within(&flight, at_s, at_s + 0.1).next().unwrap().attitude.unwrap().sigma_azimuth_rad;
    assert!(sigma(119.0) > 1.5 * sigma(59.0), "{} {}", sigma(59.0), sigma(119.0));
}

#[test]
fn an_all_zero_accelerometer_gives_no_attitude_and_no_p() {
    let run = run(60.0, 3);
    let flight = run.fly(&run.with(|_, s| s.accel_m_s2 = [0.0; 3]));
    assert!(flight.outputs.iter().all(|o| o.attitude.is_none()), "there is no direction to start from");
    assert_eq!(refusal(&flight.reports[0]), Some(Refusal::NoAccelerometer));
}

#[test]
fn a_frozen_sensor_is_found_between_missing_readings() {
    let run = run(10.0, 3);
    let mut samples = frozen(&run, ACCEL, 0, run.trace.samples.len());
    samples.iter_mut().step_by(3).for_each(|s| s.accel_m_s2[0] = f32::NAN);
    let flight = run.fly(&samples);
    assert!(flagged(&flight, AttitudeFlags::FROZEN_SENSOR) > 500);
}
