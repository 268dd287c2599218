//! Plots over time, as SVG.

use std::fmt::Write;

use super::escape::escape;

/// Height and margins of a drawing, in its own units.
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 46.0;

/// Largest step between points of several series at one time.
const BESIDE: f64 = 7.0;

/// Room above a drawing of its own, for title and legend.
const HEAD: f64 = 44.0;

/// Style of a drawing of its own; the classes are those of the pages' style sheet.
const STANDALONE_STYLE: &str = "\
    svg { font: 11px system-ui, sans-serif; }\n\
    text { fill: #5a6675; }\n\
    .title { font-size: 14px; fill: #1c2430; }\n\
    path { fill: none; stroke-width: 1.4; }\n\
    line { stroke-width: 1.4; }\n\
    .grid { stroke: #e6e9ee; }\n\
    .before { stroke: #a3acb8; }\n\
    .after { stroke: #2864a8; }\n\
    .x { stroke: #b4541a; }\n";

/// Approximate number of intervals of an axis.
const INTERVALS: f64 = 5.0;

/// One line or set of points.
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Class in the style sheet.
    pub class: &'static str,
    /// Time in seconds, value, deviation (0 if none). A value that is not finite breaks the line.
    pub points: Vec<[f64; 3]>,
    /// Longest step that the line bridges, seconds.
    pub bridged_s: f64,
    /// True if each point is marked.
    pub marked: bool,
}

/// A plot of some series over time.
pub struct Plot<'a> {
    /// Width of the drawing, in its own units.
    pub width: f64,
    /// Unit of the values.
    pub unit: &'a str,
    /// Name and unit of the axis below, mostly time.
    pub over: &'a str,
    /// True if that axis counts days since 1970, which are written as dates.
    pub is_of_days: bool,
    /// Start of that axis.
    pub from: f64,
    /// End of that axis.
    pub to: f64,
    /// Range of the value axis; values beyond it are drawn on its edge.
    pub range: [f64; 2],
    /// Shaded intervals of time.
    pub shaded_s: &'a [[f64; 2]],
    /// Values that are drawn as lines from side to side: limits, and what is expected.
    pub levels: &'a [f64],
    /// The lines and points.
    pub series: Vec<Series>,
}

impl Plot<'_> {
    /// Width of a drawing as wide as the page, in its own units.
    pub const WIDE: f64 = 900.0;

    /// Width of a drawing that a narrow screen shows whole.
    pub const NARROW: f64 = 420.0;

    fn x(&self, t_s: f64) -> f64 {
        let share = (t_s - self.from) / (self.to - self.from).max(1e-9);
        LEFT + (self.width - LEFT - RIGHT) * share.clamp(0.0, 1.0)
    }

    fn y(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let share = (value - low) / (high - low).max(1e-30);
        TOP + (HEIGHT - TOP - BOTTOM) * (1.0 - share.clamp(0.0, 1.0))
    }

    /// The plot as SVG for a page, which has style sheet and legend; `described` is for a reader who does not see it.
    #[must_use]
    pub fn draw(&self, described: &str) -> String {
        let label = escape(described);
        let width = self.width;
        let mut out = format!("<svg viewBox=\"0 0 {width} {HEIGHT}\" role=\"img\" aria-label=\"{label}\">\n");
        self.draw_all(&mut out);
        out + "</svg>\n"
    }

    /// The plot as an SVG file of its own: style, white ground, title and legend are inside.
    #[must_use]
    pub fn standalone(&self, title: &str) -> String {
        let (width, height) = (self.width, HEIGHT + HEAD);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 {} {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\n\
             <title>{title}</title>\n<style>\n{STANDALONE_STYLE}</style>\n<rect y=\"{}\" width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
             <text class=\"title\" x=\"{LEFT}\" y=\"{}\">{title}</text>\n",
            -HEAD,
            -HEAD,
            -HEAD + 18.0,
            title = escape(title),
        );
        let mut x = LEFT;
        for series in &self.series {
            let (end, text, name) = (x + 20.0, x + 26.0, escape(&series.name));
            let class = series.class;
            out += &format!("<line class=\"{class}\" x1=\"{x}\" y1=\"-8\" x2=\"{end}\" y2=\"-8\"/>\n");
            out += &format!("<text x=\"{text}\" y=\"-4\">{name}</text>\n");
            // Letters of 11 units are on the mean 6 wide.
            x = text + 6.0 * series.name.len() as f64 + 24.0;
        }
        self.draw_all(&mut out);
        out + "</svg>\n"
    }

    /// Axes and series. Writing to a string does not fail.
    fn draw_all(&self, out: &mut String) {
        let _ = self.draw_axes(out);
        for level in self.levels {
            let (right, y) = (self.width - RIGHT, self.y(*level));
            let _ = writeln!(out, "<line class=\"limit\" x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>");
        }
        // Points of several series at one time stand beside each other, so that their deviations can be told apart.
        let have_deviations = self.series.iter().flat_map(|series| &series.points).any(|[_, _, sigma]| *sigma > 0.0);
        let are_beside = have_deviations && self.series.len() > 2;
        for (number, series) in self.series.iter().enumerate() {
            let beside = if series.marked && are_beside {
                self.beside() * (number as f64 - 0.5 * (self.series.len() - 1) as f64)
            } else {
                0.0
            };
            let _ = self.draw_series(out, series, beside);
        }
    }

    /// Step between points of several series at one time: so small that none passes the next point of its neighbour.
    fn beside(&self) -> f64 {
        let times = |series: &Series| series.points.iter().map(|[t_s, _, _]| self.x(*t_s)).collect::<Vec<_>>();
        let apart = |times: Vec<f64>| match times[..] {
            [first, .., last] => (last - first) / (times.len() - 1) as f64,
            _ => f64::MAX,
        };
        let least = self.series.iter().map(times).map(apart).fold(f64::MAX, f64::min);
        BESIDE.min(least / self.series.len() as f64)
    }

    fn draw_axes(&self, out: &mut String) -> std::fmt::Result {
        let (right, bottom) = (self.width - RIGHT, HEIGHT - BOTTOM);
        for [from_s, to_s] in self.shaded_s {
            let (x, to) = (self.x(*from_s), self.x(*to_s));
            let (width, height) = (to - x, bottom - TOP);
            writeln!(
                out,
                "<rect class=\"shaded\" x=\"{x:.1}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height}\"/>"
            )?;
        }
        for (value, text) in ticks(self.range) {
            let y = self.y(value);
            writeln!(out, "<line class=\"grid\" x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>")?;
            let (x, y) = (LEFT - 6.0, y + 5.0);
            writeln!(out, "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{text}</text>")?;
        }
        for (value, text) in ticks([self.from, self.to]) {
            let text = if self.is_of_days { date(value) } else { text };
            let (x, y) = (self.x(value), bottom + 19.0);
            writeln!(out, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{text}</text>")?;
        }
        let (middle, end, over) = (0.5 * (LEFT + right), HEIGHT - 4.0, escape(self.over));
        writeln!(out, "<text x=\"{middle}\" y=\"{end}\" text-anchor=\"middle\">{over}</text>")?;
        let (y, unit) = (0.5 * (TOP + bottom), escape(self.unit));
        writeln!(out, "<text transform=\"translate(16 {y}) rotate(-90)\" text-anchor=\"middle\">{unit}</text>")
    }

    /// The bands of two deviations and of one to each side of a line.
    fn draw_bands(&self, out: &mut String, series: &Series) -> std::fmt::Result {
        let is_broken = |point: &&[f64; 3]| !point[1].is_finite();
        for stretch in series.points.split(|point| is_broken(&point)).filter(|stretch| stretch.len() > 1) {
            for wide in [2.0, 1.0] {
                let upper = stretch.iter().map(|[t_s, x, sigma]| (*t_s, x + wide * sigma));
                let lower = stretch.iter().rev().map(|[t_s, x, sigma]| (*t_s, x - wide * sigma));
                let corners = upper.chain(lower).map(|(t_s, x)| format!("{:.1} {:.1}", self.x(t_s), self.y(x)));
                writeln!(out, "<path class=\"band\" d=\"M{}Z\"/>", corners.collect::<Vec<_>>().join("L"))?;
            }
        }
        Ok(())
    }

    fn draw_series(&self, out: &mut String, series: &Series, beside: f64) -> std::fmt::Result {
        if !series.marked && series.points.iter().any(|[_, _, sigma]| *sigma > 0.0) {
            self.draw_bands(out, series)?;
        }
        let mut path = String::new();
        let mut last_s = f64::NEG_INFINITY;
        for [t_s, value, _] in &series.points {
            if !value.is_finite() {
                last_s = f64::NEG_INFINITY;
                continue;
            }
            let command = if t_s - last_s > series.bridged_s { 'M' } else { 'L' };
            write!(path, "{command}{:.1} {:.1}", self.x(*t_s) + beside, self.y(*value))?;
            last_s = *t_s;
        }
        let class = series.class;
        writeln!(out, "<path class=\"{class}\" d=\"{path}\"/>")?;
        for [t_s, value, sigma] in series.points.iter().filter(|[_, value, _]| series.marked && value.is_finite()) {
            let (x, low, high) = (self.x(*t_s) + beside, self.y(value - sigma), self.y(value + sigma));
            writeln!(out, "<line class=\"{class}\" x1=\"{x:.1}\" y1=\"{low:.1}\" x2=\"{x:.1}\" y2=\"{high:.1}\"/>")?;
            writeln!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{:.1}\" r=\"3\"/>", self.y(*value))?;
        }
        Ok(())
    }
}

/// Day since 1970, as a date.
fn date(day: f64) -> String {
    let date = chrono::DateTime::from_timestamp(86_400 * day.floor() as i64, 0);
    date.map_or_else(String::new, |date| date.date_naive().to_string())
}

/// Round values over a range, with their texts.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    let rough = (high - low) / INTERVALS;
    if !(rough > 0.0 && rough.is_finite()) {
        return Vec::new();
    }
    let decade = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|k| k * decade).into_iter().find(|step| *step >= rough).unwrap_or(rough);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    // Multiples of the step by whole numbers, so that zero is 0 and not -0.
    (first..=last).map(|k| k as f64 * step).map(|value| (value, format!("{value:.decimals$}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(series: Vec<Series>) -> Plot<'static> {
        Plot {
            width: Plot::WIDE,
            unit: "deg",
            over: "time, s",
            is_of_days: false,
            from: 0.0,
            to: 1.0,
            range: [0.0, 2.0],
            shaded_s: &[],
            levels: &[],
            series,
        }
    }

    #[test]
    fn a_drawing_of_its_own_has_title_style_and_legend_inside_and_closes_every_tag() {
        let series = Series {
            name: "a < b".to_owned(),
            class: "after",
            points: vec![[0.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
            bridged_s: 2.0,
            marked: false,
        };
        let drawn = plot(vec![series]).standalone("Error & time");
        assert!(drawn.starts_with("<svg xmlns=") && drawn.ends_with("</svg>\n"), "{drawn}");
        assert!(drawn.contains(">Error &amp; time</text>") && drawn.contains(">a &lt; b</text>"), "{drawn}");
        for tag in ["svg", "style", "text", "title"] {
            let opened = drawn.matches(&format!("<{tag} ")).count() + drawn.matches(&format!("<{tag}>")).count();
            assert_eq!(opened, drawn.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn points_of_one_time_stand_beside_each_other_and_pass_none_of_another_time() {
        let series = |count: u32| Series {
            name: "a".to_owned(),
            class: "x",
            points: (0..count).map(|k| [f64::from(k) / f64::from(count), 1.0, 0.1]).collect(),
            bridged_s: 2.0,
            marked: true,
        };
        let beside = |count: u32| plot([0; 3].map(|_| series(count)).into()).beside();
        assert!((beside(1) - BESIDE).abs() < 1e-9 && (beside(4) - BESIDE).abs() < 1e-9);
        assert!(3.0 * beside(142) < 804.0 / 142.0 + 1e-9, "{}", beside(142));
    }

    #[test]
    fn a_drawing_has_both_bands_and_its_limits() {
        let points = vec![[0.0, 5.0, 1.0], [1.0, 5.0, 1.0]];
        let series = Series { name: "a".to_owned(), class: "after", points, bridged_s: 2.0, marked: false };
        let plot = Plot {
            width: Plot::WIDE,
            unit: "deg",
            over: "time, s",
            is_of_days: false,
            from: 0.0,
            to: 1.0,
            range: [0.0, 10.0],
            shaded_s: &[],
            levels: &[2.5],
            series: vec![series],
        };
        let drawn = plot.draw("a");
        for value in [3.0, 4.0, 6.0, 7.0] {
            assert!(drawn.contains(&format!("{LEFT:.1} {:.1}", plot.y(value))), "{value}: {drawn}");
        }
        let y = plot.y(2.5);
        assert!(drawn.contains(&format!("<line class=\"limit\" x1=\"{LEFT}\" y1=\"{y:.1}\"")), "{drawn}");
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let texts = |range| ticks(range).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts([0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts([-3.0, 110.0]), ["0", "50", "100"]);
        assert_eq!(texts([0.011, 0.013]), ["0.0110", "0.0115", "0.0120", "0.0125", "0.0130"]);
        assert!(texts([1.0, 1.0]).is_empty() && texts([0.0, f64::NAN]).is_empty());
    }
}
