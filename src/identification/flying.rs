//! Decision about what flies after an update: the estimator's mean where it is fit to fly, else the P that flew, with
//! a bias that a rest has given since. Whether a posterior is fit is decided in `estimator/posterior.rs`; when it
//! flies, in `schedule.rs`.

use super::{Decision, Refusal, WindowReport, schedule::Update};
use crate::{
    compensation::{GyroModel, Theta},
    config::{Config, IdentificationConfig},
    estimator::Posterior,
    sample::TurnFlags,
};
use nalgebra::Vector3;

/// Facts beside the posterior from which an update is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight<'a> {
    pub config: &'a Config,
    /// Model flown so far.
    pub flown: &'a GyroModel,
    pub bias_only: &'a GyroModel,
    /// Part of the latest rest's raw rate that the effects which fly take out, rad/s.
    pub of_effects_at_rest_rad_s: Vector3<f32>,
    /// True if there was a rest after the samples that the flown bias comes from.
    pub rest_is_news: bool,
    pub rest_s: f32,
    /// Turns about which the sensors do not agree.
    pub mounting_wrong: TurnFlags,
}

impl Flight<'_> {
    /// Judges an update before any search.
    #[inline(never)]
    pub fn judged(&self, update: &Update, posterior: &Posterior) -> WindowReport {
        let (decision, flown) = self.decide(posterior);
        let mut p_covariance = [[0.0; 15]; 3];
        p_covariance.as_flattened_mut().iter_mut().zip(posterior.p_covariance).for_each(|(to, from)| *to = from);
        let of_bias = posterior.observable.iter().skip(9).filter(|observable| **observable).count();
        WindowReport {
            decision,
            fitted: posterior.gyro,
            bias_only: posterior.bias_only,
            flown,
            sigma: posterior.sigma,
            p_covariance,
            observable: posterior.observable,
            rank: posterior.decided.saturating_add(of_bias as u8),
            motion_s: posterior.motion_s,
            directions_decided: posterior.decided,
            innovation_nis: posterior.nis,
            deg_per_turn: deg_per_turn(self.flown, &flown),
            widths: posterior.widths,
            ..self.without_result(update, Refusal::Overrun)
        }
    }

    /// Fitness of a posterior to fly.
    pub const fn fitness(&self, posterior: &Posterior) -> Result<(), Refusal> {
        if self.mounting_wrong.is_empty() {
            return posterior.fitness;
        }
        Err(Refusal::WrongMounting { turns: self.mounting_wrong })
    }

    fn decide(&self, posterior: &Posterior) -> (Decision, GyroModel) {
        let refusal = match self.fitness(posterior) {
            Ok(()) if posterior.gyro.is_valid() => return (Decision::Accepted, posterior.gyro),
            Ok(()) => Refusal::Diverged { nis: posterior.nis },
            Err(refusal) => refusal,
        };
        let told = if self.rest_is_news { self.with_bias_of(posterior) } else { *self.flown };
        (Decision::Refused(refusal), told)
    }

    /// The flown model with the bias that a rest shows beside the effects that fly. The posterior's bias is beside the
    /// effects that the estimator takes out, which may be others while the posterior is refused.
    fn with_bias_of(&self, posterior: &Posterior) -> GyroModel {
        let others = posterior.of_effects_at_rest_rad_s - self.of_effects_at_rest_rad_s;
        let b_rad_s: [f32; 3] = (Vector3::from(posterior.bias_only.b_rad_s) + others).into();
        let is_told = b_rad_s.iter().all(|b| b.is_finite());
        GyroModel { b_rad_s: if is_told { b_rad_s } else { self.flown.b_rad_s }, ..*self.flown }
    }

    /// Reports an update without a result: the flown model stays.
    #[inline(never)]
    pub fn without_result(&self, update: &Update, refusal: Refusal) -> WindowReport {
        let id = &self.config.identification;
        let sigma = prior_sigma(id);
        let mut p_covariance = [[0.0; 15]; 3];
        for (i, sigma) in sigma.iter().enumerate().take(9) {
            if let Some(variance) = p_covariance.as_flattened_mut().get_mut(i * (i + 3) / 2) {
                *variance = sigma * sigma;
            }
        }
        WindowReport {
            t_start_us: update.window_start_us,
            t_end_us: update.t_us,
            t_effect_us: None,
            decision: Decision::Refused(refusal),
            optimizer: id.optimizer,
            evaluations: 0,
            cost_before: None,
            cost_after: None,
            cost_gained_by_search: None,
            fitted: *self.flown,
            bias_only: *self.bias_only,
            flown: *self.flown,
            sigma,
            p_covariance,
            observable: [false; 12],
            rank: 0,
            rest_s: self.rest_s,
            motion_s: 0.0,
            directions_decided: 0,
            innovation_nis: 0.0,
            deg_per_turn: 0.0,
            widths: [1.0; 5],
        }
    }
}

/// Prior standard deviations.
fn prior_sigma(config: &IdentificationConfig) -> Theta {
    core::array::from_fn(|i| match i {
        0 | 4 | 8 => config.prior_sigma_diagonal,
        0..9 => config.prior_sigma_off_diagonal,
        _ => config.prior_sigma_bias_rad_s,
    })
}

/// Change of P as error of a whole turn about an axis, degrees: rms of the three axes.
pub(super) fn deg_per_turn(before: &GyroModel, after: &GyroModel) -> f32 {
    let Some(inverse) = before.p_matrix().try_inverse() else { return 0.0 };
    // A rate w becomes P' P^-1 w.
    let change = (after.p_matrix() - before.p_matrix()) * inverse;
    360.0 * libm::sqrtf(change.norm_squared() / 3.0)
}

#[cfg(test)]
mod tests;
