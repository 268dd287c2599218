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

/// Length over which force is averaged in the earth's frame, microseconds: vibration averages out.
const BLOCK_US: u64 = 1_000_000;

/// Blocks that are looked at, spread evenly over the trace.
const BLOCKS: u64 = 600;

/// A way to read a reference: its earth frame, and whether it turns from earth to body.
type Convention = (EarthFrame, bool);

/// A note if the reference's vertical is not that of gravity, with the convention in which it is.
pub(crate) fn convention_note(trace: &Trace, accel: &VectorModel) -> Option<String> {
    let stated = trace.keys.earth_frame;
    let (name, other, key) = match stated {
        EarthFrame::Ned => ("NED", EarthFrame::Enu, "ENU"),
        EarthFrame::Enu => ("ENU", EarthFrame::Ned, "NED"),
    };
    let all = [(stated, false), (other, false), (stated, true), (other, true)];
    let [off, others @ ..] = medians_deg(trace, accel, all)?;
    if off < DOUBTED_DEG {
        return None;
    }
    let words = [
        format!("its earth frame looks like {key}: earth_frame = {key}"),
        format!("it looks like a turn from {name} to the body: change the signs of qx, qy, qz"),
        format!("it looks like a turn from {key} to the body: change the signs of qx, qy, qz, and earth_frame = {key}"),
    ];
    let likely = words.into_iter().zip(others).find(|(_, off)| *off < LIKELY_DEG).map(|(what, _)| what);
    let likely = likely.unwrap_or_else(|| "no usual convention fits better".to_owned());
    Some(format!("the reference's vertical is {off:.0} deg off gravity at the median; {likely}"))
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
