//! Remarks about windows: one shorter than configured, or none at all.

use meerkat_mwd::{
    Config,
    diagnosis::Verdict,
    identification::{Decision, WindowReport},
};

use super::refusal_text::refusal_text;
use crate::diagnosis::Diagnosed;
use testbed::{flight::Flight, trace::Trace};

/// Shortfall from which a window is called short, seconds: its last sample comes one period before its end.
const TOLERANCE_S: f64 = 0.5;

/// Length of a window, seconds.
#[must_use]
pub fn length_s(report: &WindowReport) -> f64 {
    report.t_end_us.saturating_sub(report.t_start_us) as f64 * 1e-6
}

/// Start and end of a window, seconds.
#[must_use]
pub fn span(report: &WindowReport) -> String {
    format!("{:.1} to {:.1}", report.t_start_us as f64 * 1e-6, report.t_end_us as f64 * 1e-6)
}

/// A remark if the window is shorter than configured.
#[must_use]
pub fn window_note(report: &WindowReport, config: &Config) -> Option<String> {
    let (length, configured) = (length_s(report), f64::from(config.identification.window_s));
    (length < configured - TOLERANCE_S)
        .then(|| format!("{length:.1} s long, shorter than the configured {configured:.1} s"))
}

/// The reason if there is no window at all.
#[must_use]
pub fn why_no_window(trace: &Trace, config: &Config, flight: &Flight) -> Option<String> {
    if !flight.reports.is_empty() {
        return None;
    }
    let identification = &config.identification;
    let until_us = flight.frozen_at_us.map_or(u64::MAX, |freeze| freeze.saturating_sub(trace.first_us()));
    let available_s = trace.duration_us().min(until_us) as f64 * 1e-6;
    let latency_s = identification.latency_s;
    let (part, window_s, needed) = if flight.frozen_at_us.is_some() {
        // The last window is closed early enough for its result, however short that makes it.
        ("the part before the hold-out", 0.0, format!("the result of a window takes {latency_s:.1} s"))
    } else {
        let window_s = identification.window_s;
        ("the trace", window_s, format!("a window takes {window_s:.1} s and its result {latency_s:.1} s more"))
    };
    Some(if available_s < f64::from(window_s + latency_s) {
        format!("no window: {part} lasts {available_s:.1} s; {needed}")
    } else {
        format!("no window closed in {available_s:.1} s, with {} gaps in time", flight.counters.gaps)
    })
}

/// Text on what a diagnosis that can tell nothing lacks: motion, or readings.
#[must_use]
pub fn missing(trace: &Trace, config: &Config, flight: &Flight, diagnosed: &Diagnosed) -> Option<String> {
    if diagnosed.verdict != Verdict::NotEnoughExcitation {
        return None;
    }
    match flight.reports.last().map(|report| &report.decision) {
        Some(Decision::Refused(refusal)) => Some(refusal_text(refusal)),
        _ => why_no_window(trace, config, flight),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::Sample;

    use super::*;

    #[test]
    fn a_short_trace_and_a_short_training_part_are_told_apart() {
        let samples = [0, 30_000_000].map(|t_us| Sample { t_us, ..Sample::default() }).to_vec();
        let trace = Trace { samples, ..Trace::default() };
        let why = |frozen_at_us| {
            let flight = Flight { frozen_at_us, ..Flight::default() };
            why_no_window(&trace, &Config::default(), &flight).unwrap()
        };
        assert!(why(None).contains("the trace lasts 30.0 s; a window takes 50.0 s"));
        assert!(why(Some(500_000)).contains("before the hold-out lasts 0.5 s; the result of a window takes 1.0 s"));
    }
}
