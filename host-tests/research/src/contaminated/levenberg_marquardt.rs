use super::{effort::Spent, readings::Theta, segments::SegmentCost};

/// Damped Gauss-Newton from `delta`, at most `most` trial steps; ends when a step gains less than a
/// millionth.
pub(super) fn levenberg_marquardt(cost: &SegmentCost<'_>, mut delta: Theta, most: u32, spent: &mut Spent) -> Theta {
    let mut damping = 1e-3;
    let mut lowest = cost.evaluate(&delta);
    spent.evaluations += 1;
    let (mut normal, mut descent) = cost.normal(&delta);
    spent.matrices += 1;
    for _ in 0..most {
        let mut damped = normal;
        for i in 0..12 {
            damped[(i, i)] *= 1.0 + damping;
        }
        let Some(factor) = damped.cholesky() else { return delta };
        let candidate = delta + factor.solve(&descent);
        let found = cost.evaluate(&candidate);
        spent.evaluations += 1;
        if found < lowest {
            let gain = lowest - found;
            (delta, lowest) = (candidate, found);
            if gain < 1e-6 * lowest {
                return delta;
            }
            damping *= 0.1;
            (normal, descent) = cost.normal(&delta);
            spent.matrices += 1;
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                return delta;
            }
        }
    }
    delta
}
