#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Twelve parameters, counted by loops.

use super::{
    Decision, Prior, Refusal, WindowReport,
    acceptance::{self, Evidence},
    contest::MIN_GROUPS,
    least_squares::{self, Freedom},
    observability::Observability,
    prior::{model_of, prior_sigma, theta_of},
    window_fit::{Context, Job, WindowFit},
};
use crate::{
    algebra::{Cholesky, Packed, dot},
    compensation::GyroModel,
    objective::turn,
    optimizer::{Cost, LeastSquaresCost},
};

/// Share of test windows without a rate from which a lack of excitation is the gyro's fault.
const SPOILT_SHARE: f32 = 0.5;

/// How far a parameter may lie from the factory's, in prior deviations.
const PLAUSIBLE_SIGMAS: f32 = 5.0;

/// A report of a window without a fit: only the bias may have moved, when there was a rest.
pub(crate) fn unidentified(context: &Context, job: &Job, refusal: Refusal) -> WindowReport {
    let (flown, bias_only) = with_rest_bias(context, job);
    WindowReport {
        t_start_us: job.t_start_us,
        t_end_us: job.t_end_us,
        t_effect_us: None,
        decision: Decision::Refused(refusal),
        optimizer: context.config.optimizer,
        evaluations: 0,
        cost_before: None,
        cost_after: None,
        fitted: flown,
        bias_only,
        flown,
        sigma: prior_sigma(context.config),
        observable: [false; 12],
        rank: 0,
        rest_s: job.rest_s,
        explained: None,
        p_value: None,
    }
}

/// The flown and the factory's P, both with the bias from rest where there is one.
fn with_rest_bias(context: &Context, job: &Job) -> (GyroModel, GyroModel) {
    let b_rad_s = job.rest.map_or(context.flown.b_rad_s, |rest| rest.rate.into());
    (GyroModel { b_rad_s, ..*context.flown }, GyroModel { b_rad_s, ..*context.factory })
}

/// Whether every parameter lies near enough to the factory's.
fn is_plausible(context: &Context, model: &GyroModel) -> bool {
    let (theta, factory, sigma) = (theta_of(model), theta_of(context.factory), prior_sigma(context.config));
    (0..12).all(|i| libm::fabsf(theta[i] - factory[i]) <= PLAUSIBLE_SIGMAS * sigma[i])
}

impl WindowFit {
    /// The report of a fit that could not be carried through.
    pub(super) fn without_fit(&self, context: &Context) -> WindowReport {
        let refusal = match self.fit_to_judge(context) {
            Ok(()) if self.total.is_empty() => self.too_little(0),
            Ok(()) => Refusal::Degenerate,
            Err(refusal) => refusal,
        };
        unidentified(context, &self.job, refusal)
    }

    /// The report of a fit, with its uncertainty and the gate's decision.
    pub(super) fn judged(&self, context: &Context) -> WindowReport {
        self.judge(context).unwrap_or_else(|refusal| unidentified(context, &self.job, refusal))
    }

    fn fit_to_judge(&self, context: &Context) -> Result<(), Refusal> {
        let (field_rows, gravity_rows) = (self.total.magnetic.rows, self.total.gravity.rows);
        let rest_norm_error = self.job.rest_norm_error_m_s2;
        acceptance::sensors_fit_to_judge(field_rows, gravity_rows, rest_norm_error, context.accelerometer_on_record)
            .map_err(|refusal| match refusal {
                Refusal::NotEnoughExcitation { rank } => self.too_little(rank),
                other => other,
            })
    }

    /// Why there is too little to identify from: the tool did not turn, or the gyro did not see it.
    fn too_little(&self, rank: u8) -> Refusal {
        let share = self.total.spoilt_share();
        if share > SPOILT_SHARE { Refusal::GyroUnusable { share } } else { Refusal::NotEnoughExcitation { rank } }
    }

    fn judge(&self, context: &Context) -> Result<WindowReport, Refusal> {
        let objective = self.objective();
        let (delta, evaluations) = self.optimum();
        let theta: [f32; 12] = core::array::from_fn(|i| self.theta0[i] + delta[i]);
        let fitted = model_of(&theta).ok_or(Refusal::Degenerate)?;
        let flown_theta = theta_of(context.flown);
        let cost_before = objective.evaluate(&core::array::from_fn(|i| flown_theta[i] - self.theta0[i]));
        let cost_after = objective.evaluate(&delta);

        let mut information = Packed::zero();
        objective.normal_equations(&delta, &mut information, &mut [0.0; 12]);
        let posterior = information.cholesky().ok_or(Refusal::Degenerate)?;
        // Against the data sheet: a rest counts as an observation of the bias.
        let data_sheet = Prior::new(context.config, context.factory, None);
        let observability = Observability::new(&data_sheet.information, &information).ok_or(Refusal::Degenerate)?;
        let jackknife = self.contest.covariance();

        let (base, mut bias_only) = with_rest_bias(context, &self.job);
        let base_theta = theta_of(&base);
        let change = observability.observed_part(&core::array::from_fn(|i| theta[i] - base_theta[i]));
        let candidate = model_of(&core::array::from_fn(|i| base_theta[i] + change[i]));

        let outcome = self.contest.first_against_second();
        let verdict = self.fit_to_judge(context).and_then(|()| {
            let (change_rad, change_sigma_rad) = self
                .promised(&change, &jackknife)
                .filter(|_| self.contest.groups() >= MIN_GROUPS)
                .ok_or_else(|| self.too_little(observability.rank))?;
            acceptance::judge(&Evidence { outcome, change_rad, change_sigma_rad })
        });
        let mut flown = base;
        let decision = match (verdict, candidate) {
            (Ok(()), Some(candidate)) if cost_after < cost_before && is_plausible(context, &candidate) => {
                flown = candidate;
                Decision::Accepted
            }
            (Ok(()), _) => Decision::Refused(Refusal::Degenerate),
            (Err(refusal), _) => Decision::Refused(refusal),
        };
        if self.job.rest.is_none() {
            self.fitted_bias(context, &mut bias_only, decision, &mut flown)?;
        }
        let sigma = sigma(&posterior, &jackknife, &fitted);
        let prior = prior_sigma(context.config);
        let contested = self.contest.groups() > 0;
        Ok(WindowReport {
            t_start_us: self.job.t_start_us,
            t_end_us: self.job.t_end_us,
            t_effect_us: None,
            decision,
            optimizer: context.config.optimizer,
            evaluations,
            cost_before: finite(cost_before),
            cost_after: finite(cost_after),
            fitted,
            bias_only,
            flown,
            sigma,
            observable: core::array::from_fn(|i| sigma[i] < 0.5 * prior[i]),
            rank: observability.rank,
            rest_s: self.job.rest_s,
            explained: if contested { finite(outcome.explained) } else { None },
            p_value: if contested { finite(outcome.p_value) } else { None },
        })
    }

    /// Root mean squares over the moving segments of the rotation that `change` of theta makes, and of its jackknife
    /// deviation, rad. `None` when no segment moved.
    fn promised(&self, change: &[f32; 12], jackknife: &Packed<12, 78>) -> Option<(f32, f32)> {
        let (mut square, mut count) = (0.0, 0.0);
        // The mean of the rows' variances is the sum over the elements of their mean outer product times the covariance.
        let mut rows = Packed::zero();
        for segment in self.segments().iter().filter(|segment| segment.moving) {
            square += turn(segment, change).norm_squared();
            for row in &segment.jacobian {
                rows.add_outer(row, 1.0);
            }
            count += 1.0;
        }
        let rms = |sum: f32| libm::sqrtf(sum / count);
        (count > 0.0).then(|| (rms(square), rms(rows.inner(jackknife))))
    }

    /// Without a rest the bias comes from the window, when it wins clearly: with the factory's P in `bias_only`, with the flown P
    /// in `flown` unless a new P was accepted.
    fn fitted_bias(
        &self,
        context: &Context,
        bias_only: &mut GyroModel,
        decision: Decision,
        flown: &mut GyroModel,
    ) -> Result<(), Refusal> {
        let outcome = self.contest.second_against_third();
        if self.contest.groups() < MIN_GROUPS || acceptance::clear_win(&outcome).is_err() {
            return Ok(());
        }
        let (theta, factory) = (theta_of(context.flown), theta_of(context.factory));
        let fit = |p_change: [f32; 9]| {
            let model = (&Freedom::Bias(p_change), self.magnetometer);
            let x = least_squares::solve(&self.total, &self.variances, &self.prior, &theta, model)?;
            model_of(&core::array::from_fn(|i| theta[i] + x[i])).filter(|model| is_plausible(context, model))
        };
        *bias_only = fit(core::array::from_fn(|i| factory[i] - theta[i])).ok_or(Refusal::Degenerate)?;
        if decision != Decision::Accepted {
            *flown = fit([0.0; 9]).ok_or(Refusal::Degenerate)?;
        }
        Ok(())
    }
}

/// 1-sigma of P and b: the larger of the posterior's and the jackknife's.
fn sigma(posterior: &Cholesky<12, 78>, jackknife: &Packed<12, 78>, fitted: &GyroModel) -> [f32; 12] {
    core::array::from_fn(|i| {
        // b = P^-1 c, so with P near the identity db_i = dc_i - sum_j dP_ij b_j.
        let mut direction = [0.0; 12];
        direction[i] = 1.0;
        if i >= 9 {
            for j in 0..3 {
                direction[3 * (i - 9) + j] = -fitted.b_rad_s[j];
            }
        }
        let by_posterior = dot(&posterior.solve(&direction), &direction);
        let by_jackknife = jackknife.quadratic(&direction);
        libm::sqrtf(if by_jackknife > by_posterior { by_jackknife } else { by_posterior })
    })
}

fn finite(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}
