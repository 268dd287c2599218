//! Readings at full scale.

use meerkat_mwd::{Sample, attitude::AttitudeFlags, config::FullScale, identification::Refusal};

use crate::rig::run::{Run, flagged, refusal, run, saturated};

/// Full scale of the gyro that clips this share of the samples, and the samples so clipped.
fn clipping(run: &mut Run, share: f64) -> Vec<Sample> {
    let mut largest: Vec<f32> = run
        .trace
        .samples
        .iter()
        .map(|s| s.gyro_rad_s.iter().map(|x| x.abs()).max_by(f32::total_cmp).unwrap())
        .collect();
    largest.sort_by(f32::total_cmp);
    let limit = largest[((1.0 - share) * (largest.len() - 1) as f64) as usize];
    run.config.full_scale.gyro_rad_s = Some(limit);
    run.with(|_, s| s.gyro_rad_s = saturated(s.gyro_rad_s, limit))
}

fn at_full_scale(samples: &[Sample], limit: f32) -> usize {
    samples.iter().filter(|s| s.gyro_rad_s.iter().any(|x| x.abs() >= 0.998 * limit)).count()
}

#[test]
fn clipped_gyro_readings_are_counted_flagged_and_bend_nothing() {
    for seed in [1, 2, 3] {
        let mut run = run(100.0, seed);
        let samples = clipping(&mut run, 0.05);
        let expected = at_full_scale(&samples, run.config.full_scale.gyro_rad_s.unwrap());
        let flight = run.fly(&samples);
        assert!(expected >= 500);
        assert_eq!(flight.counters.clipped as usize, expected);
        assert_eq!(flagged(&flight, AttitudeFlags::GYRO_CLIPPED), expected);
        assert!(flight.reports.iter().all(|report| run.identified(report)), "seed {seed}");

        let run = run.calibrated();
        let (total, tilt) = run.rms_deg(&run.fly(&samples), 5.0, 100.0);
        println!("    attitude {total:.2} deg, tilt {tilt:.2} deg");
        assert!(total < 6.0 && tilt < 3.0);
    }
}

#[test]
fn when_all_are_clipped_nothing_is_identified_and_the_reason_is_the_gyro() {
    let mut run = run(60.0, 3);
    run.config.full_scale.gyro_rad_s = Some(1e-4);
    let flight = run.fly(&run.trace.samples);
    assert_eq!(flight.counters.clipped as usize, run.trace.samples.len());
    assert!(matches!(refusal(&flight.reports[0]), Some(Refusal::GyroUnusable { share }) if share > 0.99));
    assert_eq!(flight.reports[0].flown, run.config.gyro);
    assert_eq!(flight.reports[0].rest_s, 0.0);
}

#[test]
fn clipped_vectors_are_not_used_either() {
    let clean = run(60.0, 3);
    let full_scale = clean.config.full_scale;
    for (full_scale, flag) in [
        (FullScale { accel_m_s2: Some(1e-3), ..full_scale }, AttitudeFlags::empty()),
        (FullScale { mag_ut: Some(1e-3), ..full_scale }, AttitudeFlags::MAG_UNUSED),
    ] {
        let mut run = run(60.0, 3);
        run.config.full_scale = full_scale;
        let flight = run.fly(&run.trace.samples);
        assert_eq!(flight.counters.clipped as usize, run.trace.samples.len());
        if flag.is_empty() {
            assert_eq!(refusal(&flight.reports[0]), Some(Refusal::NoAccelerometer));
            assert!(flight.outputs.iter().all(|o| o.attitude.is_none()));
        } else {
            assert_eq!(flagged(&flight, flag), run.trace.samples.len());
        }
        run.never_worse_than_bias_only(&flight);
    }
}

/// Shocks that saturate the accelerometer, as the simulated ones of 20 g do a 4 g part.
#[test]
fn shocks_beyond_the_accelerometers_range_cost_little() {
    for seed in [1, 2, 3] {
        let mut run = run(60.0, seed);
        let limit = 4.0 * 9.806_65;
        run.config.full_scale.accel_m_s2 = Some(limit);
        let samples = run.with(|_, s| s.accel_m_s2 = saturated(s.accel_m_s2, limit));
        let flight = run.fly(&samples);
        assert!(flight.counters.clipped > 0);
        println!("seed {seed}: {} clipped", flight.counters.clipped);
        assert!(run.identified(&flight.reports[0]));
    }
}
