use super::*;
use crate::estimator::columns::HARD_IRON;

#[test]
fn columns_that_were_given_are_no_evidence() {
    let columns = Columns::of_group(&HARD_IRON);
    let mut posterior = Posterior { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
    (posterior.mean[0], posterior.mean[1], posterior.mean[2]) = (3.0, -0.5, 2.0);
    for (i, row) in [[0.1, 0.02, 0.03], [0.02, 0.2, 0.01], [0.03, 0.01, 0.4]].iter().enumerate() {
        posterior.covariance[i][..3].copy_from_slice(row);
    }
    let mut entered = Entered::zero();
    let whole: f64 = entered.evidence(columns, &posterior);
    assert!((whole - savage_dickey(&posterior.mean, &posterior.covariance, 3)).abs() < 1e-12);
    entered.begin_with(columns.iter().take(1).chain(columns.iter().skip(2)));
    let alone = 0.5 * (0.25 / 0.2 + libm::log(0.2));
    assert!((entered.evidence(columns, &posterior) - alone).abs() < 1e-12);
}
