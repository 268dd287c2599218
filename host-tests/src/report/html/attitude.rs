//! Attitude of a flight: angles with their bands against the reference, the toolface's dial, errors.

use meerkat_mwd::{attitude::Attitude, probe::Output};
use nalgebra::UnitQuaternion;

use super::{Chart, Page, Series, Told, dial, in_s, line, residual::magnets, strip::strip};
use crate::report::toolface::{has_north, is_vertical, toolface_rad};
use testbed::score::{attitude_errors_deg, reference_attitudes};

/// An angle that is not known.
const NONE: [f32; 2] = [f32::NAN, 0.0];

/// Picks an angle and its deviation of an attitude, radians.
type Angle = fn(&Attitude) -> [f32; 2];

/// Inclination, azimuth where north has been seen, and the toolface that applies.
const ANGLES: [Angle; 3] = [
    |a| [a.inclination_rad, a.sigma_inclination_rad],
    |a| if has_north(a) { [a.azimuth_rad, a.sigma_azimuth_rad] } else { NONE },
    |a| [toolface_rad(a), a.sigma_toolface_rad],
];

/// The three angles over the whole recording, small, with their bands.
pub(super) fn strips(told: &Told) -> [String; 3] {
    let span = told.span_s();
    let strip_of = |(name, angle, goes_around): (&str, Angle, bool)| {
        let flown = line("flown", "after", over_time(&told.flight.outputs, angle), span);
        let chart = Chart::new(name, "deg", "", vec![flown]);
        strip(&if goes_around { chart.of_angles() } else { chart }, span)
    };
    let [inclination, azimuth, toolface] = ANGLES;
    [("Inclination", inclination, false), ("Azimuth", azimuth, true), ("Toolface", toolface, true)].map(strip_of)
}

/// Adds angles, dial and errors.
pub(super) fn add(page: &mut Page, told: &Told) {
    let span = told.span_s();
    let marks = magnets(told.diagnosed);
    let references: Vec<(u64, [f64; 3])> =
        reference_attitudes(told.trace, &told.settings()).into_iter().map(|(t_us, q)| (t_us, angles_deg(&q))).collect();
    let is_rare = !references.is_empty() && RARELY * references.len() < told.trace.samples.len();
    let vertical =
        told.flight.outputs.iter().filter(|output| output.attitude.as_ref().is_some_and(is_vertical)).count();
    let mostly_vertical = 2 * vertical > told.flight.outputs.len();
    let toolface =
        if mostly_vertical { "Toolface (magnetic, the hole is near the vertical)" } else { "Toolface (gravity)" };
    let plots = [
        (
            "Inclination",
            "Angle of the tool's axis from the vertical. Dark band: one stated deviation, light band: two.",
        ),
        ("Azimuth", "Direction of the tool's axis from north. A stroke from top to bottom is a passage through north."),
        (toolface, "Turn of the tool about its axis. A stroke from top to bottom is a passage through 0."),
    ];
    let shaded = if marks.is_empty() { "" } else { " Shaded: a magnet is there." };
    for (k, ((name, about), angle)) in plots.into_iter().zip(ANGLES).enumerate() {
        let rare = if is_rare { RARE } else { "" };
        let about = format!("{about}{rare}{shaded}");
        let mut series = Vec::new();
        // In a vertical hole the reference's toolface would have to be the magnetic one.
        let is_magnetic = k == 2 && mostly_vertical;
        if !references.is_empty() && !is_magnetic {
            let points: Vec<[f64; 3]> = references.iter().map(|(t_us, angles)| [in_s(*t_us), angles[k], 0.0]).collect();
            series.push(if is_rare { alone(points) } else { line("reference", "reference", points, span) });
        }
        series.push(line("flown", "after", over_time(&told.flight.outputs, angle), span));
        let chart = Chart::new(name, "deg", &about, series).marked(&marks);
        page.chart(if k == 0 { chart } else { chart.of_angles() });
    }
    dial::add(page, &told.flight.outputs);
    let stated: [(&str, &'static str, Angle); 3] = [
        ("inclination", "x", |a| [a.sigma_inclination_rad, 0.0]),
        ("azimuth", "y", |a| if has_north(a) { [a.sigma_azimuth_rad, 0.0] } else { NONE }),
        ("toolface", "z", |a| [a.sigma_toolface_rad, 0.0]),
    ];
    let stated = stated.map(|(name, class, angle)| line(name, class, over_time(&told.flight.outputs, angle), span));
    let about = format!(
        "How well the probe itself says that it knows each angle: one standard deviation. Where the tool stands vertical, azimuth and \
         gravity toolface are not defined, and theirs rise.{shaded}"
    );
    page.chart(Chart::new("Stated deviations", "deg", &about, stated.into()).of_sizes().marked(&marks));
    errors(page, told);
}

/// A reference that is in fewer than one of so many samples is drawn as points: a line would cut the corners between.
const RARELY: usize = 20;

/// Note about such a reference, for the reader.
const RARE: &str = " The reference was not recorded at every sample: it is drawn as points.";

/// Points of the reference without a line through them.
fn alone(points: Vec<[f64; 3]>) -> Series {
    let apart = points.into_iter().flat_map(|point| [point, [point[0], f64::NAN, 0.0]]).collect();
    Series { name: "reference".to_owned(), class: "reference", points: apart, bridged_s: 0.0, marked: true }
}

fn errors(page: &mut Page, told: &Told) {
    let errors = attitude_errors_deg(told.trace, told.flight, &told.settings());
    let of = |part: usize| -> Vec<[f64; 3]> { errors.iter().map(|error| [error[0], error[part], 0.0]).collect() };
    let span = told.span_s();
    let series: Vec<Series> = vec![line("heading", "y", of(1), span), line("inclination", "x", of(2), span)];
    let about = "Angle between the attitude flown and the reference, about the vertical and away from it.";
    page.chart(Chart::new("Errors against the reference", "deg", about, series).of_sizes());
}

fn over_time(outputs: &[Output], angle: Angle) -> Vec<[f64; 3]> {
    let point = |output: &Output| {
        let [x, sigma] = output.attitude.as_ref().map_or([f32::NAN, 0.0], angle).map(|x| f64::from(x.to_degrees()));
        [in_s(output.t_us), x, sigma]
    };
    outputs.iter().map(point).collect()
}

/// Inclination, azimuth and gravity toolface of a rotation from body to NED, degrees.
fn angles_deg(q: &UnitQuaternion<f64>) -> [f64; 3] {
    let c = q.to_rotation_matrix();
    let around = |angle: f64| angle.to_degrees().rem_euclid(360.0);
    [
        c[(2, 0)].hypot(c[(2, 1)]).atan2(c[(2, 2)]).to_degrees(),
        around(c[(1, 2)].atan2(c[(0, 2)])),
        around(c[(2, 1)].atan2(-c[(2, 0)])),
    ]
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn angles_of_a_rotation_are_those_it_was_made_of() {
        for (inclination, azimuth, toolface) in [(30.0, 75.0, 200.0), (88.0, 312.0, 17.0)] {
            let about = |axis, degrees: f64| UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
            let q = about(Vector3::z_axis(), azimuth)
                * about(Vector3::y_axis(), inclination)
                * about(Vector3::z_axis(), toolface);
            for (angle, wanted) in angles_deg(&q).into_iter().zip([inclination, azimuth, toolface]) {
                assert!((angle - wanted).abs() < 1e-9, "{angle} {wanted}");
            }
        }
    }
}
