//! Judgement of a run: which samples are wrong, and which wrong samples nothing flags.

use super::{motion::Motion, run::Run};
use meerkat_mwd::{Sample, SampleFlags};

/// A sensor of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// The gyro.
    Gyro,
    /// The accelerometer.
    Accelerometer,
    /// The magnetometer.
    Magnetometer,
}

/// Judgement of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// Readings that are wrong and not flagged: time, sensor, and error as a multiple of the noise.
    pub wrong: Vec<(u64, Sensor, f64)>,
    /// Times of readings of gyro and accelerometer that are flagged missing, microseconds.
    pub flagged: Vec<u64>,
    /// Time of the first sample after the fault that is missing or has a flagged reading, microseconds.
    pub first_bad_us: Option<u64>,
    /// Time from which all readings come and are good, microseconds.
    pub well_from_us: Option<u64>,
}

/// Largest error of a good time stamp, microseconds: polled stamps are promised to a period. Without a fault
/// they are within 1.5 ms.
const STAMP_US: u64 = 4_900;
/// Largest age of a field reading, microseconds: axes are measured one after the other, the first 6 ms before
/// the output, and join an inertial reading up to a period later.
const FIELD_AGE_US: u64 = 11_000;
/// Step between samples above which there is a gap, microseconds.
const GAP_US: u64 = 7_500;
/// Silence of the magnetometer that counts as a gap, microseconds.
const FIELD_GAP_US: u64 = 30_000;

/// Tolerances of a good reading: noise, half a code, and a thousandth of the gain. Gyro, accelerometer,
/// magnetometer.
const TOLERANCE: [f32; 3] = [0.012, 0.065, 0.15];

/// Time after a fault from which one or two flagged readings are a false alarm, microseconds: runs without a
/// fault have them too.
const ALONE_AFTER_US: u64 = 100_000;

/// Largest time between samples of two runs that come from the same conversion, microseconds.
const SAME_US: u64 = 2_400;

/// Judges a run whose fault is over at `over_us`. `alarms` are times of readings that are flagged even
/// without a fault; they are not charged to it.
#[must_use]
pub fn judge(motion: &Motion, run: &Run, over_us: u64, alarms: &[u64]) -> Judgement {
    let mut judgement = Judgement::default();
    let (mut last_us, mut field_us) = (None::<u64>, None::<u64>);
    let mut flagged_in_a_row = 0;
    for (_, sample) in &run.samples {
        let mut bad = last_us.is_some_and(|last| sample.t_us.saturating_sub(last) > GAP_US);
        last_us = Some(sample.t_us);
        let mut flagged = false;
        for (sensor, of, missing, age_us) in SENSORS {
            if sample.flags.contains(missing) {
                flagged |= sensor != Sensor::Magnetometer;
                continue;
            }
            if sensor == Sensor::Magnetometer {
                field_us = Some(sample.t_us);
            }
            let error = excess(motion, sample, of, age_us, TOLERANCE[sensor as usize]);
            if error > 0.0 {
                judgement.wrong.push((sample.t_us, sensor, f64::from(error / TOLERANCE[sensor as usize])));
                bad = true;
            }
        }
        if flagged {
            judgement.flagged.push(sample.t_us);
        }
        let alarm = alarms.iter().any(|t_us| t_us.abs_diff(sample.t_us) < SAME_US);
        let flagged = flagged && !alarm;
        flagged_in_a_row = if flagged { flagged_in_a_row + 1 } else { 0 };
        bad |= flagged && (flagged_in_a_row > 2 || sample.t_us < over_us + ALONE_AFTER_US);
        bad |= field_us.is_some_and(|last| sample.t_us.saturating_sub(last) > FIELD_GAP_US);
        if bad {
            judgement.first_bad_us = judgement.first_bad_us.or(Some(sample.t_us));
            judgement.well_from_us = None;
        } else if judgement.well_from_us.is_none() {
            judgement.well_from_us = Some(sample.t_us);
        }
    }
    judgement
}

type Of = fn(&Sample) -> [f32; 3];
const SENSORS: [(Sensor, Of, SampleFlags, u64); 3] = [
    (Sensor::Gyro, |sample| sample.gyro_rad_s, SampleFlags::GYRO_MISSING, 0),
    (Sensor::Accelerometer, |sample| sample.accel_m_s2, SampleFlags::ACCEL_MISSING, 0),
    (Sensor::Magnetometer, |sample| sample.mag_ut, SampleFlags::MAG_MISSING, FIELD_AGE_US),
];

/// Distance of a reading from all values that the truth had about its time.
fn excess(motion: &Motion, sample: &Sample, of: Of, age_us: u64, tolerance: f32) -> f32 {
    let range = motion.range(of, sample.t_us.saturating_sub(STAMP_US + age_us), sample.t_us + STAMP_US);
    let axes = of(sample).into_iter().zip(range);
    let over = axes.flat_map(|(x, (least, most))| [least - tolerance - x, x - most - tolerance]);
    over.fold(0.0, |most, x| if x > most { x } else { most })
}
