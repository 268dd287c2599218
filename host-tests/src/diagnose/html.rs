//! The account as a page: one file that needs nothing else.

mod plots;
mod svg;
mod tables;

use std::path::Path;

use meerkat_mwd::{Config, diagnosis::Verdict};

use super::{Diagnosed, remainder_text, verdict_name};
use crate::{
    failure::Failure,
    score::Reference,
    trace::{Trace, seconds},
};

/// Writes the page.
///
/// # Errors
/// When the file cannot be written.
pub(super) fn write_page(
    path: &Path,
    trace: &Trace,
    config: &Config,
    diagnosed: &Diagnosed,
    reference: Option<&Reference>,
) -> Result<(), Failure> {
    std::fs::write(path, page(trace, config, diagnosed, reference)).map_err(|error| Failure::output(path, &error))
}

/// The page.
#[must_use]
pub fn page(trace: &Trace, config: &Config, diagnosed: &Diagnosed, reference: Option<&Reference>) -> String {
    let name = trace.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<title>Diagnosis of {}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        escape(&name),
        include_str!("html/style.css"),
    );
    out += "<h1>Which effect the model lacks</h1>\n";
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
    out += &tables::effects(diagnosed);
    out += &plots::estimates(diagnosed);
    out += "<h2>Magnets that came and went</h2>\n";
    out += &tables::magnets(diagnosed);
    out += "<h2>Diagnoses</h2>\n";
    out += "<p>Evidence: gain in log-likelihood. Chance: of as clear a show without the effect.</p>\n";
    let last = diagnosed.reports.len();
    for (number, (report, library)) in diagnosed.reports.iter().enumerate() {
        out += &tables::diagnosis(report, library, number + 1 == last);
    }
    out + "</body>\n</html>\n"
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

/// With a capital.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Text as it stands in a page.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            // No control character is allowed in a page, but for white space.
            c if c.is_control() && !c.is_whitespace() => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_means_something_in_a_page_is_escaped() {
        assert_eq!(escape("a<b> & \"c\"\u{1}'"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}&#39;");
        assert_eq!(sentence("what"), "What");
    }
}
