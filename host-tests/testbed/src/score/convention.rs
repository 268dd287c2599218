//! Convention of a trace's reference: its vertical is held against gravity, because a reference of another convention
//! scores as an attitude that is wrong.

use meerkat_mwd::{SampleFlags, compensation::VectorModel};
use nalgebra::Vector3;

use super::attitude::unit_quaternion;
use crate::trace::{EarthFrame, Trace};

/// Median angle between the reference's vertical and gravity from which the convention is doubted, degrees: motion and
/// errors of the accelerometer stay below it at the median.
const DOUBTED_DEG: f64 = 25.0;

/// Median angle below which another convention is the likely one, degrees.
const LIKELY_DEG: f64 = 10.0;

/// Angle to magnetic north within which an axis is called north, degrees: a third of the way to the next axis, and more
/// than the declination where people live.
const NORTH_DEG: f64 = 30.0;

/// Least share of the mean field across the vertical, of a field that tells north: a dip of 84 deg.
const LEAST_ACROSS: f64 = 0.1;

/// Length over which force is averaged in the earth's frame, microseconds: vibration averages out.
const BLOCK_US: u64 = 1_000_000;

/// Blocks that are looked at, spread evenly over the trace.
const BLOCKS: u64 = 600;

/// A way to read a reference: its earth frame, and whether it turns from earth to body.
type Convention = (EarthFrame, bool);

/// A note if the reference's vertical is not that of gravity, with the convention in which it is.
pub fn convention_note(trace: &Trace, accel: &VectorModel) -> Option<String> {
    let stated = trace.keys.earth_frame;
    let (name, other) = match stated {
        EarthFrame::Ned => ("NED", EarthFrame::Enu),
        EarthFrame::Enu => ("ENU", EarthFrame::Ned),
        EarthFrame::Nwu => ("NWU", EarthFrame::Ned),
    };
    let all = [(stated, false), (other, false), (stated, true), (other, true)];
    let [off, others @ ..] = medians_deg(trace, accel, all)?;
    if off < DOUBTED_DEG {
        return None;
    }
    let likely = match others.iter().position(|off| *off < LIKELY_DEG) {
        Some(0) => {
            let (frame, key) = named(trace, other, false);
            format!("its earth frame looks like {frame}: earth_frame = {key}")
        }
        Some(1) => format!("it looks like a turn from {name} to the body: change the signs of qx, qy, qz"),
        Some(_) => {
            let (frame, key) = named(trace, other, true);
            format!(
                "it looks like a turn from {frame} to the body: change the signs of qx, qy, qz, and earth_frame = {key}"
            )
        }
        None => "no usual convention fits better".to_owned(),
    };
    Some(format!("the reference's vertical is {off:.0} deg off gravity at the median; {likely}"))
}

/// Name of an earth frame, and the value of its key: of two whose z points up the one with north where the field is.
fn named(trace: &Trace, frame: EarthFrame, is_conjugate: bool) -> (&'static str, &'static str) {
    if frame == EarthFrame::Ned {
        return ("NED", "NED");
    }
    match north_deg(trace, frame, is_conjugate) {
        Some(north) if north.abs() < NORTH_DEG => ("ENU", "ENU"),
        Some(north) if (north - 90.0).abs() < NORTH_DEG => ("NWU", "NWU"),
        _ => ("ENU", "ENU, or NWU if its x points north"),
    }
}

/// Angle from the reference's north, read in this frame, to that of the mean field, clockwise from above, degrees: 90
/// if x, here east, is north. A hard iron turns with the body and averages out. `None` without a field across the
/// vertical.
fn north_deg(trace: &Trace, frame: EarthFrame, is_conjugate: bool) -> Option<f64> {
    let mut sum = Vector3::<f64>::zeros();
    for row in trace.rows() {
        let Some(q) = row.reference.and_then(unit_quaternion) else { continue };
        if !row.sample.flags.intersects(SampleFlags::MAG_MISSING | SampleFlags::MAG_CLIPPED) {
            let field = Vector3::from(row.sample.mag_ut).cast::<f64>();
            sum += frame.to_ned() * if is_conjugate { q.inverse() * field } else { q * field };
        }
    }
    let across = sum.x.hypot(sum.y);
    (across > LEAST_ACROSS * sum.norm()).then(|| sum.y.atan2(sum.x).to_degrees())
}

/// Median angles between gravity and the vertical of the reference, read by each convention, degrees; `None` where both
/// are never there.
fn medians_deg<const N: usize>(trace: &Trace, accel: &VectorModel, conventions: [Convention; N]) -> Option<[f64; N]> {
    let (first_us, every) = (trace.first_us(), trace.duration_us() / BLOCK_US / BLOCKS + 1);
    let mut angles: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    let (mut block, mut sums) = (0, [Vector3::<f64>::zeros(); N]);
    let mut end = |sums: &mut [Vector3<f64>; N]| {
        for (angles, sum) in angles.iter_mut().zip(std::mem::replace(sums, [Vector3::zeros(); N])) {
            if sum.norm() > 0.0 {
                // Specific force points up at rest.
                angles.push(sum.angle(&-Vector3::z()).to_degrees());
            }
        }
    };
    for row in trace.rows() {
        let now = (row.sample.t_us - first_us) / BLOCK_US;
        if now != block {
            end(&mut sums);
            block = now;
        }
        let Some(q) = row.reference.and_then(unit_quaternion).filter(|_| now.is_multiple_of(every)) else { continue };
        if row.sample.flags.contains(SampleFlags::ACCEL_MISSING) {
            continue;
        }
        let force = accel.calibrate(row.sample.accel_m_s2).cast::<f64>();
        for (sum, (frame, is_conjugate)) in sums.iter_mut().zip(conventions) {
            *sum += frame.to_ned() * if is_conjugate { q.inverse() * force } else { q * force };
        }
    }
    end(&mut sums);
    let mut medians = [0.0; N];
    for (median, angles) in medians.iter_mut().zip(&mut angles) {
        angles.sort_by(f64::total_cmp);
        *median = *angles.get(angles.len() / 2)?;
    }
    Some(medians)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::Sample;
    use nalgebra::UnitQuaternion;

    use super::*;

    /// A trace that turns about all axes, with its reference in one convention and its header in another.
    fn note(stated: EarthFrame, frame: EarthFrame, is_conjugate: bool) -> Option<String> {
        let mut trace = Trace::default();
        trace.keys.earth_frame = stated;
        for k in 0..200_u32 {
            let a = 0.05 * f64::from(k);
            let to_ned = UnitQuaternion::from_euler_angles(a, 0.7 * a.sin(), 0.3 * a);
            let force = to_ned.inverse_transform_vector(&Vector3::new(0.0, 0.0, -9.81)).cast::<f32>();
            trace.samples.push(Sample { t_us: u64::from(k) * 150_000, accel_m_s2: force.into(), ..Sample::default() });
            let q = frame.to_ned().inverse() * to_ned;
            let q = if is_conjugate { q.inverse() } else { q };
            trace.reference.push(Some([q.w, q.i, q.j, q.k]));
        }
        convention_note(&trace, &VectorModel::IDENTITY)
    }

    #[test]
    fn a_reference_of_another_convention_is_named() {
        for frame in [EarthFrame::Ned, EarthFrame::Enu] {
            assert_eq!(note(frame, frame, false), None);
            assert!(note(frame, frame, true).unwrap().ends_with("to the body: change the signs of qx, qy, qz"));
        }
        assert!(note(EarthFrame::Ned, EarthFrame::Enu, false).unwrap().contains("earth_frame = ENU"));
        assert!(note(EarthFrame::Enu, EarthFrame::Ned, false).unwrap().contains("looks like NED"));
        assert!(note(EarthFrame::Ned, EarthFrame::Enu, true).unwrap().contains("from ENU to the body"));
    }
}
