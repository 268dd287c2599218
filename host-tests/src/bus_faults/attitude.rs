//! Effect of a fault on the attitude.

use super::motion::{BEFORE_US, Motion};
use meerkat_mwd::{Config, Probe, Sample};
use nalgebra::{Quaternion, UnitQuaternion};

/// Attitudes over time: microseconds, body to NED.
pub type Flown = Vec<(u64, UnitQuaternion<f64>)>;

/// Flies samples with the default configuration at the sensors' rate. Some seconds of the same motion as good
/// sensors would see it come first, so that the attitude has settled.
#[must_use]
pub fn fly(motion: &Motion, samples: &[(u64, Sample)]) -> Flown {
    let mut probe = Box::new(Probe::new());
    let config = Config { sample_period_us: 4_808, ..Config::default() };
    if probe.configure(&config).is_err() {
        return Vec::new();
    }
    for sample in &motion.before {
        probe.push(sample);
    }
    let later = |sample: &Sample| Sample { t_us: sample.t_us + BEFORE_US, ..*sample };
    let outputs = samples.iter().filter_map(|(_, sample)| probe.push(&later(sample)));
    let attitude = outputs.filter_map(|output| Some((output.t_us, output.attitude?.q)));
    attitude.map(|(t_us, q)| (t_us, unit(q.map(f64::from)))).collect()
}

fn unit([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// Largest angle between two flights at the same times (to half a period), degrees.
#[must_use]
pub fn difference_deg(a: &Flown, b: &Flown) -> f64 {
    let mut others = b.iter().peekable();
    let mut largest = 0.0_f64;
    for (t_us, q) in a {
        while others.next_if(|(other_us, _)| other_us + 2_000 < *t_us).is_some() {}
        if let Some((_, other)) = others.peek().filter(|(other_us, _)| other_us.abs_diff(*t_us) < 2_000) {
            largest = largest.max(q.angle_to(other).to_degrees());
        }
    }
    largest
}
