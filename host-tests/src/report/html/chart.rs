//! A plot of a page: a drawing that stands without scripts and on paper, and the data with which the page's script
//! draws it anew, to be zoomed.

use serde_json::{Value, json};

use super::{
    escape::escape,
    fixed,
    svg::{Plot, Series},
    thinned::{Point, STRETCHES, packed, packed_times, thinned},
};

/// Stretches of the drawing that stands without scripts.
const DRAWN_STRETCHES: usize = 350;

/// Unit of an axis that counts days since 1970; the page's script knows it.
pub(super) const DATE: &str = "date";

/// Share of the values that a plot of sizes shows at first.
const SHOWN: f64 = 0.995;

/// An interval of time that a plot shades, with its reason for the reader who points at it.
#[derive(Clone, Debug)]
pub struct Mark {
    /// Start and end, seconds.
    pub span_s: [f64; 2],
    /// Reason for the shade, in words.
    pub text: String,
}

/// A plot over time.
pub struct Chart<'a> {
    /// Headline.
    pub name: &'a str,
    /// Unit of the values.
    pub unit: &'a str,
    /// Explanation of the plot and of how to read it, in a sentence or two.
    pub about: &'a str,
    /// Lines, bands (lines with deviations) and points.
    pub series: Vec<Series>,
    /// Values are sizes: the axis begins at zero, and rare large values are not shown at first.
    pub is_size: bool,
    /// Values are whole levels from zero to this one, all of which the axis shows.
    pub top_level: Option<u8>,
    /// Values are angles that go once around: a line breaks where it passes north.
    pub is_angle: bool,
    /// Shaded intervals.
    pub marks: Vec<Mark>,
    /// Horizontal lines: value and name.
    pub levels: Vec<(f64, String)>,
}

impl<'a> Chart<'a> {
    /// A plot without marks and levels.
    #[must_use]
    pub const fn new(name: &'a str, unit: &'a str, about: &'a str, series: Vec<Series>) -> Self {
        Self {
            name,
            unit,
            about,
            series,
            is_size: false,
            top_level: None,
            is_angle: false,
            marks: Vec::new(),
            levels: Vec::new(),
        }
    }

    /// A plot of sizes, which begin at zero.
    #[must_use]
    pub fn of_sizes(self) -> Self {
        Self { is_size: true, ..self }
    }

    /// A plot of whole levels from zero to the last one.
    #[must_use]
    pub fn of_levels(self, top: u8) -> Self {
        Self { top_level: Some(top), ..self }
    }

    /// A plot of angles that go once around.
    #[must_use]
    pub fn of_angles(self) -> Self {
        Self { is_angle: true, ..self }
    }

    /// Shades intervals.
    #[must_use]
    pub fn marked(self, marks: &[Mark]) -> Self {
        Self { marks: marks.to_vec(), ..self }
    }

    /// Draws horizontal lines.
    #[must_use]
    pub fn with_levels(self, levels: Vec<(f64, String)>) -> Self {
        Self { levels, ..self }
    }

    /// The plot's place in the page and its data; `None` if there is nothing to show.
    pub(super) fn drawn(mut self, number: usize, span: [f64; 2], over: (&str, &str)) -> Option<(String, Value)> {
        self.series.retain(|series| series.points.iter().any(|[_, x, _]| x.is_finite()));
        let range = self.range()?;
        let beyond = self.beyond(range);
        let about = [self.about, &beyond].map(str::trim).join(" ");
        let described = format!("{}, {}. {} {}", self.name, self.unit, about.trim(), self.in_words());
        let mut out = format!(
            "<figure id=\"chart-{number}\">\n<h3>{}, {}</h3>\n<p class=\"about\">{}</p>\n",
            escape(self.name),
            escape(self.unit),
            escape(about.trim()),
        );
        out += &format!(
            "<div class=\"plot\" tabindex=\"0\" role=\"application\" aria-roledescription=\"plot\" aria-label=\"{}\"></div>\n",
            escape(&described)
        );
        out += &format!("<div class=\"drawing\">\n{}</div>\n", self.drawing(&described, range, span, over));
        out += "<p class=\"legend\">";
        for series in &self.series {
            let class = series.class;
            out +=
                &format!("<span class=\"{class}\">{}<output aria-live=\"off\"></output></span> ", escape(&series.name));
        }
        for (_, name) in self.levels.iter().filter(|(_, name)| !name.is_empty()) {
            out += &format!("<span class=\"level\">{}</span> ", escape(name));
        }
        out += "</p>\n<p class=\"note\"></p>\n</figure>\n";
        Some((out, self.data(range, span)))
    }

    /// The values that the axis spans at first: a band may run out of it where it is rarely that wide.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        if self.is_angle {
            return self.range_of_angles();
        }
        if let Some(top) = self.top_level {
            return Some([0.0, f64::from(top)]).filter(|_| !self.series.is_empty());
        }
        let points = self.series.iter().flat_map(|series| &series.points).filter(|[_, x, _]| x.is_finite());
        let mut ends: Vec<f64> = points.flat_map(|[_, x, sigma]| [x - sigma, x + sigma]).collect();
        ends.sort_by(f64::total_cmp);
        let at = |share: f64| ends.get((ends.len().saturating_sub(1) as f64 * share).round() as usize).copied();
        let solid = self.series.iter().flat_map(|series| {
            let deviations = if series.marked { 1.0 } else { 0.0 };
            series.points.iter().flat_map(move |[_, x, sigma]| [x - deviations * sigma, x + deviations * sigma])
        });
        let solid = solid.chain(self.levels.iter().map(|(level, _)| *level)).filter(|x| x.is_finite());
        let usual = [at(1.0 - SHOWN)?, at(SHOWN)?];
        let (lowest, highest) =
            solid.chain(usual).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        if self.is_size {
            let shown = ends.get((ends.len() as f64 * SHOWN) as usize).copied().unwrap_or(highest);
            let top = if highest < 1.5 * shown { highest } else { shown };
            // A level that is named beside the plot is in it.
            let top = self.levels.iter().map(|(level, _)| *level).fold(top, f64::max);
            // Axis from 0 to 1 if there is nothing but zeros.
            return Some([0.0, if top > 0.0 { 1.1 * top } else { 1.0 }]);
        }
        let margin = 0.05 * (highest - lowest).max(1e-3);
        Some([lowest - margin, highest + margin])
    }

    /// The whole circle; a part of it where all angles lie in a quarter, so that small changes are seen.
    fn range_of_angles(&self) -> Option<[f64; 2]> {
        let points = || self.series.iter().flat_map(|series| &series.points).filter(|[_, x, _]| x.is_finite());
        let (low, high) = points().fold((f64::MAX, f64::MIN), |(low, high), [_, x, _]| (low.min(*x), high.max(*x)));
        // Bands of two deviations of the usual size fit.
        let mut sigmas: Vec<f64> = points().map(|[_, _, sigma]| *sigma).filter(|sigma| *sigma > 0.0).collect();
        sigmas.sort_by(f64::total_cmp);
        let usual = sigmas.get(sigmas.len() / 2).copied().unwrap_or(0.0).min(QUARTER_TURN_DEG / 4.0);
        let half = (0.55 * (high - low) + 2.0 * usual).max(LEAST_HALF_DEG);
        let middle = 0.5 * (low + high);
        let is_narrow = high - low < QUARTER_TURN_DEG && (0.0..=360.0).contains(&middle);
        Some(if is_narrow { [(middle - half).max(0.0), (middle + half).min(360.0)] } else { [0.0, 360.0] })
            .filter(|_| low <= high)
    }

    /// Says so if values or bands lie beyond the axis.
    fn beyond(&self, range: [f64; 2]) -> String {
        let high = range[1];
        let values = || self.series.iter().flat_map(|series| &series.points).map(|[_, x, _]| *x);
        let count = values().filter(|x| *x > high).count();
        if count == 0 {
            return self.band_beyond(range);
        }
        let largest = values().filter(|x| x.is_finite()).fold(high, f64::max);
        let lie = if count == 1 { "1 value lies" } else { &format!("{count} values lie") };
        format!("{lie} above the axis, the largest at {}.", in_digits(largest))
    }

    /// Says so if a band of one deviation runs out of the axis, other than around the circle.
    fn band_beyond(&self, [low, high]: [f64; 2]) -> String {
        if self.is_angle && high - low >= 360.0 {
            return String::new();
        }
        let lines = self.series.iter().filter(|series| !series.marked).flat_map(|series| &series.points);
        let banded: Vec<&[f64; 3]> = lines.filter(|[_, x, sigma]| x.is_finite() && *sigma > 0.0).collect();
        let is_beyond = |[_, x, sigma]: &&[f64; 3]| x + sigma > high || x - sigma < low;
        let count = banded.iter().copied().filter(is_beyond).count();
        if count == 0 {
            return String::new();
        }
        let largest = banded.iter().map(|[_, _, sigma]| *sigma).fold(0.0, f64::max);
        let percent = 100.0 * count as f64 / banded.len() as f64;
        let percent = if percent < 0.05 { "under 0.1".to_owned() } else { format!("{percent:.1}") };
        format!(
            "The band of one deviation runs out of the axis at {percent} % of the points; it is at most ± {}.",
            in_digits(largest)
        )
    }

    /// The plot for a reader who does not see it.
    fn in_words(&self) -> String {
        let words = self.series.iter().map(|series| {
            let values = || series.points.iter().map(|[_, x, _]| *x).filter(|x| x.is_finite());
            let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            let mean = values().sum::<f64>() / values().count().max(1) as f64;
            let [low, high, mean] = [low, high, mean].map(in_digits);
            format!("{}: {low} to {high}, {mean} on the mean.", series.name)
        });
        words.collect::<Vec<_>>().join(" ")
    }

    /// Points of a line as it is drawn without scripts, thinned to `stretches`: broken where an angle passes
    /// north, but not within a stretch, whose least and largest angle a stroke joins.
    pub(super) fn to_draw(&self, points: &[Point], span: [f64; 2], stretches: usize) -> Vec<Point> {
        let thin = thinned(points, span, stretches).points;
        let are_pairs = points.len() > 2 * stretches;
        if self.is_angle { broken_at_north(thin, are_pairs) } else { thin }
    }

    fn drawing(&self, described: &str, range: [f64; 2], span: [f64; 2], (name, unit): (&str, &str)) -> String {
        let series = self.series.iter().map(|series| {
            let points = self.to_draw(&series.points, span, DRAWN_STRETCHES);
            Series { name: series.name.clone(), points, ..*series }
        });
        let shaded: Vec<[f64; 2]> = self.marks.iter().map(|mark| mark.span_s).collect();
        Plot {
            width: Plot::WIDE,
            unit: self.unit,
            over: &if unit == DATE { name.to_owned() } else { format!("{name}, {unit}") },
            is_of_days: unit == DATE,
            from: span[0],
            to: span[1],
            range,
            shaded_s: &shaded,
            levels: &self.levels.iter().map(|(level, _)| *level).collect::<Vec<_>>(),
            series: series.collect(),
        }
        .draw(described)
    }

    fn data(&self, range: [f64; 2], span: [f64; 2]) -> Value {
        let series: Vec<Value> = self
            .series
            .iter()
            .map(|series| {
                let thin = thinned(&series.points, span, STRETCHES);
                let has_deviations = thin.points.iter().any(|[_, _, sigma]| *sigma > 0.0);
                let values = |k: usize| {
                    let packed = packed(thin.points.iter().map(move |point| point.get(k).copied().unwrap_or(f64::NAN)));
                    json!([packed.middle, packed.step, packed.base64])
                };
                json!({
                    "name": series.name,
                    "class": series.class,
                    "marked": series.marked,
                    "bridged": if series.bridged_s < 1e9 { series.bridged_s } else { 1e9 },
                    "t": if thin.is_even { Value::Null } else { packed_times(&thin.points, span[0]).into() },
                    "y": values(1),
                    "s": if has_deviations { values(2) } else { Value::Null },
                })
            })
            .collect();
        let marks: Vec<Value> =
            self.marks.iter().map(|mark| json!([mark.span_s[0], mark.span_s[1], mark.text])).collect();
        let levels: Vec<f64> = self.levels.iter().map(|(level, _)| *level).collect();
        json!({
            "unit": self.unit,
            "range": range,
            "angle": self.is_angle,
            "size": self.is_size,
            "whole": self.top_level.is_some(),
            "series": series,
            "marks": marks,
            "levels": levels,
        })
    }
}

/// A number with about four digits.
pub fn in_digits(x: f64) -> String {
    let decimals = if x == 0.0 { 0.0 } else { (3.0 - x.abs().log10().floor()).clamp(0.0, 6.0) };
    fixed(x, decimals as usize)
}

/// Angles within this much are shown on an axis of their own.
const QUARTER_TURN_DEG: f64 = 90.0;

/// Least that such an axis shows to each side.
const LEAST_HALF_DEG: f64 = 5.0;

/// Jump of an angle at which a line breaks: the angle has passed north.
const HALF_TURN_DEG: f64 = 180.0;

fn broken_at_north(points: Vec<Point>, are_pairs: bool) -> Vec<Point> {
    let mut broken: Vec<Point> = Vec::with_capacity(points.len());
    for (number, point) in points.into_iter().enumerate() {
        let is_within = are_pairs && !number.is_multiple_of(2);
        if !is_within && broken.last().is_some_and(|before| (before[1] - point[1]).abs() > HALF_TURN_DEG) {
            broken.push([point[0], f64::NAN, 0.0]);
        }
        broken.push(point);
    }
    broken
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn line(points: Vec<Point>) -> Series {
        Series { name: "a".to_owned(), class: "x", points, bridged_s: 10.0, marked: false }
    }

    #[test]
    fn a_line_breaks_at_north_and_nowhere_else() {
        let of =
            |angles: &[f64], pairs| broken_at_north(angles.iter().map(|angle| [0.0, *angle, 0.0]).collect(), pairs);
        let at = |angles: &[f64]| of(angles, false);
        assert_eq!(at(&[10.0, 80.0, 170.0]).len(), 3);
        let broken = at(&[350.0, 359.0, 2.0]);
        assert!(broken.len() == 4 && broken[2][1].is_nan());
        // The least and the largest of a stretch are joined, and two stretches are not.
        let broken = of(&[2.0, 359.0, 1.0, 350.0], true);
        assert!(broken.len() == 5 && broken[2][1].is_nan());
    }

    #[test]
    fn nothing_to_show_is_no_plot() {
        let empty = Chart::new("a", "b", "c", vec![line(vec![[0.0, f64::NAN, 0.0]]), line(Vec::new())]);
        assert!(empty.drawn(0, [0.0, 1.0], ("time", "s")).is_none());
    }

    #[test]
    fn values_beyond_the_axis_are_told() {
        let mut points: Vec<Point> = (0..1_000).map(|k| [f64::from(k), 1.0, 0.0]).collect();
        points[7][1] = 50.0;
        let (drawn, data) =
            Chart::new("a", "b", "c", vec![line(points)]).of_sizes().drawn(0, [0.0, 1e3], ("time", "s")).unwrap();
        assert!(drawn.contains("1 value lies above the axis, the largest at 50.00"), "{drawn}");
        assert!(data["range"][1].as_f64().unwrap() < 2.0);
    }

    #[test]
    fn levels_have_all_of_their_axis() {
        let of =
            |points| Chart::new("a", "level", "c", vec![line(points)]).of_levels(7).drawn(0, [0.0, 3.0], ("time", "s"));
        let (_, data) = of(vec![[1.0, 0.0, 0.0], [2.0, 1.0, 0.0]]).unwrap();
        assert_eq!((data["range"].clone(), data["whole"].clone()), (json!([0.0, 7.0]), json!(true)));
        assert!(of(vec![[1.0, f64::NAN, 0.0]]).is_none());
    }

    #[test]
    fn a_band_that_runs_out_of_its_axis_is_told() {
        let mut points: Vec<Point> = (0..1_000).map(|k| [f64::from(k), f64::from(k % 9), 0.5]).collect();
        points[7][2] = 60.0;
        let drawn =
            |points: Vec<Point>| Chart::new("a", "b", "c", vec![line(points)]).drawn(0, [0.0, 1e3], ("time", "s"));
        let (told, _) = drawn(points.clone()).unwrap();
        assert!(told.contains("runs out of the axis at 0.1 % of the points; it is at most ± 60.00."), "{told}");
        points[7][2] = 0.5;
        assert!(!drawn(points).unwrap().0.contains("runs out"));
    }

    #[test]
    fn angles_of_a_quarter_have_an_axis_of_their_own_and_no_others() {
        let range = |angles: &[f64]| {
            let points = angles.iter().enumerate().map(|(k, angle)| [k as f64, *angle, 0.0]).collect();
            Chart::new("a", "deg", "c", vec![line(points)]).of_angles().range().unwrap()
        };
        assert_eq!(range(&[60.0, 62.0, 60.5]), [56.0, 66.0]);
        assert_eq!(range(&[2.0, 3.0]), [0.0, 7.5]);
        assert_eq!(range(&[1.0, 359.0]), [0.0, 360.0]);
        let zeros = Chart::new("a", "b", "c", vec![line(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])]).of_sizes();
        assert_eq!(zeros.range(), Some([0.0, 1.0]));
    }

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [0.0, 9.80665, -123.456, 0.00123, 54_321.0].map(in_digits),
            ["0", "9.807", "-123.5", "0.001230", "54321"]
        );
    }
}
