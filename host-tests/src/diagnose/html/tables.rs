//! Tables of the page.

use meerkat_mwd::{
    compensation::Effect,
    diagnosis::{DiagnosisReport, Tried, Verdict},
};

use crate::{
    diagnose::{BeforeAfter, Diagnosed, Found, remainder_text, verdict_name},
    page::{escape, figure, sentence, table},
    score::{PerModel, Reference},
};

/// Residuals before and after.
pub(super) fn residual(diagnosed: &Diagnosed) -> String {
    let residual = &diagnosed.residual;
    let row = |name: &str, x: &BeforeAfter| (false, vec![name.to_owned(), figure(x.before), figure(x.after)]);
    table(
        &["", "before", "after"],
        [
            row("gravity, deg rms", &residual.gravity_deg),
            row("field, deg rms", &residual.magnetic_deg),
            row("field, mean square in units of its white noise (last diagnosis)", &residual.nis),
        ],
    )
}

/// Scores against the reference.
pub(crate) fn reference(reference: &Reference) -> String {
    let rows = [
        ("as it is", &reference.orientation_2s_rms_deg),
        ("one delay taken out", &reference.orientation_2s_rms_time_aligned_deg),
    ];
    format!("<h3>Against the reference</h3>\n{}", per_model("rotation over 2 s, deg rms", &rows))
}

/// A score of each way to read the gyro.
pub(crate) fn per_model(what: &str, rows: &[(&str, &PerModel)]) -> String {
    let rows = rows.iter().map(|(name, scores)| {
        let scores = [scores.uncompensated, scores.bias_only, scores.twelve_parameters, scores.with_effects];
        (false, [(*name).to_owned()].into_iter().chain(scores.map(figure)).collect())
    });
    table(&[what, "uncompensated", "bias only", "12 parameters", "with effects"], rows)
}

/// The effects that the last diagnosis holds.
pub(crate) fn effects(diagnosed: &Diagnosed) -> String {
    if diagnosed.effects.is_empty() {
        return "<p>None.</p>\n".to_owned();
    }
    let row = |found: &Found| {
        let [before, after] = found.report.residual_rad.map(f32::to_degrees);
        let [from_s, to_s] = found.active_s;
        let taken_out = if found.report.believed { "taken out" } else { "named, not taken out: larger than it can be" };
        let cells = vec![
            found.effect.name().to_owned(),
            parameters(found),
            format!("{:.0}", found.report.evidence),
            format!("{:.4}", found.report.p_value),
            format!("{before:.3} to {after:.3}"),
            format!("{from_s:.1} to {to_s:.1}"),
            taken_out.to_owned(),
            found.effect.aliases().join(", "),
        ];
        (false, cells)
    };
    let head =
        ["effect", "size", "evidence", "chance", "residual, deg rms", "from when to when, s", "", "could also be"];
    table(&head, diagnosed.effects.iter().map(row))
}

fn parameters(found: &Found) -> String {
    let both = found.report.found.parameters.iter().zip(&found.report.found.sigma);
    let texts = found.effect.parameters().iter().zip(both).map(|(parameter, (x, sigma))| {
        format!("{} {:.3} ± {:.3}", parameter.name, x * parameter.in_unit, sigma * parameter.in_unit)
    });
    texts.collect::<Vec<_>>().join("; ")
}

/// Intervals of hard iron.
pub(crate) fn magnets(diagnosed: &Diagnosed) -> String {
    if diagnosed.magnets.is_empty() {
        return "<p>None.</p>\n".to_owned();
    }
    let rows = diagnosed.magnets.iter().map(|magnet| {
        let in_seconds = |t_us: u64| format!("{:.1}", t_us as f64 * 1e-6);
        let offsets = magnet.offset_ut.iter().zip(&magnet.sigma_ut).map(|(x, sigma)| format!("{x:.2} ± {sigma:.2}"));
        let cells = [in_seconds(magnet.from_us), magnet.to_us.map_or_else(|| "the end".to_owned(), in_seconds)];
        let what = if magnet.corrected { "taken out" } else { "the field is not used while it lasts" };
        (false, cells.into_iter().chain(offsets).chain([what.to_owned()]).collect())
    });
    table(&["from, s", "to, s", "x, uT", "y, uT", "z, uT", ""], rows)
}

/// One diagnosis with all its candidates, folded up or not.
pub(super) fn diagnosis(report: &DiagnosisReport, library: &[&dyn Effect], is_open: bool) -> String {
    let open = if is_open { " open=\"open\"" } else { "" };
    let [gravity, field] = report.residual_before_rad.map(f32::to_degrees);
    let [gravity_after, field_after] = report.residual_after_rad.map(f32::to_degrees);
    let [nis, nis_after] = report.nis;
    let mut out = format!(
        "<details{open}>\n<summary>{:.1} to {:.1} s: {}</summary>\n<p>Residual of gravity {gravity:.2} to {gravity_after:.2} deg, of the field {field:.3} to {field_after:.3} deg rms; mean square of the field's in units of its noise {nis:.1} to {nis_after:.1}.</p>\n",
        report.t_start_us as f64 * 1e-6,
        report.t_end_us as f64 * 1e-6,
        verdict_name(report.verdict).replace('_', " "),
    );
    if report.verdict == Verdict::UnexplainedResidual {
        out += &format!("<p>{}.</p>\n", escape(&sentence(&remainder_text(&report.remainder))));
    }
    let candidates = report.tried.iter().zip(library).take(report.candidates.into()).enumerate();
    let rows = candidates.map(|(index, (tried, effect))| {
        let added = report.found().find(|found| usize::from(found.found.index) == index);
        let (evidence, p_value) =
            added.map_or((tried.evidence, tried.p_value), |found| (found.evidence, found.p_value));
        let outcome = added.map_or_else(
            || why_refused(tried, report).to_owned(),
            |found| {
                let remark = if found.believed { "" } else { "; larger than it can be, so not taken out" };
                format!("added: turns its vector by {:.2} deg rms{remark}", found.size_rad.to_degrees())
            },
        );
        let cells = vec![effect.name().to_owned(), format!("{evidence:.1}"), format!("{p_value:.4}"), outcome];
        (added.is_some(), cells)
    });
    out += &table(&["candidate", "evidence", "chance", "outcome"], rows);
    out + "</details>\n"
}

/// Rate of false alarms of a diagnosis, which is shared out among the candidates (`docs/effects.md`).
const FALSE_ALARMS: f32 = 0.01;

/// A candidate that is one with what was added keeps what it showed before that.
fn why_refused(tried: &Tried, report: &DiagnosisReport) -> &'static str {
    let shows = tried.p_value * f32::from(report.candidates) <= FALSE_ALARMS;
    if tried.too_small {
        "refused: too small to matter"
    } else if tried.suspected {
        "suspected: it may be what is unexplained in the field"
    } else if tried.p_value >= 1.0 {
        "refused: could not be seen beside the model"
    } else if shows && report.count > 0 {
        "refused: showed before the last was added, not beside it"
    } else if shows {
        "refused: not worth its parameters"
    } else {
        "refused: shows no more than chance would"
    }
}
