#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Twelve parameters, counted by loops.

use super::{
    Decision, Refusal, WindowReport,
    acceptance::{self, Evidence, Promise},
    contest::MIN_GROUPS,
    drift::Drift,
    job::{Context, Job},
    least_squares::{Freedom, Model},
    motion::Motion,
    prior::{model_of, prior_sigma, theta_of},
    refinement::Refinement,
    weak_fit::{FACTORY_P, FLOWN_P, FULL, NOTHING},
    window_fit::WindowFit,
};
use crate::{
    algebra::{Cholesky, Packed, dot, minus, plus},
    compensation::GyroModel,
    optimizer::Cost,
    window::gyro_part,
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
        optimizer: context.config.identification.optimizer,
        evaluations: 0,
        cost_before: None,
        cost_after: None,
        fitted: flown,
        bias_only,
        flown,
        sigma: prior_sigma(&context.config.identification),
        observable: [false; 12],
        rank: 0,
        rest_s: job.rest_s,
        explained: None,
        p_value: None,
    }
}

/// The flown and the factory's P, both with the bias from rest where there is one; the flown model keeps a bias that was learnt
/// since. The factory's is what would fly without the effects, so its bias holds their part.
#[inline(never)]
pub(super) fn with_rest_bias(context: &Context, job: &Job) -> (GyroModel, GyroModel) {
    let kept = context.flown.b_rad_s;
    let flown = job.rest.filter(|_| job.rest_is_news).map_or(kept, |rest| rest.rate.into());
    let b_rad_s = job.rest_as_read.map_or(kept, |rest| rest.rate.into());
    (GyroModel { b_rad_s: flown, ..*context.flown }, GyroModel { b_rad_s, ..context.config.gyro })
}

/// Whether every parameter lies near enough to the factory's.
fn is_plausible(context: &Context, model: &GyroModel) -> bool {
    let (theta, factory, sigma) =
        (theta_of(model), theta_of(&context.config.gyro), prior_sigma(&context.config.identification));
    (0..12).all(|i| libm::fabsf(theta[i] - factory[i]) <= PLAUSIBLE_SIGMAS * sigma[i])
}

impl WindowFit {
    /// The report of a fit that could not be carried through.
    pub(super) fn without_fit(&self, context: &Context) -> WindowReport {
        let refusal = match self.fit_to_judge(context) {
            Ok(()) if self.weak.total.is_empty() => self.too_little(0),
            Ok(()) => Refusal::Degenerate,
            Err(refusal) => refusal,
        };
        unidentified(context, &self.job, refusal)
    }

    /// The report of a fit, with its uncertainty and the gate's decision.
    #[inline(never)]
    pub(super) fn judged(&self, context: &Context) -> WindowReport {
        self.judge(context).unwrap_or_else(|refusal| unidentified(context, &self.job, refusal))
    }

    fn fit_to_judge(&self, context: &Context) -> Result<(), Refusal> {
        let [gravity_rows, field_rows] = self.weak.seen;
        let rest_norm_error = self.job.rest_norm_error_m_s2;
        acceptance::sensors_fit_to_judge(field_rows, gravity_rows, rest_norm_error, context.accelerometer_on_record())
            .map_err(|refusal| match refusal {
                Refusal::NotEnoughExcitation { rank } => self.too_little(rank),
                other => other,
            })
    }

    /// Why there is too little to identify from: the tool did not turn, or the gyro did not see it.
    fn too_little(&self, rank: u8) -> Refusal {
        let share = self.weak.spoilt_share();
        if share > SPOILT_SHARE { Refusal::GyroUnusable { share } } else { Refusal::NotEnoughExcitation { rank } }
    }

    /// Why there are too few groups to cross-validate with.
    fn too_few(&self, groups: usize, rank: u8) -> Refusal {
        match self.too_little(rank) {
            Refusal::NotEnoughExcitation { rank: 12 } => Refusal::TooLittleMotion { groups: groups as u8 },
            other => other,
        }
    }

    fn judge(&self, context: &Context) -> Result<WindowReport, Refusal> {
        let refinement = self.refinement().ok_or(Refusal::Degenerate)?;
        let Refinement { innovations, .. } = refinement;
        let objective = refinement.objective(&self.weak.prior);
        let (delta, evaluations) = refinement.optimum(&self.weak.prior);
        let mut theta = plus(&innovations.theta0, &delta);
        let drift = innovations.drift(context, &self.job, &delta).ok_or(Refusal::Degenerate)?;
        for i in 0..3 {
            theta[9 + i] += drift.change[i];
        }
        let fitted = model_of(&theta).ok_or(Refusal::Degenerate)?;
        let cost_before = objective.evaluate(&minus(&theta_of(context.flown), &innovations.theta0));
        let cost_after = objective.evaluate(&delta);

        let posterior = refinement.posterior.as_ref().ok_or(Refusal::Degenerate)?;
        let observability = refinement.observability.as_ref().ok_or(Refusal::Degenerate)?;
        let jackknife = self.weak.jackknife();

        let (base, mut bias_only) = with_rest_bias(context, &self.job);
        let base_theta = theta_of(&base);
        let change = observability.observed_part(&minus(&theta, &base_theta));
        let candidate = model_of(&plus(&base_theta, &change));

        let contest = &self.weak.contest;
        let outcome = self.weak.outcome(context, &theta);
        let verdict = self.fit_to_judge(context).and_then(|()| {
            acceptance::consistent(refinement.contradiction)?;
            acceptance::agreed(innovations.motion.disagreement())?;
            let promise = promised(&innovations.motion, &change, &theta, &jackknife, posterior)
                .ok_or_else(|| self.too_little(observability.rank()))?;
            if contest.groups() < MIN_GROUPS {
                return Err(self.too_few(contest.groups(), observability.rank()));
            }
            let field_is_doubtful = context.stream.turns_axes() || context.stream.magnet_moved_us > self.job.t_start_us;
            let news = acceptance::judge(&Evidence { outcome, promise, field_is_doubtful });
            if news.is_ok() || context.flown.p == context.config.gyro.p {
                return news;
            }
            acceptance::judge_refinement(
                &contest.between(FULL, FACTORY_P),
                [contest.between(FLOWN_P, FULL), contest.between(NOTHING, FULL)],
                &promise,
            )
        });
        let mut flown = base;
        let mut decision = match (verdict, candidate) {
            (Ok(()), Some(candidate)) if cost_after < cost_before && is_plausible(context, &candidate) => {
                flown = candidate;
                Decision::Accepted
            }
            (Ok(()), _) => Decision::Refused(Refusal::Degenerate),
            (Err(refusal), _) => Decision::Refused(refusal),
        };
        self.fitted_bias(context, &mut bias_only, decision, &mut flown);
        if let Some(p_value) = self.is_rolled_back(context, decision) {
            flown = GyroModel { b_rad_s: flown.b_rad_s, ..context.config.gyro };
            decision = Decision::Refused(Refusal::RolledBack { p_value });
        }
        let sigma = sigma(posterior, &jackknife, &drift, &fitted);
        let prior = prior_sigma(&context.config.identification);
        let contested = self.weak.contest.groups() > 0;
        Ok(WindowReport {
            t_start_us: self.job.t_start_us,
            t_end_us: self.job.t_end_us,
            t_effect_us: None,
            decision,
            optimizer: context.config.identification.optimizer,
            evaluations,
            cost_before: finite(cost_before),
            cost_after: finite(cost_after),
            fitted,
            bias_only,
            flown,
            sigma,
            observable: core::array::from_fn(|i| sigma[i] < 0.5 * prior[i]),
            rank: observability.rank(),
            rest_s: self.job.rest_s,
            explained: if contested { finite(outcome.explained) } else { None },
            p_value: if contested { finite(outcome.p_value) } else { None },
        })
    }

    /// Whether what was accepted before no longer holds: on unseen test windows, each with a bias fitted to the others, the factory's P
    /// does better than the one that flies; or the window contradicts what was learnt, and the one that flies does not win again on test
    /// windows that did not teach it. How probable so clear a win of the factory's is by chance.
    fn is_rolled_back(&self, context: &Context, decision: Decision) -> Option<f32> {
        let contest = &self.weak.contest;
        if decision == Decision::Accepted || context.flown.p == context.config.gyro.p || contest.groups() < MIN_GROUPS {
            return None;
        }
        let factory_wins = contest.between(FACTORY_P, FLOWN_P);
        let contradicts = matches!(decision, Decision::Refused(Refusal::Contradiction { .. }));
        let wins_again = acceptance::wins_again(&contest.between_on_fresh(FLOWN_P, FACTORY_P), contest.fresh_groups());
        let is_rolled_back = acceptance::is_worse(&factory_wins) || contradicts && !wins_again;
        is_rolled_back.then_some(factory_wins.p_value)
    }

    /// The bias comes from the window, a rest being what was known before, when that wins clearly: with the factory's P in `bias_only`,
    /// with the flown P in `flown` unless a new P was accepted.
    fn fitted_bias(&self, context: &Context, bias_only: &mut GyroModel, decision: Decision, flown: &mut GyroModel) {
        let outcome = self.weak.contest.between(FLOWN_P, NOTHING);
        if self.weak.contest.groups() < MIN_GROUPS || acceptance::clear_win(&outcome).is_err() {
            return;
        }
        let (theta, factory) = (theta_of(context.flown), theta_of(&context.config.gyro));
        let fit = |p_change: [f32; 9]| {
            let model = Model { freedom: Freedom::Bias(p_change), magnetometer: self.weak.magnetometer };
            let x = self.weak.fit(&model)?;
            model_of(&plus(&theta, &gyro_part(&x))).filter(|model| is_plausible(context, model))
        };
        // A bias that is not plausible is percents of scale seen through the bias alone: it stays as it was.
        *bias_only = fit(core::array::from_fn(|i| factory[i] - theta[i])).unwrap_or(*bias_only);
        if decision != Decision::Accepted {
            *flown = fit([0.0; 9]).unwrap_or(*flown);
        }
    }
}

/// What a `change` of theta does to the rotation of the moving seconds. `None` when nothing moved.
fn promised(
    motion: &Motion,
    change: &[f32; 12],
    theta: &[f32; 12],
    jackknife: &Packed<12, 78>,
    posterior: &Cholesky<12, 78>,
) -> Option<Promise> {
    let mut of_p = *change;
    of_p[9..].fill(0.0);
    Some(Promise {
        change_rad: motion.turned_by(change)?,
        by_p_rad: motion.turned_by(&of_p)?,
        whole_rad: motion.turned_by(theta)?,
        jackknife_rad: motion.deviation(jackknife),
        posterior_rad: motion.deviation_of(posterior),
    })
}

/// By how much the jackknife's deviation has to exceed the posterior's to be believed instead: its square has some nine degrees of
/// freedom, so it is 3.1 times the true one once in a thousand (F distribution), and the least-squares fits that it is of have 1.7
/// times the variance.
const JACKKNIFE_RATIO: f32 = 2.3;

/// 1-sigma of P and of b at the window's end: the posterior's, or the jackknife's where effects that no model knows make it far larger.
fn sigma(posterior: &Cholesky<12, 78>, jackknife: &Packed<12, 78>, drift: &Drift, fitted: &GyroModel) -> [f32; 12] {
    core::array::from_fn(|i| {
        // b = P^-1 c, so with P near the identity db_i = dc_i - sum_j dP_ij b_j.
        let mut direction = [0.0; 12];
        direction[i] = 1.0;
        let mut walked = 0.0;
        if i >= 9 {
            for j in 0..3 {
                direction[3 * (i - 9) + j] = -fitted.b_rad_s[j];
            }
            walked = drift.variance[(i - 9, i - 9)];
        }
        let by_posterior = dot(&posterior.solve(&direction), &direction) + walked;
        let by_jackknife = jackknife.quadratic(&direction);
        let believed = by_jackknife > JACKKNIFE_RATIO * JACKKNIFE_RATIO * by_posterior;
        libm::sqrtf(if believed { by_jackknife } else { by_posterior })
    })
}

fn finite(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}
