//! Quantity that a residual goes with most: rate, vibration, temperature or time, before and after what flew. Nothing
//! is shown where that may be chance.

use meerkat_mwd::{Sample, SampleFlags};

use super::{Plot, Series, Told, chart::in_digits, escape::escape, fixed, in_s};

/// Groups of seconds, by the size of what the residual goes with.
const GROUPS: usize = 8;

/// Fewest residuals in a group: fewer have no mean worth a point.
const FEWEST: usize = 3;

/// A correlation of fewer of its deviations is left to chance: the largest of four is shown.
const SIGMAS: f64 = 3.0;

/// Least share of its mean, or of one unit, that a regressor has to vary by.
const LEAST_SPREAD: f64 = 0.05;

/// Names and units of the regressors.
const REGRESSORS: [(&str, &str); 4] =
    [("rate", "deg/s"), ("vibration", "m/s² rms"), ("temperature", "°C"), ("time", "s")];

/// The figure of a residual whose points are seconds and degrees, read in two ways, of which `which` tells;
/// empty if there is too little of it.
pub(super) fn figure(
    told: &Told,
    name: &str,
    which: &str,
    [first, second]: [&str; 2],
    before: &[[f64; 2]],
    after: &[[f64; 2]],
) -> String {
    let seconds = seconds(told, before);
    if before.len() < GROUPS * FEWEST || seconds.len() != before.len() {
        return String::new();
    }
    let angles: Vec<f64> = before.iter().map(|[_, angle]| *angle).collect();
    let column = |k: usize| -> Vec<f64> { seconds.iter().map(|regressors| regressors[k]).collect() };
    let best = (0..REGRESSORS.len())
        .filter_map(|k| Some((k, correlation(&column(k), &angles)?)))
        .max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
    let is_chance = |r: f64| r.abs() < SIGMAS / (angles.len() as f64).sqrt();
    let Some((k, of_before)) = best.filter(|(_, r)| !is_chance(*r)) else { return String::new() };
    let x = column(k);
    let afterwards: Vec<f64> = before
        .iter()
        .map(|[t_s, _]| after.iter().find(|[other_s, _]| (other_s - t_s).abs() < 1e-6).map_or(f64::NAN, |[_, a]| *a))
        .collect();
    let of_after = correlation(&x, &afterwards);
    let groups = [grouped(&x, &angles), grouped(&x, &afterwards)];
    let ends = groups.iter().flatten().flat_map(|[_, y, sigma]| [y - sigma, y + sigma]);
    let top = ends.filter(|y| y.is_finite()).fold(1e-6, f64::max);
    let from = x.iter().copied().fold(f64::MAX, f64::min);
    let to = x.iter().copied().fold(f64::MIN, f64::max);
    let [of_first, of_second] = groups;
    let series = |name: &str, class: &'static str, points| Series {
        name: name.to_owned(),
        class,
        points,
        bridged_s: f64::MAX,
        marked: true,
    };
    let (what, unit) = REGRESSORS[k];
    let mean = |angles: &[f64]| {
        let read = || angles.iter().filter(|angle| angle.is_finite());
        fixed(read().sum::<f64>() / read().count().max(1) as f64, 2)
    };
    // A correlation does not tell the size: what is small may still go with something.
    let about = format!(
        "It goes most with {what}: correlation {} {first}{}. Its mean is {} deg {first}, {} deg {second}. Points are means over seconds of like {what}, with the deviation of the mean.",
        fixed(of_before, 2),
        of_after.map_or_else(String::new, |after| format!(", {} {second}", fixed(after, 2))),
        mean(&angles),
        mean(&afterwards),
    );
    let plot = Plot {
        width: Plot::NARROW,
        unit: "deg",
        over: &format!("{what}, {unit}"),
        is_of_days: false,
        from,
        to,
        range: [0.0, 1.1 * top],
        shaded_s: &[],
        levels: &[],
        series: vec![series(first, "before", of_first), series(second, "after", of_second)],
    };
    let described =
        format!("{name} against {what}{which}, from {} to {} {unit}. {about}", in_digits(from), in_digits(to));
    format!(
        "<figure>\n<h3>{} against {what}{}</h3>\n<p class=\"about\">{}</p>\n<div class=\"standing\">\n{}</div>\n\
         <p class=\"legend\"><span class=\"before\">{}</span> <span class=\"after\">{}</span></p>\n</figure>\n",
        escape(name),
        escape(which),
        escape(&about),
        plot.draw(&described),
        escape(first),
        escape(second),
    )
}

/// Rate, vibration and temperature in the second before each residual, and the residual's time.
fn seconds(told: &Told, residuals: &[[f64; 2]]) -> Vec<[f64; 4]> {
    let samples = &told.trace.samples;
    let of = |[t_s, _]: &[f64; 2]| {
        let from = samples.partition_point(|sample| in_s(sample.t_us) < t_s - 1.0);
        let to = samples.partition_point(|sample| in_s(sample.t_us) <= *t_s);
        let inside = samples.get(from..to).unwrap_or_default();
        let size = |v: [f32; 3]| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        // Mean over the samples in which the sensor was read; no number without any.
        let mean = |missing: SampleFlags, of: &dyn Fn(&Sample) -> f64| {
            let read = || inside.iter().filter(|sample| !sample.flags.contains(missing));
            read().map(of).sum::<f64>() / read().count() as f64
        };
        let force = mean(SampleFlags::ACCEL_MISSING, &|sample| size(sample.accel_m_s2));
        let rate = mean(SampleFlags::GYRO_MISSING, &|sample| size(sample.gyro_rad_s)).to_degrees();
        let squares = mean(SampleFlags::ACCEL_MISSING, &|sample| (size(sample.accel_m_s2) - force).powi(2));
        let vibration = squares.sqrt();
        let temperature = mean(SampleFlags::TEMPERATURE_MISSING, &|sample| f64::from(sample.temperature_c));
        [rate, vibration, temperature, *t_s]
    };
    residuals.iter().map(of).collect()
}

/// Correlation of two columns; `None` where one of them is constant or has a value that is none.
fn correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (mean_x, mean_y) = (mean(x), mean(y));
    let product =
        |a: &[f64], am: f64, b: &[f64], bm: f64| a.iter().zip(b).map(|(a, b)| (a - am) * (b - bm)).sum::<f64>();
    let (xx, yy) = (product(x, mean_x, x, mean_x), product(y, mean_y, y, mean_y));
    let spread = (xx / x.len() as f64).sqrt();
    let varies = spread > LEAST_SPREAD * mean_x.abs().max(1.0) && yy > 0.0;
    varies.then(|| product(x, mean_x, y, mean_y) / (xx * yy).sqrt()).filter(|r| r.is_finite())
}

/// Means of `y` over groups of like `x`: mean of `x`, mean of `y`, its deviation.
fn grouped(x: &[f64], y: &[f64]) -> Vec<[f64; 3]> {
    let mut pairs: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).filter(|(_, y)| y.is_finite()).collect();
    pairs.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let size = pairs.len().div_ceil(GROUPS).max(FEWEST);
    let of = |group: &[(f64, f64)]| {
        let count = group.len() as f64;
        let mean_x = group.iter().map(|(x, _)| x).sum::<f64>() / count;
        let mean_y = group.iter().map(|(_, y)| y).sum::<f64>() / count;
        let square = group.iter().map(|(_, y)| (y - mean_y).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        [mean_x, mean_y, (square / count).sqrt()]
    };
    pairs.chunks(size).filter(|group| group.len() >= FEWEST).map(of).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_goes_along_is_seen_and_a_constant_is_not() {
        let x: Vec<f64> = (0..40).map(f64::from).collect();
        let along: Vec<f64> = x.iter().map(|x| 3.0 - 0.2 * x).collect();
        assert!((correlation(&x, &along).unwrap() + 1.0).abs() < 1e-12);
        assert_eq!(correlation(&[5.0; 40], &along), None);
        assert_eq!(correlation(&[f64::NAN; 40], &along), None);
        let groups = grouped(&x, &along);
        assert_eq!(groups.len(), GROUPS);
        assert!(groups.iter().all(|[x, y, sigma]| (y - (3.0 - 0.2 * x)).abs() < 1e-9 && *sigma > 0.0));
    }
}
