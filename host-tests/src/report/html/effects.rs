//! Effects and magnets that were found, with their evidence.

use meerkat_mwd::{
    compensation::{Effect, Parameter},
    diagnosis::{DiagnosisReport, Verdict},
};

use super::{Chart, Page, Series, Told, escape::escape, figure, fixed, in_s, sentence, table};
use crate::{
    diagnosis::{BeforeAfter, Diagnosed, Found, rival_of_other_sensor, why_left_in},
    report::{
        account::{size, verdict_name},
        effect_words::{effect_words, name_and_unit, parameter_text},
        plain_words::use_of_field,
        remainder_text::remainder_text,
    },
};

/// Classes of lines that can be told apart, in the style sheet.
const CLASSES: [&str; 6] = ["x", "y", "z", "u", "v", "w"];

/// Adds the effects found with their estimates, and magnets.
pub(super) fn add(page: &mut Page, told: &Told) {
    let diagnosed = told.diagnosed;
    if !diagnosed.effects.is_empty() {
        page.add("<p>What else than scale, axes and bias of the gyro showed in the readings. The log Bayes factor says how sure that is: 5 is 150 to 1, 10 is 22,000 to 1. What it could also be is what these data cannot tell from it.</p>\n");
        page.add(&effects(diagnosed));
        if diagnosed.effects.iter().any(is_not_less) {
            page.add(NOT_LESS);
        }
        for found in &diagnosed.effects {
            estimates(page, diagnosed, found);
        }
    }
    if !diagnosed.magnets.is_empty() {
        page.add("<h3>Magnets that came and went</h3>\n");
        page.add(&magnets(diagnosed));
    }
}

/// Note for a reader who sees a residual that is no smaller without an effect.
const NOT_LESS: &str = "<p class=\"about\">A residual that is no smaller with an effect taken out does not speak against it. Over a \
    second the probe's own acceleration hides an error of the accelerometer, and an error that stays as it is cancels; the log Bayes \
    factor weighs all of the window.</p>\n";

/// Returns true if the residual is no smaller with the effect taken out.
fn is_not_less(found: &Found) -> bool {
    match found.residual_deg() {
        BeforeAfter { before: Some(before), after: Some(after) } => after > 0.99 * before,
        _ => false,
    }
}

/// Adds every diagnosis with all its candidates, the last one open.
pub(super) fn add_diagnoses(page: &mut Page, diagnosed: &Diagnosed) {
    if diagnosed.reports.is_empty() {
        return;
    }
    page.add("<p>Each diagnosis weighs every candidate. Evidence is a log Bayes factor, the likeliest come first: from 5 (drilling) or 10 (by hand) on an effect is found; 0 means that there is nothing of it.</p>\n");
    let last = diagnosed.reports.len();
    for (number, (report, library)) in diagnosed.reports.iter().enumerate() {
        page.add(&diagnosis(report, library, number + 1 == last));
    }
}

/// Adds the estimates of an effect over the diagnoses that found it.
fn estimates(page: &mut Page, diagnosed: &Diagnosed, found: &Found) {
    let effect = found.effect;
    // A plot has one unit, and no more lines than can be told apart: of a matrix of nine it has a row.
    let mut plots: Vec<(&str, Vec<Series>)> = Vec::new();
    let most = if effect.parameters().len() > CLASSES.len() { 3 } else { CLASSES.len() };
    for (k, parameter) in effect.parameters().iter().enumerate() {
        let (name, unit) = name_and_unit(parameter);
        let is_new = plots.last().is_none_or(|(other, series)| *other != unit || series.len() == most);
        if is_new {
            plots.push((unit, Vec::new()));
        }
        if let Some((_, series)) = plots.last_mut() {
            let class = CLASSES.get(series.len()).copied().unwrap_or_default();
            let points = points(diagnosed, effect, k, parameter);
            series.push(Series { name, class, points, bridged_s: f64::MAX, marked: true });
        }
    }
    let title = effect_words(effect).title;
    let is_one = plots.len() == 1;
    for (number, (unit, series)) in plots.into_iter().enumerate() {
        let about = if number == 0 {
            format!("{} Each point is a diagnosis' estimate, with one deviation.", effect_words(effect).what)
        } else {
            String::new()
        };
        let names: Vec<&str> = series.iter().map(|one| one.name.as_str()).collect();
        let which = if is_one { String::new() } else { format!(": {}", names.join(", ")) };
        let name = format!("{title}{which}, over the diagnoses");
        page.chart(Chart::new(&name, unit, &about, series));
    }
}

/// End of each diagnosis in seconds, the parameter it found and its deviation, in the parameter's unit.
fn points(diagnosed: &Diagnosed, effect: &dyn Effect, k: usize, parameter: &Parameter) -> Vec<[f64; 3]> {
    let reports = diagnosed.reports.iter();
    let of_report = reports.flat_map(|(report, library)| report.found().map(move |found| (report, *library, found)));
    let own = of_report.filter(|(_, library, found)| {
        library.get(usize::from(found.found.index)).is_some_and(|other| other.name() == effect.name())
    });
    own.map(|(report, _, found)| {
        let in_unit = |values: &[f32]| f64::from(values.get(k).copied().unwrap_or(0.0) * parameter.in_unit);
        [in_s(report.t_end_us), in_unit(&found.found.parameters), in_unit(&found.found.sigma)]
    })
    .collect()
}

/// Table of the effects found.
fn effects(diagnosed: &Diagnosed) -> String {
    let row = |found: &Found| {
        let in_seconds = |t_us: u64| format!("{:.1}", t_us as f64 * 1e-6);
        let taken_out = if found.report.is_taken_out() {
            in_seconds(found.report.taken_out_us)
        } else {
            format!("not{}", found.why_left_in())
        };
        let [from_s, _] = found.active_s;
        let cells = vec![
            format!("{} ({})", effect_words(found.effect).title, found.effect.name()),
            sizes(found),
            format!("{:.0}", found.report.evidence),
            before_after(&found.residual_deg()),
            format!("{from_s:.1}"),
            in_seconds(found.report.found_us),
            taken_out,
            found.aliases().join(", "),
        ];
        (false, cells)
    };
    let head = [
        "effect",
        "size",
        "log Bayes factor",
        "residual without and with it, deg rms",
        "there from, s",
        "found, s",
        "taken out, s",
        "could also be",
    ];
    table(&head, diagnosed.effects.iter().map(row))
}

fn before_after(residual: &BeforeAfter) -> String {
    if residual.before.is_none() && residual.after.is_none() {
        return String::new();
    }
    format!("{} to {}", figure(residual.before), figure(residual.after))
}

/// Parameters of an effect that was found, with their deviations and units.
pub(super) fn sizes(found: &Found) -> String {
    let both = found.report.found.parameters.iter().zip(&found.report.found.sigma);
    let texts = found.effect.parameters().iter().zip(both);
    texts.map(|(parameter, (x, sigma))| parameter_text(parameter, *x, *sigma)).collect::<Vec<_>>().join("; ")
}

/// Table of the magnets that came and went.
fn magnets(diagnosed: &Diagnosed) -> String {
    let rows = diagnosed.magnets.iter().map(|magnet| {
        let in_seconds = |t_us: u64| format!("{:.1}", t_us as f64 * 1e-6);
        let offsets =
            magnet.offset_ut.iter().zip(&magnet.sigma_ut).map(|(x, sigma)| format!("{} ± {sigma:.2}", fixed(*x, 2)));
        let cells = [in_seconds(magnet.from_us), magnet.to_us.map_or_else(|| "the end".to_owned(), in_seconds)];
        (false, cells.into_iter().chain(offsets).chain([use_of_field(magnet).to_owned()]).collect())
    });
    table(&["from, s", "to, s", "x, µT", "y, µT", "z, µT", "what was done"], rows)
}

/// One diagnosis with all its candidates, `open` or folded.
fn diagnosis(report: &DiagnosisReport, library: &[&'static dyn Effect], is_open: bool) -> String {
    let open = if is_open { " open=\"open\"" } else { "" };
    let [nis, nis_after] = report.nis;
    let mut out = format!(
        "<details{open}>\n<summary>{:.1} to {:.1} s: {}</summary>\n<p>Mean square of the innovations in units of their variance: {nis:.2} with the gyro's parameters alone, {nis_after:.2} with what was found.</p>\n",
        report.t_start_us as f64 * 1e-6,
        report.t_end_us as f64 * 1e-6,
        verdict_name(report.verdict).replace('_', " "),
    );
    if report.verdict == Verdict::UnexplainedResidual {
        out += &format!("<p>{}.</p>\n", escape(&sentence(&remainder_text(&report.remainder))));
    }
    let candidates = report.tried.iter().zip(library).take(report.candidates.into()).enumerate();
    let rows = candidates.map(|(index, (tried, effect))| {
        let found = report.found().find(|found| usize::from(found.found.index) == index);
        let outcome = found.map_or_else(String::new, |found| {
            let why = why_left_in(rival_of_other_sensor(found, library));
            let remark = if found.is_taken_out() { String::new() } else { format!("; not taken out{why}") };
            format!("found: {}{remark}", size(found, *effect).replace("+-", "±"))
        });
        let evidence = found.map_or(*tried, |found| found.evidence);
        let name = format!("{} ({})", effect_words(*effect).title, effect.name());
        (evidence, (found.is_some(), vec![name, fixed(evidence, 1), outcome]))
    });
    let mut rows: Vec<_> = rows.collect();
    rows.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let rows = rows.into_iter().map(|(_, row)| row);
    out += &table(&["candidate", "log Bayes factor beside what was found", "outcome"], rows);
    out + "</details>\n"
}
