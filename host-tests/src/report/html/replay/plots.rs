//! Plots of a flight.

use meerkat_mwd::{Config, identification::WindowReport, probe::Output};

use crate::{
    diagnosis::Diagnosed,
    flight::Flight,
    report::html::{Plot, Series, diagnosis::magnets_shaded_s},
    score::{Settings, attitude_errors_deg},
    trace::Trace,
};

/// Number of points above which a line is thinned out.
const POINTS: usize = 1_500;

/// Share of the values that a plot of errors shows in full.
const SHOWN: f64 = 0.98;

/// Jump of an angle at which a line breaks: the angle has passed north.
const HALF_TURN_DEG: f64 = 180.0;

/// Picks one angle or deviation of an output, in the plot's unit.
type Value = fn(&Output) -> Option<f64>;

/// Plots of angles, their stated deviations and, if the trace has a reference, their errors.
pub(super) fn attitude(trace: &Trace, config: &Config, flight: &Flight, diagnosed: &Diagnosed) -> String {
    let (shaded, span) = (magnets_shaded_s(diagnosed), span_s(flight));
    let over_time = |value: Value| -> Vec<[f64; 3]> {
        let outputs = flight.outputs.iter();
        outputs.map(|output| [output.t_us as f64 * 1e-6, value(output).unwrap_or(f64::NAN), 0.0]).collect()
    };
    let angle = |value: Value| broken_at_north(every(&over_time(value)));
    let mut out = String::new();
    let lines: [(&str, &str, Value); 3] = [
        ("Inclination", "deg", |o| Some(f64::from(o.attitude?.inclination_rad.to_degrees()))),
        ("Azimuth", "deg", |o| Some(f64::from(o.attitude?.azimuth_rad.to_degrees()))),
        ("Rotation about the tool's axis", "rpm", |o| Some(f64::from(o.rate_rad_s[2].to_degrees()) / 6.0)),
    ];
    for (name, unit, value) in lines {
        out += &drawn(name, unit, span, &shaded, vec![line(name, "after", angle(value))], false);
    }
    let deviations: [(&str, &'static str, Value); 3] = [
        ("inclination", "x", |o| Some(f64::from(o.attitude?.sigma_inclination_rad.to_degrees()))),
        ("azimuth", "y", |o| Some(f64::from(o.attitude?.sigma_azimuth_rad.to_degrees()))),
        ("toolface", "z", |o| Some(f64::from(o.attitude?.sigma_toolface_rad.to_degrees()))),
    ];
    let stated = deviations.map(|(name, class, value)| line(name, class, largest(&over_time(value))));
    out += &drawn("Stated deviations", "deg", span, &shaded, stated.into(), true);
    let errors = attitude_errors_deg(trace, flight, &Settings::of(trace, config));
    let of = |part: usize| -> Vec<[f64; 3]> { errors.iter().map(|error| [error[0], error[part], 0.0]).collect() };
    let against = vec![line("heading", "y", largest(&of(1))), line("inclination", "x", largest(&of(2)))];
    out += &drawn("Errors against the reference", "deg", span, &shaded, against, true);
    if !shaded.is_empty() {
        out += "<p>Shaded: a magnet is there.</p>\n";
    }
    out
}

/// Plots of bias and scale factors of every window's fit.
pub(super) fn fits(flight: &Flight) -> String {
    let fitted = |name: &str, class, value: &dyn Fn(&WindowReport) -> [f64; 2]| Series {
        points: flight
            .reports
            .iter()
            .map(|report| {
                let [x, sigma] = value(report);
                [report.t_end_us as f64 * 1e-6, x, sigma]
            })
            .collect(),
        bridged_s: f64::MAX,
        marked: true,
        ..line(name, class, Vec::new())
    };
    let axes = [("x", "x"), ("y", "y"), ("z", "z")].into_iter().enumerate();
    let bias = axes.clone().map(|(k, (name, class))| {
        fitted(name, class, &|report| {
            [report.fitted.b_rad_s[k], report.sigma[9 + k]].map(|x| f64::from(x.to_degrees()))
        })
    });
    let scale = axes.map(|(k, (name, class))| {
        fitted(name, class, &|report| [report.fitted.p[k][k] - 1.0, report.sigma[4 * k]].map(|x| 100.0 * f64::from(x)))
    });
    drawn("Bias", "deg/s", span_s(flight), &[], bias.collect(), false)
        + &drawn("P's diagonal less 1", "%", span_s(flight), &[], scale.collect(), false)
}

fn line(name: &str, class: &'static str, points: Vec<[f64; 3]>) -> Series {
    // A tenth of the plot's width is shown as a gap at any sample rate.
    let [first, last] = [points.first(), points.last()].map(|point| point.map_or(0.0, |[t_s, ..]| *t_s));
    Series { name: name.to_owned(), class, points, bridged_s: 0.1 * (last - first), marked: false }
}

/// Times of the first and the last output, seconds.
fn span_s(flight: &Flight) -> [f64; 2] {
    [flight.outputs.first(), flight.outputs.last()].map(|output| output.map_or(0.0, |output| output.t_us as f64 * 1e-6))
}

/// A plot under its name; empty if there is nothing to draw. `from_zero` is for sizes: the axis begins at
/// zero, and the largest values may run out of it.
fn drawn(
    name: &str,
    unit: &str,
    [from_s, to_s]: [f64; 2],
    shaded_s: &[[f64; 2]],
    series: Vec<Series>,
    from_zero: bool,
) -> String {
    let points = || series.iter().flat_map(|series| &series.points).filter(|[_, x, _]| x.is_finite());
    let mut ends: Vec<f64> = points().flat_map(|[_, x, sigma]| [x - sigma, x + sigma]).collect();
    ends.sort_by(f64::total_cmp);
    let (Some(&lowest), Some(&highest)) = (ends.first(), ends.last()) else { return String::new() };
    let range = if from_zero {
        let shown = ends.get((ends.len() as f64 * SHOWN) as usize).copied().unwrap_or(highest);
        [0.0, 1.1 * shown]
    } else {
        let margin = 0.05 * (highest - lowest).max(1e-3);
        [lowest - margin, highest + margin]
    };
    format!("<h3>{name}</h3>\n{}", Plot { unit, from_s, to_s, range, shaded_s, series }.draw())
}

/// Every nth point, so that a plot has room for them.
fn every(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    points.iter().copied().step_by(points.len().div_ceil(POINTS).max(1)).collect()
}

/// The largest point of each stretch, as many as a plot has room for.
fn largest(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let finite: Vec<[f64; 3]> = points.iter().copied().filter(|[_, x, _]| x.is_finite()).collect();
    let stretches = finite.chunks(finite.len().div_ceil(POINTS).max(1));
    stretches.filter_map(|stretch| stretch.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))).collect()
}

fn broken_at_north(points: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let mut broken: Vec<[f64; 3]> = Vec::with_capacity(points.len());
    for point in points {
        if broken.last().is_some_and(|before| (before[1] - point[1]).abs() > HALF_TURN_DEG) {
            broken.push([point[0], f64::NAN, 0.0]);
        }
        broken.push(point);
    }
    broken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_breaks_at_north_and_nowhere_else() {
        let at = |angles: &[f64]| broken_at_north(angles.iter().map(|angle| [0.0, *angle, 0.0]).collect());
        assert_eq!(at(&[10.0, 80.0, 170.0]).len(), 3);
        let broken = at(&[350.0, 359.0, 2.0]);
        assert!(broken.len() == 4 && broken[2][1].is_nan());
    }

    #[test]
    fn thinning_keeps_the_largest_and_no_more_than_there_is_room_for() {
        let points: Vec<[f64; 3]> = (0..100_000).map(|k| [f64::from(k), f64::from(k % 977), 0.0]).collect();
        let thin = largest(&points);
        assert!(thin.len() <= POINTS && every(&points).len() <= POINTS);
        assert!(thin.iter().any(|[_, x, _]| *x == 976.0) && largest(&[[0.0, f64::NAN, 0.0]]).is_empty());
    }
}
