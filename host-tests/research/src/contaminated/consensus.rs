use super::{
    effort::Spent,
    graduated::reweighted,
    loss::{Loss, TUKEY},
    window::{Answer, Window},
};
use testbed::simulate::random::Random;

/// Test windows of a subset: four of both sensors leave three equations over, and half of them hit still
/// leaves one subset in 16.
const SUBSET: usize = 4;

/// Random sample consensus (Fischler and Bolles, Comm. ACM 24 (1981) 381) with a truncated cost (MSAC) and
/// local optimisation: each subset that beats the best gets two re-weighted solves on everything, the winner
/// six.
pub(super) fn ransac(window: &Window<'_>, draws: u32) -> Answer {
    let problem = window.weak_form(false);
    let loss = Loss::Tukey(TUKEY);
    let mut spent = Spent::default();
    let mut random = Random::new(window.seed);
    let pairs = problem.equations.len() / 2;
    let mut best = problem.prior.mean;
    let mut lowest = f64::INFINITY;
    for _ in 0..draws {
        let mut weights = vec![0.0; problem.equations.len()];
        for _ in 0..SUBSET {
            let pair = (random.uniform() * pairs as f64) as usize;
            if let Some(pair) = weights.get_mut(2 * pair..2 * pair + 2) {
                pair.fill(1.0);
            }
        }
        let theta = problem.solve(&weights);
        spent.solve();
        let cost = problem.cost(loss, &theta);
        if cost < lowest {
            let refined = reweighted(&problem, loss, theta, 2, &mut spent);
            let cost = problem.cost(loss, &refined);
            spent.evaluations += 1;
            (best, lowest) = if cost < lowest { (refined, cost) } else { (best, lowest) };
        }
    }
    let theta = reweighted(&problem, loss, best, 6, &mut spent);
    Answer { theta, spent }
}
