//! Reports of a probe that is fed by hand, each as the result of a whole flight would hold it.

use meerkat_mwd::{
    Config,
    compensation::Effect,
    diagnosis::{DiagnosisReport, EffectReport},
    identification::WindowReport,
};
use serde::Serialize;

use super::{EffectJson, RemainderJson, in_seconds, window::Window};
use crate::{diagnosis::aliases, report::account::verdict_name};

#[derive(Serialize)]
struct Diagnosis {
    t_start_s: f64,
    t_end_s: f64,
    t_effect_s: f64,
    verdict: &'static str,
    effects: Vec<EffectJson>,
    /// Mean squared innovation over its degrees of freedom without and with the effects.
    nis: [f32; 2],
    remainder: RemainderJson,
}

/// A window as `identification.windows` of the result has it.
///
/// # Errors
/// A value that JSON does not hold; there is none.
pub fn window_json(report: &WindowReport, config: &Config) -> serde_json::Result<String> {
    serde_json::to_string(&Window::new(report, config))
}

/// One diagnosis: verdict, effects as `diagnosis.effects` of the result has them but for the residual of each, which is
/// of a whole flight, and the remainder. An effect is active from when it was found, or from the bias's step, to the
/// diagnosis's end.
///
/// # Errors
/// A value that JSON does not hold; there is none.
pub fn diagnosis_json(report: &DiagnosisReport, library: &[&'static dyn Effect]) -> serde_json::Result<String> {
    let end_s = in_seconds(report.t_end_us);
    let effect = |found: &EffectReport| {
        let effect = *library.get(usize::from(found.found.index))?;
        let from_us = if found.step_us > 0 { found.step_us } else { found.found_us };
        Some(EffectJson::of_report(effect, found, aliases(effect, found, library), [in_seconds(from_us), end_s]))
    };
    serde_json::to_string(&Diagnosis {
        t_start_s: in_seconds(report.t_start_us),
        t_end_s: end_s,
        t_effect_s: in_seconds(report.t_effect_us),
        verdict: verdict_name(report.verdict),
        effects: report.found().filter_map(effect).collect(),
        nis: report.nis,
        remainder: RemainderJson::new(&report.remainder),
    })
}
