//! Attitude error against the reference, split into heading and inclination.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{Settings, gap_us, root_mean_square};
use crate::{
    flight::Flight,
    trace::{Row, Trace},
};

/// Attitude error, degrees rms: q_error = q_estimate q_reference^-1, both body to earth, so that the error is
/// in the earth frame (Laidig et al. 2021, Data 6(7), section 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct AttitudeRms {
    /// The whole angle.
    pub total: Option<f64>,
    /// The part about the vertical.
    pub heading: Option<f64>,
    /// The rest: the smallest rotation about a horizontal axis that remains.
    pub inclination: Option<f64>,
}

/// An attitude at its time of validity: microseconds; body to NED, scalar first.
pub type TimedAttitude = (u64, [f64; 4]);

/// Scores every attitude at whose time there is a reference (and `movement`, if the trace has it).
///
/// Total and heading are `None` where the reference counts from true north and the flight, without a
/// declination, from magnetic.
pub(super) fn rms_deg(trace: &Trace, flight: &Flight, settings: &Settings) -> AttitudeRms {
    let attitudes = attitudes_of(flight);
    let Some(reference_to_ned) = reference_to_ned(trace, settings) else {
        let comparable = errors(trace, attitudes, settings, trace.keys.earth_frame.to_ned());
        return AttitudeRms {
            inclination: root_mean_square(comparable.map(|(_, e)| split(&e).inclination)),
            ..AttitudeRms::default()
        };
    };
    rms_of(errors(trace, attitudes, settings, reference_to_ned).map(|(_, e)| split(&e)))
}

/// Attitude error of any estimate: as it is, and with one constant heading offset taken out, because a
/// reference may count from another north. The offset minimises the sum of squared sines of half the heading
/// error.
#[must_use]
pub fn attitude_rms_deg(trace: &Trace, attitudes: &[TimedAttitude], settings: &Settings) -> [AttitudeRms; 2] {
    let Some(reference_to_ned) = reference_to_ned(trace, settings) else { return Default::default() };
    let errors: Vec<_> = errors(trace, attitudes.iter().copied(), settings, reference_to_ned).map(|(_, e)| e).collect();
    // Angles are doubled because a quaternion and its negative are one rotation.
    let (sine, cosine) = errors.iter().fold((0.0, 0.0), |(sine, cosine), e| {
        let heading = 2.0 * e.k.atan2(e.w);
        (sine + heading.sin(), cosine + heading.cos())
    });
    let offset = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, -f64::atan2(sine, cosine)));
    [UnitQuaternion::identity(), offset].map(|turn| rms_of(errors.iter().map(|e| split(&(turn * e)))))
}

/// Errors over time whose root mean square [`AttitudeRms`] is: seconds, heading and inclination in degrees.
/// Empty if the two norths cannot be related.
#[must_use]
pub fn attitude_errors_deg(trace: &Trace, flight: &Flight, settings: &Settings) -> Vec<[f64; 3]> {
    let Some(reference_to_ned) = reference_to_ned(trace, settings) else { return Vec::new() };
    let timed = |(t_us, e): (u64, UnitQuaternion<f64>)| {
        let error = split(&e);
        [t_us as f64 * 1e-6, error.heading, error.inclination]
    };
    errors(trace, attitudes_of(flight), settings, reference_to_ned).map(timed).collect()
}

/// The reference's attitudes at the trace's samples, in the frame that the flight reports in. Empty if the two norths
/// cannot be related.
#[must_use]
pub fn reference_attitudes(trace: &Trace, settings: &Settings) -> Vec<(u64, UnitQuaternion<f64>)> {
    let Some(reference_to_ned) = reference_to_ned(trace, settings) else { return Vec::new() };
    let known = |row: Row| Some((row.sample.t_us, reference_to_ned * unit_quaternion(row.reference?)?));
    trace.rows().filter_map(known).collect()
}

/// Attitudes of a flight, at their times of validity.
pub fn attitudes_of(flight: &Flight) -> impl Iterator<Item = TimedAttitude> + '_ {
    flight.outputs().filter_map(|output| Some((output.t_us, output.attitude.as_ref()?.q.map(f64::from))))
}

fn rms_of(errors: impl Iterator<Item = Error>) -> AttitudeRms {
    let (mut count, mut sums) = (0_usize, [0.0; 3]);
    for error in errors {
        count += 1;
        let parts = [error.total, error.heading, error.inclination];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part * part);
    }
    let [total, heading, inclination] = sums.map(|sum| (count > 0).then(|| (sum / count as f64).sqrt()));
    AttitudeRms { total, heading, inclination }
}

/// A trace's quaternion, normalised because it was printed with few digits; `None` if it is no rotation.
pub fn unit_quaternion([w, x, y, z]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
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
    attitudes: impl Iterator<Item = TimedAttitude> + 'a,
    settings: &'a Settings,
    reference_to_ned: UnitQuaternion<f64>,
) -> impl Iterator<Item = (u64, UnitQuaternion<f64>)> + 'a {
    let mut references = References::of(trace);
    attitudes.filter(|(t_us, _)| *t_us >= settings.from_us).filter_map(move |(t_us, q)| {
        let reference = reference_to_ned * references.at(t_us)?;
        Some((t_us, unit_quaternion(q)? * reference.inverse()))
    })
}

/// Splits an error into heading, the twist about the vertical, and inclination, the swing that is left.
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

/// The reference at times of validity, which mostly go forward, as the rows do.
struct References<'a> {
    trace: &'a Trace,
    gap_us: f64,
    rows: Box<dyn Iterator<Item = Row> + 'a>,
    /// The last row before the time that was asked for.
    before: Option<Row>,
    /// The first row from there on.
    after: Option<Row>,
}

impl<'a> References<'a> {
    fn of(trace: &'a Trace) -> Self {
        let mut rows = trace.rows();
        let after = rows.next();
        Self { trace, gap_us: gap_us(trace), rows, before: None, after }
    }

    /// The reference at a time, interpolated between samples.
    fn at(&mut self, t_us: u64) -> Option<UnitQuaternion<f64>> {
        if self.before.is_some_and(|before| before.sample.t_us >= t_us) {
            *self = Self::of(self.trace);
        }
        while let Some(after) = self.after.filter(|after| after.sample.t_us < t_us) {
            (self.before, self.after) = (Some(after), self.rows.next());
        }
        let scored = |row: &Row| row.reference.filter(|_| row.moves).and_then(unit_quaternion);
        let next = self.after.as_ref()?;
        if next.sample.t_us == t_us {
            return scored(next);
        }
        let previous = self.before.as_ref()?;
        let before_us = previous.sample.t_us;
        let (step, elapsed) = ((next.sample.t_us - before_us) as f64, (t_us - before_us) as f64);
        if step > self.gap_us { None } else { scored(previous)?.try_slerp(&scored(next)?, elapsed / step, 1e-9) }
    }
}

/// Rotation from the trace's earth frame to the frame the flight reports in: NED, with true north if a
/// declination was configured, else magnetic. `None` if the two norths cannot be related.
fn reference_to_ned(trace: &Trace, settings: &Settings) -> Option<UnitQuaternion<f64>> {
    let declination = settings.declination_deg.or(trace.keys.magnetic_declination_deg);
    let north = match (trace.keys.reference_north, settings.declination_deg, declination) {
        (false, None, _) | (true, Some(_), _) => 0.0,
        (false, Some(east_of_true), _) => east_of_true,
        (true, None, Some(east_of_true)) => -east_of_true,
        (true, None, None) => return None,
    };
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, north.to_radians()));
    Some(turn * trace.keys.earth_frame.to_ned())
}
