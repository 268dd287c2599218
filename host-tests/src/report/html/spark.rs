//! Small lines in the cells of a table.

use std::fmt::Write;

use super::{chart::in_digits, escape::escape};

/// Size of the drawing, in its own units, and the room that a point needs at its edges.
const WIDTH: f64 = 96.0;
const HEIGHT: f64 = 26.0;
const MARGIN: f64 = 4.0;

/// A point: its value, and whether it is marked.
pub(super) type Point = (f64, bool);

/// A line from the first point to the last, from its least value to its largest; marked points stand out.
pub(super) fn spark(name: &str, unit: &str, points: &[Point]) -> String {
    let values = || points.iter().map(|(x, _)| *x);
    let (Some(first), Some(last)) = (values().next(), values().next_back()) else { return String::new() };
    let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let at = |(index, (x, _)): (usize, &Point)| {
        let across = if points.len() > 1 { index as f64 / (points.len() - 1) as f64 } else { 1.0 };
        let up = if high > low { (x - low) / (high - low) } else { 0.5 };
        (MARGIN + across * (WIDTH - 2.0 * MARGIN), HEIGHT - MARGIN - up * (HEIGHT - 2.0 * MARGIN))
    };
    let line: Vec<String> = points.iter().enumerate().map(at).map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
    let dots = points.iter().enumerate().fold(String::new(), |mut out, (index, point)| {
        let is_last = index + 1 == points.len();
        if point.1 || is_last {
            let (x, y) = at((index, point));
            let class = if point.1 { "refused" } else { "end" };
            // Writing to a string does not fail.
            let _ = write!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\"/>");
        }
        out
    });
    let told = format!(
        "{name}: from {} to {} {unit} over {} windows; between {} and {}",
        in_digits(first),
        in_digits(last),
        points.len(),
        in_digits(low),
        in_digits(high)
    );
    let told = escape(&told);
    format!(
        "<svg class=\"spark\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{told}\"><title>{told}</title><path d=\"M{}\"/>{dots}</svg>",
        line.join("L")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_stays_inside_and_its_marked_points_stand_out() {
        let drawn = spark("P", "%", &[(1.0, false), (3.0, true), (2.0, false)]);
        assert!(drawn.contains("M4.0 22.0L48.0 4.0L92.0 13.0"), "{drawn}");
        assert_eq!((drawn.matches("refused").count(), drawn.matches("\"end\"").count()), (1, 1), "{drawn}");
        assert!(spark("P", "%", &[(1.0, false)]).contains("13.0"));
        assert_eq!(spark("P", "%", &[]), "");
    }
}
