//! Tables of a flight.

use meerkat_mwd::{
    Config,
    identification::{Decision, WindowReport},
};

use crate::{
    flight::Flight,
    report::{
        html::{diagnosis::per_model, figure, table},
        json::parameters::Parameters,
        refusal_text::decision_text,
        window_note::{span, window_note},
    },
    score::{PerModel, Reference},
};

/// Tables of the scores that only a replay shows.
pub(super) fn scores(reference: &Reference) -> String {
    let mut out = String::new();
    if reference.rest_gravity_deg != PerModel::default() {
        out += &per_model("gravity from rest to rest, deg rms", &[("", &reference.rest_gravity_deg)]);
    }
    let attitude = &reference.attitude_rms_deg;
    let parts = [attitude.total, attitude.heading, attitude.inclination].map(figure);
    out + &table(&["attitude, deg rms: total", "heading", "inclination"], [(false, parts.to_vec())])
}

/// Table of the windows.
pub(super) fn windows(config: &Config, flight: &Flight) -> String {
    let row = |report: &WindowReport| {
        let note = window_note(report, config).map_or_else(String::new, |note| format!("; {note}"));
        let number = |x: Option<f32>, digits: usize| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"));
        let cells = vec![
            span(report),
            decision_text(&report.decision) + &note,
            format!("{:.1}", report.rest_s),
            format!("{:.1}", report.motion_s),
            report.directions_decided.to_string(),
            format!("{:.2}", report.innovation_nis),
            format!("{:.2}", report.deg_per_turn),
            report.widths.map(|width| format!("{width:.1}")).join(", "),
            format!("{} to {}", number(report.cost_before, 1), number(report.cost_after, 1)),
            report.evaluations.to_string(),
        ];
        (report.decision == Decision::Accepted, cells)
    };
    let head = [
        "window, s",
        "decision",
        "rest, s",
        "motion since the start, s",
        "directions of P decided, of 9",
        "innovations, squared over expected",
        "change, deg per turn",
        "widths of magnetometer matrix, hard iron, accelerometer over the data sheet's",
        "cost",
        "evaluations",
    ];
    table(&head, flight.reports.iter().map(row))
}

/// Table of P and b with their deviations.
pub(super) fn parameters(last: &Parameters) -> String {
    let (p_sigma, b_sigma) = last.sigma.split_at(9);
    let prior = if last.is_prior { " (prior)" } else { "" };
    let rows = last.p.chunks(3).zip(p_sigma.chunks(3)).zip(last.b_rad_s.iter().zip(b_sigma)).zip(["x", "y", "z"]);
    let rows = rows.map(|(((p, p_sigma), (b, b_sigma)), axis)| {
        let elements = p.iter().zip(p_sigma).map(|(p, sigma)| format!("{p:.5} ± {sigma:.5}"));
        let bias = format!("{:.4} ± {:.4}{prior}", b.to_degrees(), b_sigma.to_degrees());
        (false, [axis.to_owned()].into_iter().chain(elements).chain([bias]).collect())
    });
    table(&["", "P", "", "", "b, deg/s"], rows)
}

/// Table of the counters.
pub(super) fn counts(counts: &[(&str, u64)]) -> String {
    table(&["", "count"], counts.iter().map(|(name, count)| (false, vec![(*name).to_owned(), count.to_string()])))
}
