//! Windows of a flight: their fits over time, why one was refused, and what flies at the end.

use meerkat_mwd::identification::{Decision, WindowReport};

use super::{Chart, Mark, Page, Series, Told, chart::in_digits, fixed, in_s, sentence, table};
use crate::report::{
    json::parameters::Parameters,
    refusal_text::decision_text,
    window_note::{span, why_no_window, window_note},
};

/// Adds plots of the fits and the table of the windows.
pub(super) fn add(page: &mut Page, told: &Told) {
    if let Some(why) = why_no_window(told.trace, told.config, told.flight) {
        page.add(&format!("<p>{}.</p>\n", super::escape::escape(&sentence(&why))));
        return;
    }
    page.add("<p>Each window identifies the gyro's errors: rate = P (raw rate - b). A point is a window's fit at its end, with one deviation to each side.</p>\n");
    let marks: Vec<Mark> =
        told.flight.reports.iter().filter(|report| report.decision != Decision::Accepted).map(refused).collect();
    let about = |what: &str| {
        let shaded = if marks.is_empty() { "" } else { " Shaded: refused windows; point at one to read why." };
        format!("{what}{shaded}")
    };
    let axes = [("x", "x"), ("y", "y"), ("z", "z")].into_iter().enumerate();
    let bias = axes.clone().map(|(k, (name, class))| {
        fitted(told, name, class, &|report| {
            [report.fitted.b_rad_s[k], report.sigma[9 + k]].map(|x| f64::from(x.to_degrees()))
        })
    });
    let what = about("Rate that the gyro reads at rest.");
    page.chart(Chart::new("Bias b", "deg/s", &what, bias.collect()).marked(&marks));
    let scale = axes.map(|(k, (name, class))| {
        fitted(told, name, class, &|report| {
            [report.fitted.p[k][k] - 1.0, report.sigma[4 * k]].map(|x| 100.0 * f64::from(x))
        })
    });
    let what = about("How much too little each axis reads: P's diagonal less 1.");
    page.chart(Chart::new("Scale factors", "%", &what, scale.collect()).marked(&marks));
    let pairs: [(&str, &'static str, usize, usize); 6] = [
        ("xy", "x", 0, 1),
        ("xz", "u", 0, 2),
        ("yx", "y", 1, 0),
        ("yz", "v", 1, 2),
        ("zx", "z", 2, 0),
        ("zy", "w", 2, 1),
    ];
    let cross = pairs.map(|(name, class, i, j)| {
        fitted(told, name, class, &|report| {
            [report.fitted.p[i][j], report.sigma[3 * i + j]].map(|x| 100.0 * f64::from(x))
        })
    });
    let what =
        about("How much of one axis' rate another axis lacks: the rest of P. xy is what x lacks of the rate about y.");
    page.chart(Chart::new("Cross-coupling", "%", &what, cross.into()).marked(&marks));
    let nis =
        fitted(told, "squared innovations over expected", "after", &|report| [f64::from(report.innovation_nis), 0.0]);
    let what = about(
        "How far the sensors disagree, squared, over what their noise accounts for. Far above 1 something is not modelled; below 1 the sensors are better than their data sheet.",
    );
    let chart = Chart::new("Consistency of the innovations", "ratio", &what, vec![nis]).of_sizes();
    page.chart(chart.marked(&marks).with_levels(vec![(1.0, "as the noise accounts for".to_owned())]));
    page.add("<p>Every window, accepted or refused; those that were refused are bold.</p>\n");
    page.add(&windows(told));
    page.add(COLUMNS);
    page.add("<h3>What flies at the end</h3>\n");
    page.add(&parameters(&Parameters::at_the_end(told.config, told.flight)));
}

/// Meaning of the columns of the table of windows.
const COLUMNS: &str = "<details>\n<summary>What the columns mean</summary>\n<ul>\n\
<li>Directions decided: how many of P's nine elements this motion shows.</li>\n\
<li>Innovations: how far the sensors disagree, squared, over what their noise accounts for; about 1 and less is sound.</li>\n\
<li>Change: by how much a whole turn reads differently since the model that flew before.</li>\n\
<li>Widths: how many times as large as their data sheets' the errors of five are, in this order: magnetometer matrix, hard iron, \
accelerometer matrix, magnetometer misalignment, accelerometer bias. 0: none shows; a large one blames its sensor.</li>\n\
<li>Cost: what the search for P had to make small, before and after. Evaluations: how many times it tried a P.</li>\n\
</ul>\n</details>\n";

fn refused(report: &WindowReport) -> Mark {
    let span_s = [in_s(report.t_start_us), in_s(report.t_end_us)];
    Mark { span_s, text: format!("window {} s {}", span(report), decision_text(&report.decision)) }
}

/// Picks a figure of a window and its deviation.
type Fit<'a> = &'a dyn Fn(&WindowReport) -> [f64; 2];

/// A figure of every window, as points with deviations.
fn fitted(told: &Told, name: &str, class: &'static str, fit: Fit) -> Series {
    let point = |report: &WindowReport| {
        let [x, sigma] = fit(report);
        [in_s(report.t_end_us), x, sigma]
    };
    let points = told.flight.reports.iter().map(point).collect();
    Series { name: name.to_owned(), class, points, bridged_s: f64::MAX, marked: true }
}

/// Table of the windows.
fn windows(told: &Told) -> String {
    let row = |report: &WindowReport| {
        let note = window_note(report, told.config).map_or_else(String::new, |note| format!("; {note}"));
        let cost = match (report.cost_before, report.cost_after) {
            (Some(before), Some(after)) => format!("{} to {}", in_digits(before.into()), in_digits(after.into())),
            _ => String::new(),
        };
        let cells = vec![
            span(report),
            decision_text(&report.decision) + &note,
            format!("{:.1}", report.rest_s),
            format!("{:.1}", report.motion_s),
            report.directions_decided.to_string(),
            format!("{:.2}", report.innovation_nis),
            format!("{:.2}", report.deg_per_turn),
            report.widths.map(|width| format!("{width:.1}")).join(", "),
            cost,
            report.evaluations.to_string(),
        ];
        (report.decision != Decision::Accepted, cells)
    };
    let head = [
        "window, s",
        "decision",
        "rest, s",
        "motion since the start, s",
        "directions of P decided, of 9",
        "innovations, squared over expected",
        "change, deg per turn",
        "widths",
        "cost",
        "evaluations",
    ];
    table(&head, told.flight.reports.iter().map(row))
}

/// Table of P and b with their deviations.
fn parameters(last: &Parameters) -> String {
    let (p_sigma, b_sigma) = last.sigma.split_at(9);
    let prior = if last.is_prior { " (prior)" } else { "" };
    let rows = last.p.chunks(3).zip(p_sigma.chunks(3)).zip(last.b_rad_s.iter().zip(b_sigma)).zip(["x", "y", "z"]);
    let rows = rows.map(|(((p, p_sigma), (b, b_sigma)), axis)| {
        let elements = p.iter().zip(p_sigma).map(|(p, sigma)| format!("{} ± {sigma:.5}", fixed(*p, 5)));
        let bias = format!("{} ± {:.4}{prior}", fixed(b.to_degrees(), 4), b_sigma.to_degrees());
        (false, [axis.to_owned()].into_iter().chain(elements).chain([bias]).collect())
    });
    table(&["axis", "P, times raw x", "raw y", "raw z", "b, deg/s"], rows)
}
