//! Tables of a diagnosis.

use meerkat_mwd::{
    compensation::Effect,
    diagnosis::{DiagnosisReport, Verdict},
};

use crate::{
    diagnosis::{BeforeAfter, Diagnosed, Found},
    report::{
        account::verdict_name,
        html::{escape::escape, figure, sentence, table},
        remainder_text::remainder_text,
    },
    score::{PerModel, Reference},
};

/// Table of the residuals before and after.
pub(super) fn residual(diagnosed: &Diagnosed) -> String {
    let residual = &diagnosed.residual;
    let row = |name: &str, x: &BeforeAfter| (false, vec![name.to_owned(), figure(x.before), figure(x.after)]);
    table(
        &["", "before", "after"],
        [
            row("gravity, deg rms", &residual.gravity_deg),
            row("field, deg rms", &residual.magnetic_deg),
            row("innovations, mean square in units of their variance (last diagnosis)", &residual.nis),
        ],
    )
}

/// Tables of the scores against the reference.
pub(crate) fn reference(reference: &Reference) -> String {
    let rows = [
        ("as it is", &reference.orientation_2s_rms_deg),
        ("one delay taken out", &reference.orientation_2s_rms_time_aligned_deg),
    ];
    format!("<h3>Against the reference</h3>\n{}", per_model("rotation over 2 s, deg rms", &rows))
}

/// Table of a score for each way to read the gyro.
pub(crate) fn per_model(what: &str, rows: &[(&str, &PerModel)]) -> String {
    let rows = rows.iter().map(|(name, scores)| {
        let scores = [scores.uncompensated, scores.bias_only, scores.twelve_parameters, scores.with_effects];
        (false, [(*name).to_owned()].into_iter().chain(scores.map(figure)).collect())
    });
    table(&[what, "uncompensated", "bias only", "12 parameters", "with effects"], rows)
}

/// Table of the effects found.
pub(crate) fn effects(diagnosed: &Diagnosed) -> String {
    if diagnosed.effects.is_empty() {
        return "<p>None.</p>\n".to_owned();
    }
    let row = |found: &Found| {
        let in_seconds = |t_us: u64| format!("{:.1}", t_us as f64 * 1e-6);
        let taken_out = if found.report.is_taken_out() {
            in_seconds(found.report.taken_out_us)
        } else {
            "not: larger than it can be".to_owned()
        };
        let [from_s, _] = found.active_s;
        let cells = vec![
            found.effect.name().to_owned(),
            parameters(found),
            format!("{:.0}", found.report.evidence),
            format!("{} to {}", figure(found.residual_deg.before), figure(found.residual_deg.after)),
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

fn parameters(found: &Found) -> String {
    let both = found.report.found.parameters.iter().zip(&found.report.found.sigma);
    let texts = found.effect.parameters().iter().zip(both).map(|(parameter, (x, sigma))| {
        format!("{} {:.3} ± {:.3}", parameter.name, x * parameter.in_unit, sigma * parameter.in_unit)
    });
    texts.collect::<Vec<_>>().join("; ")
}

/// Table of the magnets that came and went.
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

/// One diagnosis with all its candidates, `open` or folded.
pub(super) fn diagnosis(report: &DiagnosisReport, library: &[&dyn Effect], is_open: bool) -> String {
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
            let remark = if found.is_taken_out() { "" } else { "; larger than it can be, so not taken out" };
            format!("found: turns its vector by {:.2} deg rms{remark}", found.size_rad.to_degrees())
        });
        let evidence = found.map_or(*tried, |found| found.evidence);
        (found.is_some(), vec![effect.name().to_owned(), format!("{evidence:.1}"), outcome])
    });
    out += &table(&["candidate", "log Bayes factor beside what was found", "outcome"], rows);
    out + "</details>\n"
}
