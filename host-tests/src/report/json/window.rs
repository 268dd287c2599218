//! A window of the identification, for the JSON.

use meerkat_mwd::{
    Config,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};
use serde::Serialize;

use super::parameters::{Parameters, in_seconds};
use crate::report::{explanation, refusal_text::refusal_text, window_note::window_note};

#[derive(Debug, Serialize)]
pub(super) struct Window {
    t_start_s: f64,
    t_end_s: f64,
    t_effect_s: Option<f64>,
    accepted: bool,
    reason: Option<String>,
    optimizer: OptimizerKind,
    evaluations: u32,
    cost_before: Option<f32>,
    cost_after: Option<f32>,
    #[serde(flatten)]
    fitted: Parameters,
    rest_s: f32,
    motion_s: Option<f32>,
    directions_decided: Option<u8>,
    innovation_nis: Option<f32>,
    deg_per_turn: f32,
    widths: Option<Widths>,
    window_note: Option<String>,
    /// Explanation of the window, with `--explain`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) explanation: Option<explanation::Window>,
}

/// Error widths of the vector sensors that the data choose, times the data sheets'.
#[derive(Debug, Serialize)]
struct Widths {
    magnetometer_matrix: f32,
    magnetometer_misalignment: f32,
    hard_iron: f32,
    accelerometer: f32,
    accelerometer_bias: f32,
}

impl Widths {
    const fn new(report: &WindowReport) -> Self {
        let [magnetometer_matrix, hard_iron, accelerometer, magnetometer_misalignment, accelerometer_bias] =
            report.widths;
        Self { magnetometer_matrix, magnetometer_misalignment, hard_iron, accelerometer, accelerometer_bias }
    }
}

impl Window {
    pub(super) fn new(report: &WindowReport, config: &Config) -> Self {
        let (accepted, reason) = match &report.decision {
            Decision::Accepted => (true, None),
            Decision::Refused(refusal) => (false, Some(refusal_text(refusal))),
            other => (false, Some(format!("{other:?}"))),
        };
        // A window that overran has no result.
        let has_result = report.t_effect_us.is_some();
        Self {
            t_start_s: in_seconds(report.t_start_us),
            t_end_s: in_seconds(report.t_end_us),
            t_effect_s: report.t_effect_us.map(in_seconds),
            accepted,
            reason,
            optimizer: report.optimizer,
            evaluations: report.evaluations,
            cost_before: report.cost_before,
            cost_after: report.cost_after,
            fitted: Parameters::new(&report.fitted, report.sigma, report.observable, report.rank),
            rest_s: report.rest_s,
            motion_s: has_result.then_some(report.motion_s),
            directions_decided: has_result.then_some(report.directions_decided),
            // Without motion no innovation counts.
            innovation_nis: (has_result && report.motion_s > 0.0).then_some(report.innovation_nis),
            deg_per_turn: report.deg_per_turn,
            widths: has_result.then(|| Widths::new(report)),
            window_note: window_note(report, config),
            explanation: None,
        }
    }
}
