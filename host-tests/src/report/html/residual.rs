//! Residuals of gravity and field, and the gyro's rotation against the reference, each before and after.

use super::{Chart, Mark, Page, Series, Told, figure, fixed, in_s, line, regressor, table};
use crate::{
    diagnosis::{BeforeAfter, Diagnosed},
    report::{
        effect_words::effect_words,
        plain_words::{in_a_sentence, use_of_field},
    },
};
use testbed::score::{PerModel, rotation_errors};

/// Longest step between residuals that a line bridges, seconds; residuals span one second.
const BRIDGED_S: f64 = 1.5;

/// Adds figures and plots of the residuals.
pub(super) fn add(page: &mut Page, told: &Told) {
    let residual = &told.diagnosed.residual;
    let rows = [
        ("gravity, deg rms", &residual.gravity_deg),
        ("field, deg rms", &residual.magnetic_deg),
        ("innovations, squared over expected (last diagnosis)", &residual.nis),
    ];
    let known: Vec<_> =
        rows.into_iter().filter(|(_, x): &(&str, &BeforeAfter)| x.before.is_some() || x.after.is_some()).collect();
    if known.is_empty() {
        return;
    }
    page.add("<p>Gravity and field as the gyro predicts them from a second before, less what was measured. Before: the bias alone is taken out. After: all that flew. A probe that is shaken or swung accelerates, and that stays in gravity's residual however good the gyro is.</p>\n");
    let row = |(name, x): (&str, &BeforeAfter)| (false, vec![name.to_owned(), figure(x.before), figure(x.after)]);
    page.add(&table(&["residual", "before", "after"], known.into_iter().map(row)));
    let over_time = &told.diagnosed.residual_over_time;
    let marks = magnets(told.diagnosed);
    for (vector, name) in
        ["Residual of gravity over a second", "Residual of the field over a second"].into_iter().enumerate()
    {
        let [Some(before), Some(after)] = [over_time.before.get(vector), over_time.after.get(vector)] else { continue };
        let series = |name: &str, class, points: &[[f64; 2]]| Series {
            bridged_s: BRIDGED_S,
            ..line(name, class, points.iter().map(|[t_s, angle]| [*t_s, *angle, 0.0]).collect(), [0.0, 0.0])
        };
        let both = vec![series("before", "before", before), series("after", "after", after)];
        let mut about = if is_covered(before, after) { COVERED.to_owned() } else { String::new() };
        about += if marks.is_empty() { "" } else { "Shaded: a magnet is there." };
        page.chart(Chart::new(name, "deg", &about, both).of_sizes().marked(&marks));
        let mut against = regressor::figure(told, name, "", ["before", "after"], before, after);
        let shown_by = told.diagnosed.effects.iter().filter_map(|found| Some((found, found.without.as_ref()?)));
        for (found, without) in shown_by.filter(|(_, without)| without.vector == vector) {
            let which = format!(": {} left in and taken out", in_a_sentence(&effect_words(found.effect)));
            against += &regressor::figure(told, name, &which, ["left in", "taken out"], &without.angles, after);
        }
        page.add(&format!("<div class=\"pair\">\n{against}</div>\n"));
    }
}

/// Note for a reader who sees one line of two.
const COVERED: &str = "Before and after are so alike that one line covers the other. ";

/// Returns true if one line covers the other: nowhere is it off by more than a hundredth of the largest.
fn is_covered(before: &[[f64; 2]], after: &[[f64; 2]]) -> bool {
    let largest = before.iter().map(|[_, angle]| angle.abs()).fold(0.0, f64::max);
    let mut pairs = before.iter().zip(after);
    before.len() == after.len() && pairs.all(|([_, a], [_, b])| (a - b).abs() < 0.01 * largest)
}

/// Intervals with a magnet.
pub(super) fn magnets(diagnosed: &Diagnosed) -> Vec<Mark> {
    let mark = |magnet: &meerkat_mwd::magnet::HardIronInterval| Mark {
        span_s: [in_s(magnet.from_us), magnet.to_us.map_or(1e9, in_s)],
        text: format!("a magnet is there, {}", use_of_field(magnet)),
    };
    diagnosed.magnets.iter().map(mark).collect()
}

/// Picks the error of one way to read the gyro, degrees.
type Reading = fn(&PerModel) -> Option<f64>;

/// Adds the gyro's rotation errors against the reference, with their figures.
pub(super) fn add_rotation(page: &mut Page, told: &Told) {
    let Some(reference) = told.reference else { return };
    let rows = [
        ("rotation over 2 s", &reference.orientation_2s_rms_deg),
        ("the same, with the reference's delay taken out", &reference.orientation_2s_rms_time_aligned_deg),
        ("gravity from rest to rest", &reference.rest_gravity_deg),
    ];
    let known: Vec<_> = rows.into_iter().filter(|(_, scores)| **scores != PerModel::default()).collect();
    if !known.is_empty() {
        let head = ["deg rms", "raw gyro", "bias alone taken out", "12 parameters", "as flown, with effects"];
        let row = |(name, scores): (&str, &PerModel)| {
            let scores = [scores.uncompensated, scores.bias_only, scores.twelve_parameters, scores.with_effects];
            (false, [name.to_owned()].into_iter().chain(scores.map(figure)).collect())
        };
        page.add(&table(&head, known.into_iter().map(row)));
    }
    let attitude = &reference.attitude_rms_deg;
    if attitude.total.is_some() {
        let parts = [attitude.total, attitude.heading, attitude.inclination].map(figure);
        let cells = ["attitude, deg rms".to_owned()].into_iter().chain(parts).collect();
        page.add(&table(&["error", "total", "heading", "inclination"], [(false, cells)]));
    }
    let errors = rotation_errors(told.trace, told.flight, &told.settings());
    let first_s = told.span_s()[0];
    let of = |errors: &[(f64, PerModel)], reading: Reading| -> Vec<[f64; 3]> {
        let point = |(t_s, error): &(f64, PerModel)| [first_s + t_s, reading(error).unwrap_or(f64::NAN), 0.0];
        errors.iter().map(point).collect()
    };
    let lines: [(&str, &'static str, Reading); 3] = [
        ("raw gyro", "before", |error| error.uncompensated),
        ("bias alone taken out", "x", |error| error.bias_only),
        ("as flown", "after", |error| error.with_effects),
    ];
    let series = |errors: &[(f64, PerModel)]| -> Vec<Series> {
        let one = |(name, class, reading): (&str, &'static str, Reading)| Series {
            bridged_s: 2.0 * BRIDGED_S,
            ..line(name, class, of(errors, reading), [0.0, 0.0])
        };
        lines.map(one).into()
    };
    let about = format!(
        "Error of the gyro's rotation over each 2 s against the reference, whose delay of {} ms is taken out.",
        fixed(errors.delay_ms, 1)
    );
    page.chart(Chart::new("Rotation error", "deg", &about, series(&errors.deg)).of_sizes());
    for (axis, errors) in ["x", "y", "z"].iter().zip(&errors.about_axes_deg) {
        let about = format!("The part of it about the body's {axis} at the end of the 2 s, with its sign.");
        page.chart(Chart::new(&format!("Rotation error about {axis}"), "deg", &about, series(errors)));
    }
}
