//! Least squares of the weak form with graduated Geman-McClure weights, and simpler re-weightings.

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

/// Schedule of graduated non-convexity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// Geman-McClure's constant.
    pub constant: f64,
    /// Factor by which mu falls from solve to solve.
    pub factor: f64,
    /// Largest mu to begin with.
    pub most: f64,
    /// Number of Huber solves before.
    pub huber: u32,
    /// Number of solves at mu = 1.
    pub last: u32,
    /// Number of Tukey solves after that.
    pub tukey: u32,
}

impl Schedule {
    /// The prototype's schedule: mu halved down to 1, from where the worst equation is convex.
    pub const HALVED: Self = Self { constant: 3.0, factor: 2.0, most: f64::INFINITY, huber: 0, last: 4, tukey: 0 };

    /// The prototype's, ended by Tukey solves on the same equations.
    pub const POLISHED: Self = Self { constant: 2.0, tukey: 6, ..Self::HALVED };

    /// The same in about 16 solves.
    pub const QUARTERED: Self = Self { factor: 4.0, last: 3, tukey: 4, ..Self::POLISHED };

    /// Twelve solves, without graduation.
    pub const SHORT: Self = Self { constant: 2.0, factor: 2.0, most: 1.0, huber: 3, last: 5, tukey: 3 };
}

/// Graduated non-convexity (Yang et al. 2020): least squares without weights, then mu from 2 r_max^2 / c^2
/// down to 1.
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

/// The mu for which the cost is still convex at the worst residual.
pub(super) fn first_mu(squares: &[f64], c: f64) -> f64 {
    2.0 * squares.iter().copied().fold(0.0, f64::max) / (c * c)
}
