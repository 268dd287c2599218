//! The toolface as a dial: the start in the middle, the end at the rim, as on a driller's screen.

use meerkat_mwd::{attitude::Attitude, probe::Output};

use super::{Page, escape::escape, fixed, in_s, thinned::Point};
use crate::report::toolface::{is_vertical, toolface_rad};

/// Points of a dial.
const POINTS: usize = 240;

/// Radius of the innermost and the outermost point, in a drawing that is 260 wide.
const RADII: [f64; 2] = [18.0, 104.0];

/// Points that the page's script has, of which it draws those of the time that is shown.
const KEPT: usize = 6_000;

/// Adds the dial; nothing without an attitude.
pub(super) fn add(page: &mut Page, outputs: &[Output]) {
    let degrees =
        |(t_us, attitude): (u64, Attitude)| [in_s(t_us), f64::from(toolface_rad(&attitude)).to_degrees(), 0.0];
    let points = |count: usize| {
        let step = outputs.len().div_ceil(count).max(1);
        let thin = outputs.iter().step_by(step).chain(outputs.last());
        thin.filter_map(|output| Some((output.t_us, *output.attitude.as_ref()?))).collect::<Vec<_>>()
    };
    let kept: Vec<Point> = points(KEPT).into_iter().map(degrees).collect();
    page.dial(&drawing(&points(POINTS)), &kept);
}

/// The dial without scripts.
fn drawing(points: &[(u64, Attitude)]) -> String {
    let (Some((first_us, _)), Some((last_us, last))) = (points.first(), points.last()) else { return String::new() };
    let kind = if is_vertical(last) { "magnetic toolface, 0 at north" } else { "gravity toolface, 0 at the highside" };
    let degrees = fixed(toolface_rad(last).to_degrees(), 1);
    let described =
        format!("Toolface from {:.1} to {:.1} s, at the end {degrees} deg", in_s(*first_us), in_s(*last_us));
    let mut out = format!(
        "<figure class=\"dial\">\n<h3>Toolface as a dial</h3>\n<p class=\"about\">The start of what is shown is in the middle, its end at the rim, \
         clockwise looking down-hole; {kind}.</p>\n<svg viewBox=\"-130 -125 260 250\" role=\"img\" aria-label=\"{}\">\n",
        escape(&described)
    );
    for radius in [35.0, 70.0, RADII[1]] {
        out += &format!("<circle class=\"grid\" r=\"{radius}\" fill=\"none\"/>\n");
    }
    for sector in 0..12 {
        let angle = f64::from(sector) * 30.0;
        let (sine, cosine) = angle.to_radians().sin_cos();
        let (x, y) = (RADII[1] * sine, -RADII[1] * cosine);
        out += &format!("<line class=\"grid\" x1=\"0\" y1=\"0\" x2=\"{x:.1}\" y2=\"{y:.1}\"/>\n");
        if sector % 3 == 0 {
            let (x, y) = (117.0 * sine, 4.0 - 114.0 * cosine);
            out += &format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{angle}</text>\n");
        }
    }
    let at = |t_us: u64, angle_rad: f64| {
        let share = (t_us - first_us) as f64 / (last_us - first_us).max(1) as f64;
        let radius = RADII[0] + (RADII[1] - RADII[0]) * share;
        (radius * angle_rad.sin(), -radius * angle_rad.cos())
    };
    out += "<g class=\"turns\">\n";
    for (t_us, attitude) in points {
        let (x, y) = at(*t_us, f64::from(toolface_rad(attitude)));
        out += &format!("<circle class=\"z\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\"/>\n");
    }
    let (x, y) = at(*last_us, f64::from(toolface_rad(last)));
    out += &format!("<circle class=\"x\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>\n</g>\n</svg>\n");
    out + "<p class=\"note\"></p>\n</figure>\n"
}
