//! An angle over the whole recording as a strip without axes, with its bands, beside the figure that it ends
//! at.

use std::fmt::Write;

use super::{
    chart::{Chart, in_digits},
    escape::escape,
    thinned::Point,
};

/// Size of the drawing, in its own units: the page stretches it.
const WIDTH: f64 = 200.0;
const HEIGHT: f64 = 40.0;

/// Stretches that it is thinned to.
const STRETCHES: usize = 100;

/// The strip of a plot with one line; empty where the plot would be.
pub(super) fn strip(chart: &Chart, span: [f64; 2]) -> String {
    let (Some(range), Some(series)) = (chart.range(), chart.series.first()) else { return String::new() };
    let points = chart.to_draw(&series.points, span, STRETCHES);
    let values = || series.points.iter().map(|[_, x, _]| *x).filter(|x| x.is_finite());
    let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let place = |t_s: f64, x: f64| {
        let across = (t_s - span[0]) / (span[1] - span[0]).max(1e-9);
        let up = (x - range[0]) / (range[1] - range[0]).max(1e-30);
        format!("{:.1} {:.1}", WIDTH * across, HEIGHT * (1.0 - up.clamp(0.0, 1.0)))
    };
    let mut out = String::new();
    let is_broken = |point: &Point| !point[1].is_finite();
    for stretch in points.split(is_broken).filter(|stretch| stretch.len() > 1) {
        for wide in [2.0, 1.0] {
            let upper = stretch.iter().map(|[t_s, x, sigma]| place(*t_s, x + wide * sigma));
            let lower = stretch.iter().rev().map(|[t_s, x, sigma]| place(*t_s, x - wide * sigma));
            // Writing to a string does not fail.
            let _ = write!(out, "<path class=\"band\" d=\"M{}Z\"/>", upper.chain(lower).collect::<Vec<_>>().join("L"));
        }
        let line: Vec<String> = stretch.iter().map(|[t_s, x, _]| place(*t_s, *x)).collect();
        let _ = write!(out, "<path class=\"after\" d=\"M{}\"/>", line.join("L"));
    }
    let told =
        format!("{} over the recording: between {} and {} {}", chart.name, in_digits(low), in_digits(high), chart.unit);
    let told = escape(&told);
    format!(
        "<svg class=\"strip\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{told}\"><title>{told}</title>{out}</svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::html::Series;

    #[test]
    fn a_strip_has_its_line_and_both_bands_and_breaks_at_north() {
        let drawn = |angles: &[f64]| {
            let points = angles.iter().enumerate().map(|(k, angle)| [k as f64, *angle, 1.0]).collect();
            let series = Series { name: "flown".to_owned(), class: "after", points, bridged_s: 9.0, marked: false };
            strip(&Chart::new("Azimuth", "deg", "", vec![series]).of_angles(), [0.0, 3.0])
        };
        let (whole, broken) = (drawn(&[80.0, 81.0, 82.0, 81.0]), drawn(&[350.0, 359.0, 2.0, 7.0]));
        let paths = |of: &str| ["band", "after"].map(|class| of.matches(&format!("\"{class}\"")).count());
        assert_eq!((paths(&whole), paths(&broken)), ([2, 1], [4, 2]), "{whole} {broken}");
        assert!(whole.contains("between 80.00 and 82.00 deg"), "{whole}");
        assert_eq!(drawn(&[f64::NAN; 4]), "");
    }
}
