//! Attitude against the reference, split into heading and inclination.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{Settings, gap_us, root_mean_square};
use crate::{
    flight::Flight,
    trace::{EarthFrame, Trace},
};

/// Attitude error, degrees rms: q_error = q_estimate q_reference^-1, both body to earth, so that the error is in the earth frame
/// (Laidig et al. 2021, Data 6(7), section 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct AttitudeRms {
    /// The whole angle.
    pub total: Option<f64>,
    /// The part about the vertical.
    pub heading: Option<f64>,
    /// The rest: the smallest rotation about a horizontal axis that remains.
    pub inclination: Option<f64>,
}

/// Scores every output whose time has a reference, with `movement` where the trace says.
///
/// Total and heading are `None` where the reference counts from true north and the flight, without a declination, from magnetic.
pub(super) fn rms_deg(trace: &Trace, flight: &Flight, settings: &Settings) -> AttitudeRms {
    let Some(reference_to_ned) = reference_to_ned(trace, settings) else {
        let comparable = errors(trace, flight, settings, to_ned(trace.keys.earth_frame));
        return AttitudeRms {
            inclination: root_mean_square(comparable.map(|e| e.inclination)),
            ..AttitudeRms::default()
        };
    };
    let errors: Vec<Error> = errors(trace, flight, settings, reference_to_ned).collect();
    let rms = |part: fn(&Error) -> f64| root_mean_square(errors.iter().map(part));
    AttitudeRms { total: rms(|e| e.total), heading: rms(|e| e.heading), inclination: rms(|e| e.inclination) }
}

/// A quaternion of a trace, normalised (it was printed with few digits); `None` for one that is no rotation.
pub(super) fn unit_quaternion([w, x, y, z]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)
}

/// One sample's attitude error, degrees.
struct Error {
    total: f64,
    heading: f64,
    inclination: f64,
}

fn errors<'a>(
    trace: &'a Trace,
    flight: &'a Flight,
    settings: &'a Settings,
    reference_to_ned: UnitQuaternion<f64>,
) -> impl Iterator<Item = Error> + 'a {
    flight.outputs.iter().filter(|output| output.t_us >= settings.from_us).filter_map(move |output| {
        let estimate = unit_quaternion(output.attitude.as_ref()?.q.map(f64::from))?;
        let reference = reference_to_ned * reference_at(trace, output.t_us)?;
        Some(split(&(estimate * reference.inverse())))
    })
}

/// Heading is the twist about the vertical, inclination the swing that is left.
fn split(error: &UnitQuaternion<f64>) -> Error {
    let (w, v) = (error.w, error.imag());
    let horizontal = v.x.hypot(v.y);
    // By atan2: the arc cosine of the definition loses half the digits near zero.
    let angle = |sine: f64, cosine: f64| (2.0 * sine.atan2(cosine)).to_degrees();
    Error {
        total: angle(v.norm(), w.abs()),
        heading: angle(v.z.abs(), w.abs()),
        inclination: angle(horizontal, w.hypot(v.z)),
    }
}

/// The reference at a time of validity, interpolated between samples where it falls between two.
fn reference_at(trace: &Trace, t_us: u64) -> Option<UnitQuaternion<f64>> {
    let scored = |i: usize| {
        let moving = trace.movement.as_ref().is_none_or(|m| m.get(i).copied().unwrap_or(false));
        trace.reference.get(i).copied().flatten().filter(|_| moving).and_then(unit_quaternion)
    };
    let after = trace.samples.partition_point(|s| s.t_us < t_us);
    let next = trace.samples.get(after)?;
    if next.t_us == t_us {
        return scored(after);
    }
    let before = after.checked_sub(1)?;
    let previous = trace.samples.get(before)?;
    let (step, elapsed) = ((next.t_us - previous.t_us) as f64, (t_us - previous.t_us) as f64);
    let gap = step > gap_us(trace);
    if gap { None } else { scored(before)?.try_slerp(&scored(after)?, elapsed / step, 1e-9) }
}

fn to_ned(frame: EarthFrame) -> UnitQuaternion<f64> {
    match frame {
        // North and east change places and down is minus up: half a turn about the bisector of north and east.
        EarthFrame::Enu => {
            let half = std::f64::consts::FRAC_1_SQRT_2;
            UnitQuaternion::new_unchecked(Quaternion::new(0.0, half, half, 0.0))
        }
        EarthFrame::Ned => UnitQuaternion::identity(),
    }
}

/// From the trace's earth frame to the one in which the flight reports: NED, true north if a declination was configured, else
/// magnetic. `None` where the two norths cannot be related.
fn reference_to_ned(trace: &Trace, settings: &Settings) -> Option<UnitQuaternion<f64>> {
    let declination = settings.declination_deg.or(trace.keys.magnetic_declination_deg);
    let north = match (trace.keys.reference_north, settings.declination_deg, declination) {
        (false, None, _) | (true, Some(_), _) => 0.0,
        (false, Some(east_of_true), _) => east_of_true,
        (true, None, Some(east_of_true)) => -east_of_true,
        (true, None, None) => return None,
    };
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, north.to_radians()));
    Some(turn * to_ned(trace.keys.earth_frame))
}
