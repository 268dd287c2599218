//! Readings that a broken driver may hand over: NaN, infinities, numbers that no sensor can read.

use meerkat_mwd::{Sample, attitude::AttitudeFlags};

use crate::rig::run::{Dice, accepted, flagged, run};

const ABSURD: [f32; 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, f32::MAX, f32::MIN, 1e5];

fn put(sample: &mut Sample, field: usize, value: f32) {
    match field {
        0..3 => sample.gyro_rad_s[field] = value,
        3..6 => sample.accel_m_s2[field - 3] = value,
        6..9 => sample.mag_ut[field - 6] = value,
        _ => sample.temperature_c = value,
    }
}

/// One absurd number in any field is as if that sensor had not been read once.
#[test]
fn one_absurd_number_anywhere_costs_its_sensor_that_reading() {
    let run = run(60.0, 3);
    for field in 0..10 {
        for value in ABSURD {
            for full_scale in [run.config.full_scale, meerkat_mwd::config::FullScale::default()] {
                let mut config = run.config;
                config.full_scale = full_scale;
                let samples = run.with(|index, s| {
                    if index == 3_000 {
                        put(s, field, value);
                    }
                });
                let flight = crate::rig::run::flown(&config, &samples);
                let report = &flight.reports[0];
                assert!(run.identified(report), "{field} {value} {report:?}");
                let held = u32::from(field < 3);
                assert_eq!((flight.counters.gyro_missing, flight.counters.clipped), (held, 0), "{field} {value}");
            }
        }
    }
}

#[test]
fn one_absurd_reading_in_thirty_leaves_attitude_and_identification_alive() {
    for seed in [1, 2, 3] {
        let run = run(60.0, seed);
        let mut dice = Dice::new(seed);
        let samples = run.with(|_, s| {
            if dice.roll() < 0.033 {
                let value = ABSURD[(dice.roll() * 8.0) as usize];
                put(s, (dice.roll() * 10.0) as usize, value);
            }
        });
        let flight = run.fly(&samples);
        assert!(flight.outputs.iter().all(|o| o.attitude.is_some()));
        assert_eq!(flagged(&flight, AttitudeFlags::GYRO_HELD), flight.counters.gyro_missing as usize);
        assert!(run.identified(&flight.reports[0]), "seed {seed}");
    }
}

#[test]
fn nothing_but_absurd_numbers_is_no_reading_at_all() {
    let run = run(60.0, 3);
    for value in ABSURD {
        let samples = run.with(|_, s| (0..10).for_each(|field| put(s, field, value)));
        let flight = run.fly(&samples);
        assert_eq!(flight.counters.gyro_missing as usize, samples.len());
        assert!(flight.outputs.iter().all(|o| o.attitude.is_none()));
        assert!(flight.reports.iter().all(|r| !accepted(r)));
    }
}

/// Just inside what is believed: large, wrong, and finite all the way.
#[test]
fn readings_at_the_edge_of_belief_stay_finite() {
    let run = run(60.0, 3);
    let mut dice = Dice::new(5);
    let samples = run.with(|_, s| {
        if dice.roll() < 0.1 {
            let sign = |x: f64| if x < 0.5 { -1.0 } else { 1.0 };
            s.gyro_rad_s = [0; 3].map(|_| 999.0 * sign(dice.roll()));
            s.accel_m_s2 = [0; 3].map(|_| 9_999.0 * sign(dice.roll()));
            s.mag_ut = [0; 3].map(|_| 9_999.0 * sign(dice.roll()));
        }
    });
    run.never_worse_than_bias_only(&run.fly(&samples));
    let mut unknown = run.config;
    unknown.full_scale = meerkat_mwd::config::FullScale::default();
    let flight = crate::rig::run::flown(&unknown, &samples);
    run.never_worse_than_bias_only(&flight);
}
