use crate::{compensation::GyroModel, config::OptimizerKind, estimator::Refusal};

/// What came of one window.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WindowReport {
    /// Beginning of the window, microseconds.
    pub t_start_us: u64,
    /// Last sample of the window, microseconds.
    pub t_end_us: u64,
    /// First sample to which the result applies, microseconds; `None` where nothing was there to apply.
    pub t_effect_us: Option<u64>,
    /// Whether P and b of `fitted` fly, or why not.
    pub decision: Decision,
    /// What searched.
    pub optimizer: OptimizerKind,
    /// Cost evaluations spent by the search.
    pub evaluations: u32,
    /// Cost of the model flown so far, on this window: half the robust sum of its squared innovations, in units of their noise, and of the
    /// prior; `None` when there was nothing to evaluate.
    pub cost_before: Option<f32>,
    /// Cost of `fitted` on this window; `None` when there was nothing to evaluate.
    pub cost_after: Option<f32>,
    /// By how much the search lowered the cost of the estimator's mean; `None`: nothing searched.
    pub cost_gained_by_search: Option<f32>,
    /// What the samples so far say of the twelve parameters, accepted or not; the model flown where they say nothing.
    pub fitted: GyroModel,
    /// The bias-only alternative, what would fly had P never moved: the factory's P with its own bias.
    pub bias_only: GyroModel,
    /// What flies from `t_effect_us` on.
    pub flown: GyroModel,
    /// 1-sigma of P (row-major, 9) then b (rad/s, 3) of `fitted`; the prior's where nothing was observed.
    pub sigma: [f32; 12],
    /// Covariance of P's nine elements, row-major, its lower triangle row by row: 45 numbers in three lots of 15, since no longer array can
    /// be serialised. [`WindowReport::covariance_of_p`] finds an element.
    pub p_covariance: [[f32; 15]; 3],
    /// Which of the 12 parameters are observed (posterior below half the prior).
    pub observable: [bool; 12],
    /// How many independent directions of the 12 are observed: of P's nine, and axes of the bias.
    pub rank: u8,
    /// Seconds of rest in this window.
    pub rest_s: f32,
    /// Seconds of motion since the start that `fitted` comes from.
    pub motion_s: f32,
    /// Directions of P's nine that the data decide.
    pub directions_decided: u8,
    /// Mean squared innovation over its degrees of freedom: 1 where the noise is what it is thought to be.
    pub innovation_nis: f32,
    /// By how much a whole turn about an axis is another one with `flown` than with what flew before, degrees: rms of the three axes.
    pub deg_per_turn: f32,
    /// Widths that the data choose for the magnetometer's matrix, the hard iron and the accelerometer, over the data sheet's: they say which
    /// sensor is bad.
    pub widths: [f32; 3],
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

/// Accepted, or refused and why.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Decision {
    /// P and b fly.
    Accepted,
    /// P stays as it was; only the bias may have moved.
    Refused(Refusal),
}
