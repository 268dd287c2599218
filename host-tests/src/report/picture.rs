//! Pictures for a reader in a hurry: rotation error of the gyro alone, before and after identification; and of a
//! simulated trace how the tool turns, and what the gyro makes of it.

use crate::{
    number::fixed,
    report::html::{Plot, Series},
};
use testbed::{
    flight::Flight,
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
    let series = lines.map(|(name, class, reading)| {
        let points = errors.iter().map(|(t_s, error)| [*t_s, reading(error).unwrap_or(f64::NAN), 0.0]);
        (name, class, points.collect())
    });
    let title = format!(
        "Error of the gyro's rotation over 2 s against an optical reference, whose delay of {} ms is taken out",
        fixed(all.delay_ms, 1)
    );
    Some(drawn(&title, "deg", [from_s, to_s], series))
}

/// Points that a line over a whole run needs, and the least time of which each is the mean, seconds.
const POINTS: f64 = 600.0;
const LEAST_MEAN_S: f64 = 0.25;

/// Draws the true rates of a simulated trace, deg/s, as an SVG file; `None` if it has none.
#[must_use]
pub fn rates(trace: &Trace) -> Option<String> {
    let rates = trace.true_rate.as_ref()?;
    let every = ((rates.len() as f64 / POINTS) as usize).max(1);
    let rate =
        |index: usize| rates.get(index).filter(|_| index.is_multiple_of(every)).map(|rate| rate.map(f64::to_degrees));
    Some(by_axis("How the tool turns", trace, rate))
}

/// Draws what the gyro of a simulated trace reads less the truth, in means of some samples, deg/s, as an SVG file;
/// `None` if the truth is not there.
#[must_use]
pub fn gyro_errors(trace: &Trace) -> Option<String> {
    let rates = trace.true_rate.as_ref()?;
    let mean_s = (trace.duration_s() / POINTS).max(LEAST_MEAN_S);
    let together = ((mean_s * 1e6 / f64::from(trace.nominal_period_us().max(1))) as usize).max(1);
    let error = |index: usize| {
        let pairs = trace.samples.iter().zip(rates).skip(index).take(together);
        let mut mean = [0.0; 3];
        for (sample, rate) in pairs {
            for ((mean, read), truth) in mean.iter_mut().zip(sample.gyro_rad_s).zip(rate) {
                *mean += (f64::from(read) - truth).to_degrees() / together as f64;
            }
        }
        (index.is_multiple_of(together) && index + together <= rates.len()).then_some(mean)
    };
    Some(by_axis(&format!("What the gyro reads less the truth, the mean of each {mean_s:.2} s"), trace, error))
}

/// A value at each sample that has one, axis by axis.
fn by_axis(title: &str, trace: &Trace, value: impl Fn(usize) -> Option<[f64; 3]>) -> String {
    let lines = [("along the tool (z)", "after"), ("across it (x)", "x"), ("across it (y)", "before")];
    let mut points: [Vec<[f64; 3]>; 3] = [const { Vec::new() }; 3];
    for (index, sample) in trace.samples.iter().enumerate() {
        let Some([x, y, z]) = value(index) else { continue };
        for (points, value) in points.iter_mut().zip([z, x, y]) {
            points.push([sample.t_us as f64 * 1e-6, value, 0.0]);
        }
    }
    let mut points = points.into_iter();
    let series = lines.map(|(name, class)| (name, class, points.next().unwrap_or_default()));
    drawn(title, "deg/s", [trace.first_us(), trace.last_us()].map(|t_us| t_us as f64 * 1e-6), series)
}

/// Lines over time with a title, as an SVG file. The range has all values and zero in it.
fn drawn(title: &str, unit: &str, [from, to]: [f64; 2], lines: [(&str, &'static str, Vec<[f64; 3]>); 3]) -> String {
    let values = lines.iter().flat_map(|(_, _, points)| points).map(|[_, value, _]| *value);
    let [least, most] = values
        .filter(|value| value.is_finite())
        .fold([0.0_f64; 2], |[least, most], value| [least.min(value), most.max(value)]);
    let series = lines.map(|(name, class, points)| Series {
        name: name.to_owned(),
        class,
        points,
        bridged_s: f64::MAX,
        marked: false,
    });
    let plot = Plot {
        width: Plot::WIDE,
        unit,
        over: "time, s",
        is_of_days: false,
        from,
        to,
        range: [1.05 * least, 1.05 * most],
        shaded_s: &[],
        levels: &[],
        series: series.into(),
    };
    plot.standalone(title)
}
