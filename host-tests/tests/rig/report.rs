//! Reports of windows.

use meerkat_mwd::{
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};

/// A report with neutral figures; a test sets those it is about.
pub fn report(decision: Decision) -> WindowReport {
    WindowReport {
        t_start_us: 0,
        t_end_us: 0,
        t_effect_us: None,
        decision,
        optimizer: OptimizerKind::Imoa,
        evaluations: 0,
        cost_before: None,
        cost_after: None,
        cost_gained_by_search: None,
        fitted: GyroModel::IDENTITY,
        bias_only: GyroModel::IDENTITY,
        flown: GyroModel::IDENTITY,
        sigma: [0.0; 12],
        p_covariance: [[0.0; 15]; 3],
        observable: [false; 12],
        rank: 0,
        rest_s: 0.0,
        motion_s: 0.0,
        directions_decided: 0,
        innovation_nis: 1.0,
        deg_per_turn: 0.0,
        widths: [1.0; 5],
    }
}
