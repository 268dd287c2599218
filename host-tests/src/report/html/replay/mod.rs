//! A flight as a page: summary, plots, tables.

mod plots;
mod tables;

use meerkat_mwd::{Config, SampleFlags, identification::Decision};

use crate::{
    diagnosis::Diagnosed,
    flight::Flight,
    report::{
        account::verdict_name,
        html::{
            diagnosis::{effect_estimates, effects, magnets, reference as reference_scores},
            document,
            escape::escape,
            sentence,
        },
        json::parameters::Parameters,
        motion,
        refusal_text::refusal_text,
        window_note::why_no_window,
    },
    score::Reference,
    trace::{Trace, seconds},
};

/// The whole page.
#[must_use]
pub fn page(
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    diagnosed: &Diagnosed,
    reference: Option<&Reference>,
    place: &str,
) -> String {
    let name = trace.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut out = "<h1>Attitude, and the gyro's errors</h1>\n".to_owned();
    let about = format!(
        "{}: {} samples, {:.2} s, flown {place}",
        trace.path.display(),
        trace.samples.len(),
        trace.duration_s()
    );
    out += &format!("<p class=\"trace\">{}</p>\n", escape(&about));
    out += &format!("<p>{}</p>\n", escape(&motion::line(trace, config)));
    if let Some(freeze_us) = config.freeze_at_us {
        let from = seconds(freeze_us);
        out += &format!("<p>Parameters and effects are frozen from {from} s; scores are over what follows.</p>\n");
    }
    out += &verdict(trace, config, flight);
    out += "<h2>Attitude</h2>\n";
    out += &plots::attitude(trace, config, flight, diagnosed);
    if let Some(reference) = reference {
        out += &reference_scores(reference);
        out += &tables::scores(reference);
    }
    out += "<h2>Windows</h2>\n<p>Each identifies the gyro's errors: rate = P (raw rate - b). Points: fits, accepted or not, with their deviations.</p>\n";
    out += &plots::fits(flight);
    out += &tables::windows(config, flight);
    out += "<h2>What flies at the end</h2>\n";
    out += &tables::parameters(&Parameters::at_the_end(config, flight));
    if config.effects {
        out += &format!("<h2>Effects</h2>\n<p>{}.</p>\n", sentence(&verdict_name(diagnosed.verdict).replace('_', " ")));
        out += &effects(diagnosed);
        out += &effect_estimates(diagnosed);
        out += "<h2>Magnets that came and went</h2>\n";
        out += &magnets(diagnosed);
    }
    out += "<h2>Readings</h2>\n";
    out += &tables::counts(&counts(trace, flight));
    document(&format!("Flight of {name}"), &out)
}

fn verdict(trace: &Trace, config: &Config, flight: &Flight) -> String {
    let accepted = flight.reports.iter().filter(|report| report.decision == Decision::Accepted).count();
    let (class, what, why) = match flight.reports.last().map(|report| &report.decision) {
        None => ("not_enough_excitation", "no window", why_no_window(trace, config, flight).unwrap_or_default()),
        Some(_) if accepted > 0 => {
            let count = flight.reports.len();
            ("accepted", "P accepted", format!("in {accepted} of {count} windows"))
        }
        Some(Decision::Refused(refusal)) => ("not_enough_excitation", "P refused", refusal_text(refusal)),
        Some(other) => ("not_enough_excitation", "P refused", format!("{other:?}")),
    };
    format!("<div class=\"verdict {class}\">\n<p><b>{what}</b></p>\n<p>{}.</p>\n</div>\n", escape(&sentence(&why)))
}

/// Counters of the flight, by name.
fn counts(trace: &Trace, flight: &Flight) -> Vec<(&'static str, u64)> {
    let counters = &flight.counters;
    let lacking = |flag| trace.count(flag) as u64;
    vec![
        ("samples", counters.samples),
        ("without the gyro", lacking(SampleFlags::GYRO_MISSING)),
        ("without the accelerometer", lacking(SampleFlags::ACCEL_MISSING)),
        ("without the magnetometer", lacking(SampleFlags::MAG_MISSING)),
        ("without temperature", lacking(SampleFlags::TEMPERATURE_MISSING)),
        ("with a clipped sensor", counters.clipped.into()),
        ("out of order, refused", counters.out_of_order.into()),
        ("gaps in time", counters.gaps.into()),
        ("windows that were not ready in time", counters.overruns.into()),
    ]
}
