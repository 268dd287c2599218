//! The path of a hole in space, seen from the south-west or the south-east and above, with its shadow on the ground of
//! the drawing.

use std::fmt::Write;

use super::{escape::escape, fixed};
use crate::surveys::run::SurveyedRun;

/// Width of the drawing in its own units, and the room around the path.
const WIDTH: f64 = 300.0;
const MARGIN: f64 = 24.0;

/// Stations between two that are joined to their shadows; about this many are.
const PLUMBS: usize = 8;

/// Where the path is seen from, beside above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// North goes to the upper left, east to the upper right.
    SouthWest,
    /// North goes to the upper right, west to the upper left.
    SouthEast,
}

impl Side {
    /// The side from which a path is seen across: seen along, it would fold up.
    fn across(path: &[[f64; 3]]) -> Self {
        let spread = |side: Self| {
            let right = || path.iter().map(|at| side.projected(*at)[0]);
            right().fold(f64::MIN, f64::max) - right().fold(f64::MAX, f64::min)
        };
        if spread(Self::SouthEast) > spread(Self::SouthWest) { Self::SouthEast } else { Self::SouthWest }
    }

    /// Place on the drawing of north, east and down in metres: horizontal axes go up by 30 degrees, and all three have
    /// one scale.
    fn projected(self, [north, east, down]: [f64; 3]) -> [f64; 2] {
        let (sine, cosine) = 30_f64.to_radians().sin_cos();
        let [right, away] = match self {
            Self::SouthWest => [east - north, east + north],
            Self::SouthEast => [north + east, north - east],
        };
        [right * cosine, down - away * sine]
    }
}

/// The figure; empty without two stations.
pub(super) fn drawing(run: &SurveyedRun) -> String {
    let path: Vec<[f64; 3]> = run.stations.iter().map(|station| station.position_m).collect();
    if path.len() < 2 {
        return String::new();
    }
    let ends =
        |k: usize| path.iter().map(|at| at[k]).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let [north, east, down] = [ends(0), ends(1), ends(2)];
    let ground = |at: [f64; 3]| [at[0], at[1], down.1];
    let from = Side::across(&path);
    // Axes begin at the corner of the ground that is nearest, and are as long as the path is wide.
    let (seen_from, nearest_east, second, sign) = match from {
        Side::SouthWest => ("south-west", east.0, "E", 1.0),
        Side::SouthEast => ("south-east", east.1, "W", -1.0),
    };
    let corner = [north.0, nearest_east, down.1];
    let length = (north.1 - north.0).max(east.1 - east.0).max(0.2 * (down.1 - down.0)).max(1.0);
    let (to_north, aside) =
        ([corner[0] + length, corner[1], corner[2]], [corner[0], corner[1] + sign * length, corner[2]]);
    let all: Vec<[f64; 2]> = path
        .iter()
        .flat_map(|at| [*at, ground(*at)])
        .chain([corner, to_north, aside])
        .map(|at| from.projected(at))
        .collect();
    let range =
        |k: usize| all.iter().map(|at| at[k]).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let [x, y] = [range(0), range(1)];
    let size = (x.1 - x.0).max(y.1 - y.0).max(1.0);
    let scale = (WIDTH - 2.0 * MARGIN) / size;
    let place = |at: [f64; 3]| {
        let [right, below] = from.projected(at);
        let off = 0.5 * (WIDTH - 2.0 * MARGIN - scale * (x.1 - x.0));
        format!("{:.1} {:.1}", MARGIN + off + scale * (right - x.0), MARGIN + scale * (below - y.0))
    };
    let line = |points: &mut dyn Iterator<Item = [f64; 3]>| points.map(place).collect::<Vec<_>>().join("L");
    let mut out = String::new();
    let [north_told, east_told, depth_told] =
        [north, east, down].map(|(low, high)| format!("{} to {} m", fixed(low, 0), fixed(high, 0)));
    let told = format!("North {north_told}, east {east_told}, depth {depth_told}.");
    let about = format!("From the {seen_from} and above; grey: the path's shadow on the ground below. {told}");
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<figure class=\"dial\">\n<h3>In space</h3>\n<p class=\"about\">{}</p>\n<svg viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\" aria-label=\"{}\">\n",
        escape(&about),
        2.0 * MARGIN + scale * (y.1 - y.0),
        escape(&format!("Path in space. {told}"))
    );
    for (end, name) in [(to_north, "N"), (aside, second)] {
        let _ = writeln!(out, "<path class=\"grid\" d=\"M{}L{}\"/>", place(corner), place(end));
        let text = place(end);
        let (at_x, at_y) = text.split_once(' ').unwrap_or(("0", "0"));
        let _ = writeln!(out, "<text x=\"{at_x}\" y=\"{at_y}\" text-anchor=\"middle\">{name}</text>");
    }
    let _ = writeln!(out, "<path class=\"before\" d=\"M{}\"/>", line(&mut path.iter().map(|at| ground(*at))));
    for at in path.iter().step_by(path.len().div_ceil(PLUMBS)) {
        let _ = writeln!(out, "<path class=\"grid\" d=\"M{}L{}\"/>", place(*at), place(ground(*at)));
    }
    let _ = writeln!(out, "<path class=\"after\" d=\"M{}\"/>", line(&mut path.iter().copied()));
    out + "</svg>\n</figure>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_goes_to_the_upper_left_east_to_the_upper_right_and_depth_down() {
        let [right, below] = Side::SouthWest.projected([1.0, 0.0, 0.0]);
        assert!(right < 0.0 && below < 0.0);
        let [right, below] = Side::SouthWest.projected([0.0, 1.0, 0.0]);
        assert!(right > 0.0 && below < 0.0);
        assert_eq!(Side::SouthWest.projected([0.0, 0.0, 2.0]), [0.0, 2.0]);
        // From the other side: north to the upper right, west to the upper left.
        let [right, below] = Side::SouthEast.projected([1.0, 0.0, 0.0]);
        assert!(right > 0.0 && below < 0.0);
        let [right, below] = Side::SouthEast.projected([0.0, -1.0, 0.0]);
        assert!(right < 0.0 && below < 0.0);
    }

    #[test]
    fn a_hole_is_seen_across() {
        let to = |north: f64, east: f64| [[0.0; 3], [north, east, 10.0]];
        assert_eq!([to(5.0, 4.0), to(-5.0, -4.0)].map(|path| Side::across(&path)), [Side::SouthEast; 2]);
        assert_eq!([to(5.0, -4.0), to(-5.0, 4.0)].map(|path| Side::across(&path)), [Side::SouthWest; 2]);
    }
}
