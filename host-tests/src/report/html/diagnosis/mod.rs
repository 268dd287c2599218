//! The account of a diagnosis as a page.

mod plots;
mod tables;

pub(crate) use plots::{effect_estimates, magnets_shaded_s};
pub(crate) use tables::{effects, magnets, per_model, reference};

use meerkat_mwd::{Config, diagnosis::Verdict};

use crate::{
    diagnosis::Diagnosed,
    report::{
        account::verdict_name,
        html::{document, escape::escape, sentence},
        remainder_text::remainder_text,
    },
    score::Reference,
    trace::{Trace, seconds},
};

/// The whole page.
#[must_use]
pub fn page(trace: &Trace, config: &Config, diagnosed: &Diagnosed, reference: Option<&Reference>) -> String {
    let name = trace.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut out = "<h1>Which effect the model lacks</h1>\n".to_owned();
    let about = format!("{}: {} samples, {:.2} s", trace.path.display(), trace.samples.len(), trace.duration_s());
    out += &format!("<p class=\"trace\">{}</p>\n", escape(&about));
    if let Some(freeze_us) = config.freeze_at_us {
        out += &format!(
            "<p>Parameters and effects are frozen from {} s; residuals and scores are over what follows.</p>\n",
            seconds(freeze_us)
        );
    }
    out += &verdict(diagnosed);
    out += "<h2>Residual</h2>\n";
    out += "<p>Gravity and field, predicted by the gyro from a second before, minus measured: angle, with the bias alone and with all that flew.</p>\n";
    out += &tables::residual(diagnosed);
    out += &plots::residual(diagnosed);
    if let Some(reference) = reference {
        out += &tables::reference(reference);
    }
    out += "<h2>Effects</h2>\n";
    out += &effects(diagnosed);
    out += &effect_estimates(diagnosed);
    out += "<h2>Magnets that came and went</h2>\n";
    out += &magnets(diagnosed);
    out += "<h2>Diagnoses</h2>\n";
    out += "<p>Evidence: gain in log-likelihood. Chance: of as clear a show without the effect.</p>\n";
    let last = diagnosed.reports.len();
    for (number, (report, library)) in diagnosed.reports.iter().enumerate() {
        out += &tables::diagnosis(report, library, number + 1 == last);
    }
    document(&format!("Diagnosis of {name}"), &out)
}

fn verdict(diagnosed: &Diagnosed) -> String {
    let name = verdict_name(diagnosed.verdict);
    let meaning = match diagnosed.verdict {
        Verdict::ModelSufficient => "No effect shows, and what is left is noise.",
        Verdict::EffectsFound => "Effects were found, and what is left is small.",
        Verdict::NotEnoughExcitation => "The tool moved too little, or too little could be read, to tell.",
        _ => "More is left than noise and than matters little. No effect is forced on it.",
    };
    let mut out =
        format!("<div class=\"verdict {name}\">\n<p><b>{}</b></p>\n<p>{meaning}</p>\n", name.replace('_', " "));
    if let Some(remainder) = diagnosed.remainder() {
        out += &format!("<p>{}.</p>\n", escape(&sentence(&remainder_text(remainder))));
    }
    out + "</div>\n"
}
