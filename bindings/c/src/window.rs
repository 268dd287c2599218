//! Report of a window: its decision, the fit with its uncertainty, and the figures behind both.

use crate::choices::{search, search_number};
use meerkat_mwd::{
    compensation::GyroModel,
    config::OptimizerKind,
    estimator::Refusal,
    identification::{Decision, WindowReport},
    sample::TurnFlags,
};

/// P and b fly.
pub const MWD_ACCEPTED: u32 = 0;
/// Refused: too little motion. Numbers: motion, and motion needed, seconds.
pub const MWD_REFUSED_NOT_ENOUGH_MOTION: u32 = 1;
/// Refused: the result was not ready at its instant.
pub const MWD_REFUSED_OVERRUN: u32 = 2;
/// Refused: the accelerometer reads nothing usable.
pub const MWD_REFUSED_NO_ACCELEROMETER: u32 = 3;
/// Refused: the gyro cannot be used. Number: share of the time.
pub const MWD_REFUSED_GYRO_UNUSABLE: u32 = 4;
/// Refused: the innovations are larger than the estimator thinks. Number: mean squared innovation.
pub const MWD_REFUSED_DIVERGED: u32 = 5;
/// Refused: too little of the motion has a field. Number: share of the motion without one.
pub const MWD_REFUSED_NO_MAGNETOMETER: u32 = 6;
/// Refused: P is farther from the factory's than any data sheet allows. Number: deviations of the prior.
pub const MWD_REFUSED_IMPLAUSIBLE: u32 = 7;
/// Refused: the magnetometer needs a calibration first. Number: hard iron, of the field's norm.
pub const MWD_REFUSED_MAGNETOMETER_UNCALIBRATED: u32 = 8;
/// Refused for a reason that a newer library has.
pub const MWD_REFUSED_OTHERWISE: u32 = 9;
/// Refused: the sensors do not agree on turns. Number: the turns, as bits: about x, y and z by gravity, then by the
/// field.
pub const MWD_REFUSED_WRONG_MOUNTING: u32 = 10;

/// Gyro model: `w = P (w_raw - b)`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdGyroModel {
    /// Matrix P, row by row.
    pub p: [f32; 9],
    /// Bias b, rad/s.
    pub b_rad_s: [f32; 3],
}

/// Result of one window.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdWindow {
    /// Beginning of the window, microseconds.
    pub t_start_us: u64,
    /// Last sample of the window, microseconds.
    pub t_end_us: u64,
    /// First sample to which the result applies, microseconds; `UINT64_MAX` without a result.
    pub t_effect_us: u64,
    /// `MWD_ACCEPTED`, or `MWD_REFUSED_...`: P stays, and only the bias may have moved.
    pub decision: u32,
    /// Numbers of the refusal, as its macro says; 0 without.
    pub refusal: [f32; 2],
    /// `MWD_SEARCH_...`.
    pub search: u32,
    /// Cost evaluations spent by the search.
    pub evaluations: u32,
    /// Cost of the model flown so far, on this window; NaN without anything to evaluate.
    pub cost_before: f32,
    /// Cost of `fitted` on this window; NaN without anything to evaluate.
    pub cost_after: f32,
    /// Decrease of the cost of the estimator's mean by the search; NaN without a search.
    pub cost_gained_by_search: f32,
    /// Twelve parameters from the samples so far, accepted or not.
    pub fitted: MwdGyroModel,
    /// Bias alone, with the factory's P.
    pub bias_only: MwdGyroModel,
    /// Model that flies from `t_effect_us` on.
    pub flown: MwdGyroModel,
    /// 1-sigma of P, row by row, then of b in rad/s.
    pub sigma: [f32; 12],
    /// Covariance of P's nine elements: lower triangle, row by row.
    pub p_covariance: [f32; 45],
    /// 1 for each of the twelve parameters that was observed.
    pub observable: [u8; 12],
    /// Number of independent directions of the twelve that are observed.
    pub rank: u8,
    /// Directions of P's nine that the data decide.
    pub directions_decided: u8,
    /// Seconds of rest in this window.
    pub rest_s: f32,
    /// Seconds of motion since the start that `fitted` comes from.
    pub motion_s: f32,
    /// Mean squared innovation over its degrees of freedom.
    pub innovation_nis: f32,
    /// Change of the flown model as error of a whole turn about an axis, degrees.
    pub deg_per_turn: f32,
    /// Widths of the magnetometer's shape, the hard iron, the accelerometer's matrix, the magnetometer's misalignment
    /// and the accelerometer's bias, over the data sheets'.
    pub widths: [f32; 5],
}

impl From<&GyroModel> for MwdGyroModel {
    fn from(model: &GyroModel) -> Self {
        let [[a, b, c], [d, e, f], [g, h, i]] = model.p;
        Self { p: [a, b, c, d, e, f, g, h, i], b_rad_s: model.b_rad_s }
    }
}

impl MwdGyroModel {
    fn to_model(self) -> GyroModel {
        let [a, b, c, d, e, f, g, h, i] = self.p;
        GyroModel { p: [[a, b, c], [d, e, f], [g, h, i]], b_rad_s: self.b_rad_s }
    }
}

fn decision_numbers(decision: &Decision) -> (u32, [f32; 2]) {
    let Decision::Refused(refusal) = decision else { return (MWD_ACCEPTED, [0.0; 2]) };
    match *refusal {
        Refusal::NotEnoughMotion { motion_s, needed_s } => (MWD_REFUSED_NOT_ENOUGH_MOTION, [motion_s, needed_s]),
        Refusal::Overrun => (MWD_REFUSED_OVERRUN, [0.0; 2]),
        Refusal::NoAccelerometer => (MWD_REFUSED_NO_ACCELEROMETER, [0.0; 2]),
        Refusal::GyroUnusable { share } => (MWD_REFUSED_GYRO_UNUSABLE, [share, 0.0]),
        Refusal::Diverged { nis } => (MWD_REFUSED_DIVERGED, [nis, 0.0]),
        Refusal::NoMagnetometer { share } => (MWD_REFUSED_NO_MAGNETOMETER, [share, 0.0]),
        Refusal::Implausible { sigmas } => (MWD_REFUSED_IMPLAUSIBLE, [sigmas, 0.0]),
        Refusal::MagnetometerUncalibrated { hard_iron_share } => {
            (MWD_REFUSED_MAGNETOMETER_UNCALIBRATED, [hard_iron_share, 0.0])
        }
        Refusal::WrongMounting { turns } => (MWD_REFUSED_WRONG_MOUNTING, [f32::from(turns.bits()), 0.0]),
        _ => (MWD_REFUSED_OTHERWISE, [0.0; 2]),
    }
}

fn decision(number: u32, [first, second]: [f32; 2]) -> Option<Decision> {
    Some(Decision::Refused(match number {
        MWD_ACCEPTED => return Some(Decision::Accepted),
        MWD_REFUSED_NOT_ENOUGH_MOTION => Refusal::NotEnoughMotion { motion_s: first, needed_s: second },
        MWD_REFUSED_OVERRUN => Refusal::Overrun,
        MWD_REFUSED_NO_ACCELEROMETER => Refusal::NoAccelerometer,
        MWD_REFUSED_GYRO_UNUSABLE => Refusal::GyroUnusable { share: first },
        MWD_REFUSED_DIVERGED => Refusal::Diverged { nis: first },
        MWD_REFUSED_NO_MAGNETOMETER => Refusal::NoMagnetometer { share: first },
        MWD_REFUSED_IMPLAUSIBLE => Refusal::Implausible { sigmas: first },
        MWD_REFUSED_MAGNETOMETER_UNCALIBRATED => Refusal::MagnetometerUncalibrated { hard_iron_share: first },
        MWD_REFUSED_WRONG_MOUNTING => Refusal::WrongMounting { turns: TurnFlags::from_bits_truncate(first as u16) },
        _ => return None,
    }))
}

impl From<&WindowReport> for MwdWindow {
    fn from(report: &WindowReport) -> Self {
        let (decision, refusal) = decision_numbers(&report.decision);
        let mut p_covariance = [0.0; 45];
        for (place, value) in p_covariance.iter_mut().zip(report.p_covariance.as_flattened()) {
            *place = *value;
        }
        Self {
            t_start_us: report.t_start_us,
            t_end_us: report.t_end_us,
            t_effect_us: report.t_effect_us.unwrap_or(u64::MAX),
            decision,
            refusal,
            search: search_number(report.optimizer),
            evaluations: report.evaluations,
            cost_before: report.cost_before.unwrap_or(f32::NAN),
            cost_after: report.cost_after.unwrap_or(f32::NAN),
            cost_gained_by_search: report.cost_gained_by_search.unwrap_or(f32::NAN),
            fitted: (&report.fitted).into(),
            bias_only: (&report.bias_only).into(),
            flown: (&report.flown).into(),
            sigma: report.sigma,
            p_covariance,
            observable: report.observable.map(u8::from),
            rank: report.rank,
            directions_decided: report.directions_decided,
            rest_s: report.rest_s,
            motion_s: report.motion_s,
            innovation_nis: report.innovation_nis,
            deg_per_turn: report.deg_per_turn,
            widths: report.widths,
        }
    }
}

impl MwdWindow {
    /// Makes the library's report; `None` for a number that stands for nothing.
    pub(crate) fn to_report(self) -> Option<WindowReport> {
        let known = |x: f32| (!x.is_nan()).then_some(x);
        let mut p_covariance = [[0.0; 15]; 3];
        for (place, value) in p_covariance.as_flattened_mut().iter_mut().zip(self.p_covariance) {
            *place = value;
        }
        let optimizer: OptimizerKind = search(self.search, "search").ok()?;
        Some(WindowReport {
            t_start_us: self.t_start_us,
            t_end_us: self.t_end_us,
            t_effect_us: (self.t_effect_us != u64::MAX).then_some(self.t_effect_us),
            decision: decision(self.decision, self.refusal)?,
            optimizer,
            evaluations: self.evaluations,
            cost_before: known(self.cost_before),
            cost_after: known(self.cost_after),
            cost_gained_by_search: known(self.cost_gained_by_search),
            fitted: self.fitted.to_model(),
            bias_only: self.bias_only.to_model(),
            flown: self.flown.to_model(),
            sigma: self.sigma,
            p_covariance,
            observable: self.observable.map(|observed| observed != 0),
            rank: self.rank,
            directions_decided: self.directions_decided,
            rest_s: self.rest_s,
            motion_s: self.motion_s,
            innovation_nis: self.innovation_nis,
            deg_per_turn: self.deg_per_turn,
            widths: self.widths,
        })
    }
}
