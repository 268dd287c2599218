//! Gravity carried by the gyro from one rest to the next: a score that needs no attitude reference.
//!
//! It is blind to rotation about gravity.

use meerkat_mwd::SampleFlags;
use nalgebra::Vector3;

use super::{PerModel, Settings, Tracks, integrated::Integrated, rates, root_mean_square};
use crate::trace::{Row, Trace};

/// Shortest rest that counts, seconds: the mean of a shorter one still holds motion.
const SHORTEST_REST_S: f64 = 0.5;

/// A rest: time of its middle, and its mean specific force.
#[derive(Clone, Copy, Debug)]
struct Rest {
    middle_s: f64,
    specific_force_m_s2: Vector3<f64>,
}

/// The way from the middle of one rest to the middle of the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    from: Rest,
    to: Rest,
}

/// The legs between consecutive rests from `settings.from_us` on.
pub(super) fn legs(trace: &Trace, settings: &Settings) -> Vec<Leg> {
    let rests = rests(trace, settings);
    rests.iter().zip(rests.iter().skip(1)).map(|(&from, &to)| Leg { from, to }).collect()
}

/// Times at which these legs ask for rotations.
pub(super) fn asked(legs: &[Leg]) -> impl Iterator<Item = [f64; 2]> {
    legs.iter().flat_map(|leg| [leg.from.middle_s, leg.to.middle_s]).map(|t_s| [t_s, t_s])
}

/// Angle between carried and measured direction, degrees rms over the legs that all tracks cover without a
/// gap; `None` without such a leg.
pub(super) fn rms_deg(legs: &[Leg], tracks: &Tracks<Integrated>) -> PerModel {
    let covered = |leg: &&Leg| tracks.cover(leg.from.middle_s, leg.to.middle_s);
    let legs: Vec<Leg> = legs.iter().filter(covered).copied().collect();
    tracks.per_model(|track| {
        let errors: Option<Vec<f64>> = legs.iter().map(|leg| error_deg(leg, track)).collect();
        root_mean_square(errors?)
    })
}

fn error_deg(leg: &Leg, track: &Integrated) -> Option<f64> {
    let to_from = track.rotation(leg.from.middle_s, leg.to.middle_s)?;
    let predicted = to_from.inverse() * leg.from.specific_force_m_s2;
    let measured = leg.to.specific_force_m_s2;
    // By atan2, which is exact for small angles; the arc cosine is not.
    Some(predicted.cross(&measured).norm().atan2(predicted.dot(&measured)).to_degrees())
}

fn rests(trace: &Trace, settings: &Settings) -> Vec<Rest> {
    let start_us = trace.first_us();
    let gap_s = super::gap_us(trace) * 1e-6;
    let unusable = SampleFlags::ACCEL_MISSING | SampleFlags::ACCEL_CLIPPED;
    let mut rests = Vec::new();
    let mut open: Option<OpenRest> = None;
    for Row { sample, rests: at_rest, .. } in trace.rows() {
        let t_s = rates::seconds_since(start_us, sample.t_us);
        let at_rest = at_rest && sample.t_us >= settings.from_us;
        if open.as_ref().is_some_and(|rest| !at_rest || t_s - rest.last_s > gap_s) {
            rests.extend(open.take().and_then(OpenRest::close));
        }
        if at_rest {
            let rest = open.get_or_insert(OpenRest { first_s: t_s, last_s: t_s, sum: Vector3::zeros(), count: 0 });
            rest.last_s = t_s;
            if !sample.flags.intersects(unusable) {
                rest.sum += settings.accel.calibrate(sample.accel_m_s2).map(f64::from);
                rest.count += 1;
            }
        }
    }
    rests.extend(open.and_then(OpenRest::close));
    rests
}

struct OpenRest {
    first_s: f64,
    last_s: f64,
    sum: Vector3<f64>,
    count: u32,
}

impl OpenRest {
    fn close(self) -> Option<Rest> {
        (self.last_s - self.first_s >= SHORTEST_REST_S && self.count > 0).then(|| Rest {
            middle_s: 0.5 * (self.first_s + self.last_s),
            specific_force_m_s2: self.sum / f64::from(self.count),
        })
    }
}
