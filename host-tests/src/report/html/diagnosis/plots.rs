//! Plots of a diagnosis.

use meerkat_mwd::compensation::{Effect, Parameter};

use crate::{
    diagnosis::{Diagnosed, Found},
    report::html::{Plot, Series, escape::escape},
};

/// Share of the residuals that a plot shows in full: the share that counts in the figures.
const SHOWN: f64 = 0.98;

/// Longest step between residuals that a line bridges, seconds; residuals span one second.
const BRIDGED_S: f64 = 1.5;

/// Residuals of gravity and field over time, before and after.
pub(super) fn residual(diagnosed: &Diagnosed) -> String {
    let over_time = &diagnosed.residual_over_time;
    let shaded = magnets_shaded_s(diagnosed);
    let mut out = String::new();
    for (vector, (name, unit)) in [("Gravity", "deg"), ("Field", "deg")].into_iter().enumerate() {
        let [Some(before), Some(after)] = [over_time.before.get(vector), over_time.after.get(vector)] else { continue };
        let both = before.iter().chain(after);
        let mut angles: Vec<f64> = both.clone().map(|[_, angle]| *angle).collect();
        angles.sort_by(f64::total_cmp);
        let Some(largest) = angles.get((angles.len() as f64 * SHOWN) as usize).or(angles.last()) else { continue };
        let times = both.map(|[t_s, _]| *t_s);
        let (from_s, to_s) = times.fold((f64::MAX, f64::MIN), |(low, high), t_s| (low.min(t_s), high.max(t_s)));
        let series = |name: &str, class, points: &[[f64; 2]]| Series {
            name: name.to_owned(),
            class,
            points: points.iter().map(|[t_s, angle]| [*t_s, *angle, 0.0]).collect(),
            bridged_s: BRIDGED_S,
            marked: false,
        };
        let plot = Plot {
            unit,
            from_s,
            to_s,
            range: [0.0, 1.1 * largest],
            shaded_s: &shaded,
            series: vec![series("with the bias alone", "before", before), series("with all that flew", "after", after)],
        };
        out += &format!("<h3>{name}</h3>\n{}", plot.draw());
    }
    if !shaded.is_empty() && !out.is_empty() {
        out += "<p>Shaded: a magnet is there.</p>\n";
    }
    out
}

/// Intervals with a magnet, seconds, to be shaded.
pub(crate) fn magnets_shaded_s(diagnosed: &Diagnosed) -> Vec<[f64; 2]> {
    let spans = diagnosed.magnets.iter().map(|magnet| [magnet.from_us, magnet.to_us.unwrap_or(u64::MAX)]);
    spans.map(|span| span.map(|t_us| t_us as f64 * 1e-6)).collect()
}

/// Estimates of each effect found, over the diagnoses that found it.
pub(crate) fn effect_estimates(diagnosed: &Diagnosed) -> String {
    diagnosed.effects.iter().map(|found| estimates_of(diagnosed, found)).collect()
}

fn estimates_of(diagnosed: &Diagnosed, found: &Found) -> String {
    let effect = found.effect;
    let all: Vec<Series> = effect
        .parameters()
        .iter()
        .enumerate()
        .map(|(k, parameter)| Series {
            name: parameter.name.to_owned(),
            class: ["x", "y", "z"][k % 3],
            points: points(diagnosed, effect, k, parameter),
            bridged_s: f64::MAX,
            marked: true,
        })
        .collect();
    let ends = all.iter().flat_map(|series| &series.points).flat_map(|[_, x, sigma]| [x - sigma, x + sigma]);
    let (low, high) = ends.fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let starts = diagnosed.reports.iter().map(|(report, _)| report.t_start_us as f64 * 1e-6);
    let stops = diagnosed.reports.iter().map(|(report, _)| report.t_end_us as f64 * 1e-6);
    let plot = Plot {
        unit: "estimate",
        from_s: starts.fold(f64::MAX, f64::min),
        to_s: stops.fold(f64::MIN, f64::max),
        range: [1.1 * low, 1.1 * high],
        shaded_s: &[],
        series: all,
    };
    format!("<h3>{} over the diagnoses</h3>\n{}", escape(effect.name()), plot.draw())
}

/// End of each diagnosis in seconds, the parameter it found and its deviation, in the parameter's unit.
fn points(diagnosed: &Diagnosed, effect: &dyn Effect, k: usize, parameter: &Parameter) -> Vec<[f64; 3]> {
    let reports = diagnosed.reports.iter();
    let of_report = reports.flat_map(|(report, library)| report.found().map(move |found| (report, *library, found)));
    let own = of_report.filter(|(_, library, found)| {
        library.get(usize::from(found.found.index)).is_some_and(|other| other.name() == effect.name())
    });
    own.map(|(report, _, found)| {
        let in_unit = |values: &[f32]| f64::from(values.get(k).copied().unwrap_or(0.0) * parameter.in_unit);
        [report.t_end_us as f64 * 1e-6, in_unit(&found.found.parameters), in_unit(&found.found.sigma)]
    })
    .collect()
}
