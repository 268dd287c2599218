//! Picture of a flight for a reader in a hurry: rotation error of the gyro alone, before and after identification.

use crate::{
    flight::Flight,
    report::{
        html::{Plot, Series},
        number::fixed,
    },
    score::{PerModel, Settings, rotation_errors},
    trace::Trace,
};

/// Picks the error of one way to read the gyro, degrees.
type Reading = fn(&PerModel) -> Option<f64>;

/// Draws the rotation error of each 2 s from `settings.from_us` on, as an SVG file; `None` if the trace has no
/// reference there.
#[must_use]
pub fn picture(trace: &Trace, flight: &Flight, settings: &Settings) -> Option<String> {
    let all = rotation_errors(trace, flight, settings);
    let errors = all.deg;
    let (from_s, to_s) = (errors.first()?.0, errors.last()?.0);
    let lines: [(&str, &str, Reading); 3] = [
        ("raw gyro", "before", |error| error.uncompensated),
        ("bias alone taken out", "x", |error| error.bias_only),
        ("as flown: P, bias and effects", "after", |error| error.with_effects),
    ];
    let series = lines.map(|(name, class, reading)| Series {
        name: name.to_owned(),
        class,
        points: errors.iter().map(|(t_s, error)| [*t_s, reading(error).unwrap_or(f64::NAN), 0.0]).collect(),
        bridged_s: f64::MAX,
        marked: false,
    });
    let values = series.iter().flat_map(|series| &series.points).map(|[_, value, _]| *value);
    let largest = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
    let (from, to, over) = (from_s, to_s, "time, s");
    let plot = Plot {
        unit: "deg",
        over,
        is_of_days: false,
        from,
        to,
        range: [0.0, 1.05 * largest],
        shaded_s: &[],
        levels: &[],
        series: series.into(),
    };
    let title = format!(
        "Error of the gyro's rotation over 2 s against an optical reference, whose delay of {} ms is taken out",
        fixed(all.delay_ms, 1)
    );
    Some(plot.standalone(&title))
}
