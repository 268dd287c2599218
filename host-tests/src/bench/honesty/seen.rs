//! Errors of a flight against the simulator's truth, and how they compare with what the probe said.

use meerkat_mwd::attitude::AttitudeFlags;
use nalgebra::{Quaternion, UnitQuaternion};

use crate::{flight::Flight, trace::Trace};

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

/// Largest errors over a stretch of a flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub inclination_deg: f64,
    /// Of azimuth and toolface; in a vertical hole of the magnetic toolface.
    pub heading_deg: f64,
    /// In stated deviations, of samples that no flag marks.
    pub sigmas: f64,
    /// Root mean square of the whole attitude, degrees.
    pub rms_deg: f64,
}

/// Errors from a time on, seconds.
pub(super) fn seen(trace: &Trace, flight: &Flight, from_s: f64) -> Seen {
    let (mut seen, mut squares, mut count) = (Seen::default(), 0.0, 0.0);
    for output in &flight.outputs {
        let index = trace.samples.partition_point(|sample| sample.t_us < output.t_us);
        let truth = trace.reference.get(index).copied().flatten();
        let (Some(attitude), Some([w, x, y, z])) = (output.attitude.as_ref(), truth) else { continue };
        if output.t_us as f64 * 1e-6 < from_s {
            continue;
        }
        let truth = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let [w, x, y, z] = attitude.q.map(f64::from);
        let found = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let total = found.angle_to(&truth).to_degrees();
        (squares, count) = (squares + total * total, count + 1.0);
        let c = truth.to_rotation_matrix();
        let apart = |a: f32, b: f64| libm::remainder(f64::from(a) - b, std::f64::consts::TAU).abs();
        let inclination = c[(2, 0)].hypot(c[(2, 1)]).atan2(c[(2, 2)]);
        let mut errors = vec![(apart(attitude.inclination_rad, inclination), attitude.sigma_inclination_rad, false)];
        if inclination.to_degrees() > INCLINED_DEG {
            let azimuth = apart(attitude.azimuth_rad, c[(1, 2)].atan2(c[(0, 2)]));
            let toolface = apart(attitude.gravity_toolface_rad, c[(2, 1)].atan2(-c[(2, 0)]));
            errors.push((azimuth, attitude.sigma_azimuth_rad, true));
            errors.push((toolface, attitude.sigma_toolface_rad, true));
        } else {
            let toolface = (c[(1, 0)] - c[(0, 1)]).atan2(c[(0, 0)] + c[(1, 1)]);
            errors.push((apart(attitude.magnetic_toolface_rad, toolface), attitude.sigma_toolface_rad, true));
        }
        let is_flagged = attitude.flags.intersects(FLAGGED);
        for (error, sigma, is_heading) in errors {
            let worst = if is_heading { &mut seen.heading_deg } else { &mut seen.inclination_deg };
            *worst = worst.max(error.to_degrees());
            if !is_flagged {
                seen.sigmas = seen.sigmas.max(error / f64::from(sigma));
            }
        }
    }
    seen.rms_deg = (squares / count).sqrt();
    seen
}
