//! Table of the surveys of a flight.

use meerkat_mwd::survey::{Grade, SurveyKind, SurveyReport, Uncertain};

use super::{Page, Told, fixed, in_s, table};
use crate::report::surveys_csv::{grade, reason};

/// Adds the table, with the columns that any survey has.
pub(super) fn add(page: &mut Page, told: &Told) {
    let surveys = told.watched.map_or(&[][..], |watched| &watched.surveys);
    if surveys.is_empty() {
        return;
    }
    type Cell = fn(&SurveyReport) -> Option<String>;
    let columns: [(&str, Cell); 11] = [
        ("from, s", |r| Some(format!("{:.1}", in_s(r.survey.t_start_us)))),
        ("to, s", |r| Some(format!("{:.1}", in_s(r.survey.t_end_us)))),
        ("taken", |r| {
            Some(if r.survey.kind == SurveyKind::Rotating { "while rotating" } else { "at rest" }.to_owned())
        }),
        ("inclination, deg", |r| Some(degrees(r.survey.inclination_rad))),
        ("azimuth from magnetic north, deg", |r| r.survey.magnetic_azimuth_rad.map(degrees)),
        ("from true north, deg", |r| r.survey.true_azimuth_rad.map(degrees)),
        ("gravity toolface, deg", |r| r.survey.gravity_toolface_rad.map(degrees)),
        ("|G|, m/s²", |r| r.survey.gravity_m_s2.map(|x| uncertain(x, 4))),
        ("|B|, µT", |r| r.survey.field_ut.map(|x| uncertain(x, 2))),
        ("dip, deg", |r| r.survey.dip_rad.map(degrees)),
        ("quality", |r| {
            let why = if r.quality.grade == Grade::Good { "" } else { reason(r.quality.reason.checked) };
            let why = if why.is_empty() { String::new() } else { format!(": {why} is off") };
            Some(format!("{}{why}", grade(r.quality.grade)))
        }),
    ];
    let kept: Vec<_> =
        columns.into_iter().filter(|(_, cell)| surveys.iter().any(|report| cell(report).is_some())).collect();
    let head: Vec<&str> = kept.iter().map(|(name, _)| *name).collect();
    let row = |report: &SurveyReport| {
        let cells = kept.iter().map(|(_, cell)| cell(report).unwrap_or_default()).collect();
        (report.quality.grade != Grade::Good, cells)
    };
    page.add("<p>Mean directions at rest and over whole turns, with one deviation. Quality compares |G|, |B| and dip with what the place should have; what is not good is bold.</p>\n");
    page.add(&table(&head, surveys.iter().map(row)));
}

fn degrees(x: Uncertain) -> String {
    uncertain(Uncertain { value: x.value.to_degrees(), sigma: x.sigma.to_degrees() }, 2)
}

fn uncertain(x: Uncertain, digits: usize) -> String {
    format!("{} ± {:.digits$}", fixed(x.value, digits), x.sigma)
}
