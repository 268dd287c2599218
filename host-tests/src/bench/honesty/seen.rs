//! Errors of a flight against the simulator's truth, and how they compare with what the probe said.

use meerkat_mwd::attitude::{Attitude, AttitudeFlags};
use nalgebra::{Quaternion, UnitQuaternion};

use testbed::{flight::Flight, trace::Trace};

/// Flags of samples of which the probe says that something is amiss.
const FLAGGED: AttitudeFlags = AttitudeFlags::GYRO_HELD
    .union(AttitudeFlags::GYRO_CLIPPED)
    .union(AttitudeFlags::ACCEL_UNUSED)
    .union(AttitudeFlags::MAG_UNUSED)
    .union(AttitudeFlags::FROZEN_SENSOR)
    .union(AttitudeFlags::FAULT)
    .union(AttitudeFlags::AFTER_GAP)
    .union(AttitudeFlags::NO_HEADING);
/// Inclination from which azimuth and gravity toolface are scored, degrees.
const INCLINED_DEG: f64 = 10.0;
/// Stated deviations beyond which an attitude is wrong: once in two million by chance.
const BEYOND: f64 = 5.0;

/// Largest errors over a stretch of a flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub inclination_deg: f64,
    /// Error of azimuth and toolface; in a vertical hole, of the magnetic toolface.
    pub heading_deg: f64,
    /// In stated deviations, of samples that no flag marks.
    pub sigmas: f64,
    /// Root mean square of the whole attitude, degrees.
    pub rms_deg: f64,
}

/// Error of one angle and its stated deviation, radians.
#[derive(Clone, Copy, Debug)]
struct AngleError {
    error_rad: f64,
    sigma_rad: f32,
    /// True for azimuth and toolface.
    is_heading: bool,
}

impl AngleError {
    fn in_sigmas(&self) -> f64 {
        counted(self.error_rad / f64::from(self.sigma_rad))
    }
}

/// A figure as it is judged: what is no number is worse than any.
pub(super) fn counted(figure: f64) -> f64 {
    if figure.is_nan() { f64::INFINITY } else { figure }
}

/// Errors of inclination, azimuth and gravity toolface; near the vertical of the magnetic toolface in place of the last
/// two.
fn errors(attitude: &Attitude, truth: &UnitQuaternion<f64>) -> Vec<AngleError> {
    let c = truth.to_rotation_matrix();
    let of = |found: f32, truth: f64, sigma_rad: f32, is_heading: bool| AngleError {
        error_rad: libm::remainder(f64::from(found) - truth, std::f64::consts::TAU).abs(),
        sigma_rad,
        is_heading,
    };
    let inclination = c[(2, 0)].hypot(c[(2, 1)]).atan2(c[(2, 2)]);
    let of_inclination = of(attitude.inclination_rad, inclination, attitude.sigma_inclination_rad, false);
    if inclination.to_degrees() > INCLINED_DEG {
        let (azimuth, toolface) = (c[(1, 2)].atan2(c[(0, 2)]), c[(2, 1)].atan2(-c[(2, 0)]));
        vec![
            of_inclination,
            of(attitude.azimuth_rad, azimuth, attitude.sigma_azimuth_rad, true),
            of(attitude.gravity_toolface_rad, toolface, attitude.sigma_toolface_rad, true),
        ]
    } else {
        let toolface = (c[(1, 0)] - c[(0, 1)]).atan2(c[(0, 0)] + c[(1, 1)]);
        vec![of_inclination, of(attitude.magnetic_toolface_rad, toolface, attitude.sigma_toolface_rad, true)]
    }
}

/// Time, estimate and truth of every sample of a flight that has both.
fn compared<'a>(
    trace: &'a Trace,
    flight: &'a Flight,
) -> impl Iterator<Item = (f64, Attitude, UnitQuaternion<f64>)> + 'a {
    flight.outputs.iter().filter_map(|output| {
        let index = trace.samples.partition_point(|sample| sample.t_us < output.t_us);
        let [w, x, y, z] = trace.reference.get(index).copied().flatten()?;
        let truth = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Some((output.t_us as f64 * 1e-6, output.attitude?, truth))
    })
}

/// Errors from a time on, seconds.
pub(super) fn seen(trace: &Trace, flight: &Flight, from_s: f64) -> Seen {
    let (mut seen, mut squares, mut count) = (Seen::default(), 0.0, 0.0);
    for (_, attitude, truth) in compared(trace, flight).filter(|(t_s, ..)| *t_s >= from_s) {
        let [w, x, y, z] = attitude.q.map(f64::from);
        let found = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let total = found.angle_to(&truth).to_degrees();
        (squares, count) = (squares + total * total, count + 1.0);
        let is_flagged = attitude.flags.intersects(FLAGGED);
        for of in errors(&attitude, &truth) {
            let worst = if of.is_heading { &mut seen.heading_deg } else { &mut seen.inclination_deg };
            let error_deg = of.error_rad.to_degrees();
            *worst = worst.max(if is_flagged { error_deg } else { counted(error_deg) });
            if !is_flagged {
                seen.sigmas = seen.sigmas.max(of.in_sigmas());
            }
        }
    }
    seen.rms_deg = (squares / count).sqrt();
    seen
}

/// Attitudes of a flight that no flag marks, and those of them that are wrong.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unflagged {
    /// Attitudes without a flag.
    pub count: usize,
    /// Those of them of which an angle is off by more than five of its deviations.
    pub beyond: usize,
    /// Largest error in stated deviations.
    pub worst: f64,
    /// Its time, seconds.
    pub worst_s: f64,
    /// Longest stretch of attitudes beyond, seconds.
    pub longest_s: f64,
}

/// Errors of the attitudes that no flag marks, from a time on, seconds.
pub fn unflagged(trace: &Trace, flight: &Flight, from_s: f64) -> Unflagged {
    let mut all = Unflagged::default();
    let mut since_s = None;
    for (t_s, attitude, truth) in compared(trace, flight).filter(|(t_s, ..)| *t_s >= from_s) {
        let sigmas = errors(&attitude, &truth).iter().map(AngleError::in_sigmas).fold(0.0, f64::max);
        let is_unflagged = !attitude.flags.intersects(FLAGGED);
        let is_beyond = is_unflagged && sigmas > BEYOND;
        all.count += usize::from(is_unflagged);
        all.beyond += usize::from(is_beyond);
        if is_unflagged && sigmas > all.worst {
            (all.worst, all.worst_s) = (sigmas, t_s);
        }
        since_s = if is_beyond { Some(since_s.unwrap_or(t_s)) } else { None };
        all.longest_s = all.longest_s.max(since_s.map_or(0.0, |since_s| t_s - since_s));
    }
    all
}

#[cfg(test)]
mod tests {
    use meerkat_mwd::{Sample, probe::Output};

    use super::*;

    /// Attitude of a level tool at its truth, stated to a milliradian.
    const RIGHT: Attitude = Attitude {
        q: [1.0, 0.0, 0.0, 0.0],
        inclination_rad: 0.0,
        azimuth_rad: 0.0,
        gravity_toolface_rad: 0.0,
        magnetic_toolface_rad: 0.0,
        sigma_inclination_rad: 1e-3,
        sigma_azimuth_rad: 1e-3,
        sigma_toolface_rad: 1e-3,
        flags: AttitudeFlags::empty(),
    };

    /// Both judgements of one attitude.
    fn judged(attitude: Attitude) -> (Seen, Unflagged) {
        let sample = Sample { t_us: 1, ..Sample::default() };
        let trace = Trace { samples: vec![sample], reference: vec![Some([1.0, 0.0, 0.0, 0.0])], ..Trace::default() };
        let output = Output { t_us: 1, rate_rad_s: [0.0; 3], attitude: Some(attitude) };
        let flight = Flight { outputs: vec![output], ..Flight::default() };
        (seen(&trace, &flight, 0.0), unflagged(&trace, &flight, 0.0))
    }

    #[test]
    fn what_is_no_number_is_beyond_any_sigmas_unless_a_flag_marks_it() {
        let (seen, unflagged) = judged(RIGHT);
        assert_eq!((seen.sigmas, unflagged.beyond, unflagged.worst), (0.0, 0, 0.0));
        for wrong in [
            Attitude { inclination_rad: f32::NAN, ..RIGHT },
            Attitude { magnetic_toolface_rad: f32::NAN, ..RIGHT },
            Attitude { sigma_toolface_rad: f32::NAN, ..RIGHT },
        ] {
            let (seen, unflagged) = judged(wrong);
            assert_eq!(seen.sigmas, f64::INFINITY, "{wrong:?}");
            assert_eq!((unflagged.count, unflagged.beyond, unflagged.worst), (1, 1, f64::INFINITY), "{wrong:?}");
            let (seen, unflagged) = judged(Attitude { flags: AttitudeFlags::FAULT, ..wrong });
            assert_eq!((seen.sigmas, unflagged.beyond), (0.0, 0));
        }
        let (seen, _) = judged(Attitude { inclination_rad: f32::NAN, ..RIGHT });
        assert_eq!(seen.inclination_deg, f64::INFINITY);
    }
}
