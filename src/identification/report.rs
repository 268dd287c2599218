//! Report of a window: its decision and reason, the fit with its uncertainty, and the figures behind both.

use crate::{
    compensation::{GyroModel, Theta},
    config::OptimizerKind,
    estimator::Refusal,
};

/// Result of one window.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WindowReport {
    /// Beginning of the window, microseconds.
    pub t_start_us: u64,
    /// Last sample of the window, microseconds.
    pub t_end_us: u64,
    /// First sample to which the result applies, microseconds; `None` without a result.
    pub t_effect_us: Option<u64>,
    /// Decision whether P and b of `fitted` fly, and why not.
    pub decision: Decision,
    /// Search method.
    pub optimizer: OptimizerKind,
    /// Cost evaluations spent by the search.
    pub evaluations: u32,
    /// Cost of the model flown so far, on this window: half its squared distance from the posterior's mean, in
    /// deviations, and what a heavier tail of each node's innovations changes. `None` for a window that was refused or
    /// has no rows to search.
    pub cost_before: Option<f32>,
    /// Cost of `fitted` on this window, as `cost_before`.
    pub cost_after: Option<f32>,
    /// Decrease of the cost of the estimator's mean by the search; `None` without a search.
    pub cost_gained_by_search: Option<f32>,
    /// Twelve parameters from the samples so far, accepted or not; the model flown where the samples say nothing.
    pub fitted: GyroModel,
    /// Bias-only alternative, as if P had never moved: the factory's P with its own bias.
    pub bias_only: GyroModel,
    /// Model that flies from `t_effect_us` on.
    pub flown: GyroModel,
    /// Deviations of `fitted`; the prior's where nothing was observed.
    pub sigma: Theta,
    /// Covariance of P's nine elements, row-major, lower triangle row by row: 45 numbers in three lots of 15, since
    /// no longer array can be serialised. [`WindowReport::covariance_of_p`] finds an element.
    pub p_covariance: [[f32; 15]; 3],
    /// Observed ones of the 12 parameters: their posterior deviation is below half the prior's.
    pub observable: [bool; 12],
    /// Number of independent directions of the 12 that are observed: of P's nine, and axes of the bias.
    pub rank: u8,
    /// Seconds of rest in this window.
    pub rest_s: f32,
    /// Seconds of motion since the start that `fitted` comes from.
    pub motion_s: f32,
    /// Directions of P's nine that the data decide.
    pub directions_decided: u8,
    /// Mean squared innovation over its degrees of freedom: 1 where the noise is as large as stated.
    pub innovation_nis: f32,
    /// Change of the flown model as error of a whole turn about an axis, degrees: rms of the three axes.
    pub deg_per_turn: f32,
    /// Widths that the data choose for the magnetometer's shape, the hard iron, the accelerometer's matrix,
    /// the magnetometer's misalignment and the accelerometer's bias, over the data sheets': a large one blames its
    /// sensor.
    pub widths: [f32; 5],
}

impl WindowReport {
    /// Covariance of two elements of P of `fitted`, counted row by row from 0 to 8; 0 beyond.
    #[must_use]
    pub fn covariance_of_p(&self, one: usize, other: usize) -> f32 {
        let (row, column) = if one > other { (one, other) } else { (other, one) };
        let place = if row < 9 { row * (row + 1) / 2 + column } else { usize::MAX };
        self.p_covariance.as_flattened().get(place).copied().unwrap_or(0.0)
    }
}

/// Decision about a window's P.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Decision {
    /// P and b fly.
    Accepted,
    /// P stays; only the bias may have moved.
    Refused(Refusal),
}
