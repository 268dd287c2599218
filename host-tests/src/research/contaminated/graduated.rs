//! Least squares of the weak form with graduated Geman-McClure weights, and the plainer re-weightings beside it.

use super::{
    effort::Spent,
    loss::{HUBER, Loss, TUKEY},
    readings::Theta,
    weak_form::WeakForm,
};

/// Re-weighted least squares with one loss, from `theta`.
pub(super) fn reweighted(
    problem: &WeakForm<'_>,
    loss: Loss,
    mut theta: Theta,
    solves: u32,
    spent: &mut Spent,
) -> Theta {
    for _ in 0..solves {
        theta = problem.solve(&problem.weights(loss, &theta));
        spent.solve();
    }
    theta
}

/// How the non-convexity is let in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// Geman-McClure's constant.
    pub constant: f64,
    /// Factor by which mu falls from solve to solve.
    pub factor: f64,
    /// mu begins at most here.
    pub most: f64,
    /// Solves with Huber's weights before.
    pub huber: u32,
    /// Solves at mu = 1.
    pub last: u32,
    /// Solves with Tukey's weights after that.
    pub tukey: u32,
}

impl Schedule {
    /// The one of the prototype: mu halved from where the worst equation is convex to 1.
    pub const HALVED: Self = Self { constant: 3.0, factor: 2.0, most: f64::INFINITY, huber: 0, last: 4, tukey: 0 };

    /// Ended by Tukey's weights on the same equations.
    pub const POLISHED: Self = Self { constant: 2.0, tukey: 6, ..Self::HALVED };

    /// The same in 16 solves or so.
    pub const QUARTERED: Self = Self { factor: 4.0, last: 3, tukey: 4, ..Self::POLISHED };

    /// Twelve solves, without graduation.
    pub const SHORT: Self = Self { constant: 2.0, factor: 2.0, most: 1.0, huber: 3, last: 5, tukey: 3 };
}

/// Graduated non-convexity (Yang et al. 2020): least squares without weights, then mu from 2 r_max^2 / c^2 down to 1.
pub(super) fn graduated(problem: &WeakForm<'_>, schedule: Schedule, spent: &mut Spent) -> Theta {
    let start = problem.unweighted(spent);
    let mut theta = reweighted(problem, Loss::Huber(HUBER), start, schedule.huber, spent);
    let c = schedule.constant;
    let mut mu = first_mu(&problem.squares(&theta), c).min(schedule.most);
    while mu > 1.0 {
        theta = reweighted(problem, Loss::GemanMcClure(c, mu), theta, 1, spent);
        mu /= schedule.factor;
    }
    theta = reweighted(problem, Loss::GemanMcClure(c, 1.0), theta, schedule.last, spent);
    reweighted(problem, Loss::Tukey(TUKEY), theta, schedule.tukey, spent)
}

/// Where the cost is still convex at the worst residual.
pub(super) fn first_mu(squares: &[f64], c: f64) -> f64 {
    2.0 * squares.iter().copied().fold(0.0, f64::max) / (c * c)
}
