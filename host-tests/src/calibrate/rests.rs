//! Rests of a trace, by the library's detector, and the vector sensors' means over them.

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    magnet::rest::{Reading, RestDetector, RestLimits},
    probe::GAP_PERIODS,
};
use nalgebra::Vector3;

/// Starts of the detector within a second. It judges whole seconds, so a rest loses at most this part of one
/// at either end.
const STARTS_PER_SECOND: u32 = 4;

/// Mean of a vector sensor over a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean, in the sensor's unit.
    pub vector: Vector3<f64>,
    /// Standard error of the mean per axis, from the scatter of the readings taken as independent.
    pub sigma: f64,
}

/// One rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Time of its first sample, microseconds.
    pub from_us: u64,
    /// Time of its last sample, microseconds.
    pub to_us: u64,
    /// The accelerometer's mean, m/s^2; `None` without readings, or if any is clipped.
    pub accel: Option<Mean>,
    /// The magnetometer's mean, microtesla; `None` likewise.
    pub mag: Option<Mean>,
    /// True if a vector sensor was at full scale during the rest.
    pub clipped: bool,
}

/// The rests of `samples`, in order.
#[must_use]
pub fn rests(samples: &[Sample], config: &Config) -> Vec<Rest> {
    let mut still = vec![false; samples.len()];
    for start in 0..STARTS_PER_SECOND {
        mark(samples, config, start, &mut still);
    }
    let mut rests = Vec::new();
    let mut from = 0;
    for to in 1..=samples.len() {
        let ends = to == samples.len() || still[to] != still[from] || after_gap(samples, to, config);
        if ends {
            rests.extend(still[from].then(|| Rest::of(&samples[from..to])));
            from = to;
        }
    }
    rests
}

/// Marks the samples of seconds at rest; the first second begins `start` parts of a second after the first
/// sample.
fn mark(samples: &[Sample], config: &Config, start: u32, still: &mut [bool]) {
    let identification = &config.identification;
    let limits = RestLimits {
        deviation_rad_s: identification.rest_gyro_deviation_rad_s,
        bias_rad_s: identification.max_bias_rad_s,
    };
    let mut detector = RestDetector::zero();
    detector.start(config.sample_period_us);
    let skipped = (start * 1_000_000 / STARTS_PER_SECOND / config.sample_period_us.max(1)) as usize;
    let mut first = skipped;
    for (at, sample) in samples.iter().enumerate().skip(skipped) {
        if at > first && after_gap(samples, at, config) {
            detector.start(config.sample_period_us);
            first = at;
        }
        let reading = |vector: [f32; 3], missing, clipped| match sample.flags {
            flags if flags.intersects(missing | SampleFlags::FAULT) => Reading::Missing,
            flags if flags.contains(clipped) => Reading::Unusable,
            _ => Reading::Usable(Vector3::from(vector)),
        };
        let gyro = reading(sample.gyro_rad_s, SampleFlags::GYRO_MISSING, SampleFlags::GYRO_CLIPPED);
        let accel = reading(sample.accel_m_s2, SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED);
        let mag = reading(sample.mag_ut, SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED);
        if let Some(judged) = detector.push(gyro, accel, mag, &limits) {
            if judged.is_some() {
                still[first..=at].fill(true);
            }
            first = at + 1;
        }
    }
}

fn after_gap(samples: &[Sample], at: usize, config: &Config) -> bool {
    at > 0 && samples[at].t_us - samples[at - 1].t_us > u64::from(GAP_PERIODS) * u64::from(config.sample_period_us)
}

impl Rest {
    fn of(samples: &[Sample]) -> Self {
        let mean = |vector: fn(&Sample) -> [f32; 3], missing: SampleFlags, clipped: SampleFlags| {
            let read = || samples.iter().filter(|sample| !sample.flags.intersects(missing | SampleFlags::FAULT));
            let any_clipped = read().any(|sample| sample.flags.contains(clipped));
            // A clipped reading is only a bound, and a mean without it would be of the others alone.
            (
                mean(read().map(|sample| Vector3::from(vector(sample)).map(f64::from))).filter(|_| !any_clipped),
                any_clipped,
            )
        };
        let (accel, accel_clipped) = mean(|s| s.accel_m_s2, SampleFlags::ACCEL_MISSING, SampleFlags::ACCEL_CLIPPED);
        let (mag, mag_clipped) = mean(|s| s.mag_ut, SampleFlags::MAG_MISSING, SampleFlags::MAG_CLIPPED);
        let time = |sample: Option<&Sample>| sample.map_or(0, |sample| sample.t_us);
        Self {
            from_us: time(samples.first()),
            to_us: time(samples.last()),
            accel,
            mag,
            clipped: accel_clipped || mag_clipped,
        }
    }
}

/// Mean and standard error; `None` for readings without scatter (fewer than two, or a frozen sensor).
fn mean(vectors: impl Iterator<Item = Vector3<f64>> + Clone) -> Option<Mean> {
    let count = vectors.clone().count() as f64;
    let vector = vectors.clone().sum::<Vector3<f64>>() / count;
    let square: f64 = vectors.map(|v| (v - vector).norm_squared()).sum();
    (count >= 2.0 && square > 0.0).then(|| Mean { vector, sigma: (square / (3.0 * (count - 1.0) * count)).sqrt() })
}
