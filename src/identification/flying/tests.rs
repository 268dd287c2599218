//! Which model flies after an estimate.

use super::*;
use crate::estimator::CandidateSet;

const FLOWN: GyroModel =
    GyroModel { p: [[1.02, 0.0, 0.0], [0.0, 0.99, 0.0], [0.0, 0.01, 1.0]], b_rad_s: [0.01, 0.0, -0.01] };

fn posterior(fitness: Result<(), Refusal>) -> Posterior {
    Posterior {
        gyro: GyroModel { b_rad_s: [0.02; 3], ..GyroModel::IDENTITY },
        bias_only: GyroModel { b_rad_s: [0.03; 3], ..GyroModel::IDENTITY },
        of_effects_at_rest_rad_s: Vector3::zeros(),
        taken_out: CandidateSet::EMPTY,
        sigma: [0.01; 12],
        p_covariance: core::array::from_fn(|i| i as f32),
        decided: 5,
        observable: [true, false, true, false, true, false, true, false, true, true, false, true],
        widths: [1.0, 0.3, 3.0, 0.5, 2.0],
        nis: 1.1,
        motion_s: 20.0,
        fitness,
    }
}

const fn flight(config: &Config) -> Flight<'_> {
    Flight {
        config,
        flown: &FLOWN,
        bias_only: &FLOWN,
        of_effects_at_rest_rad_s: Vector3::new(0.0, 0.0, 0.0),
        rest_is_news: false,
        rest_s: 2.0,
        mounting_wrong: TurnFlags::empty(),
    }
}

#[test]
fn the_mean_flies_where_it_may_and_else_p_stays_and_the_bias_follows_a_new_rest() {
    let config = Config::default();
    let (before, after) = (flight(&config), Flight { rest_is_news: true, ..flight(&config) });
    let fit = posterior(Ok(()));
    assert_eq!(before.decide(&fit), (Decision::Accepted, fit.gyro));
    let unfit = posterior(Err(Refusal::NotEnoughMotion { motion_s: 3.0, needed_s: 10.0 }));
    let refused = Decision::Refused(Refusal::NotEnoughMotion { motion_s: 3.0, needed_s: 10.0 });
    assert_eq!(before.decide(&unfit), (refused, FLOWN));
    assert_eq!(after.decide(&unfit), (refused, GyroModel { b_rad_s: [0.03; 3], ..FLOWN }));
}

#[test]
fn the_bias_of_a_rest_is_beside_the_effects_that_fly_and_not_those_of_a_refused_estimate() {
    let config = Config::default();
    let mut unfit = posterior(Err(Refusal::GyroUnusable { share: 0.9 }));
    // At rest the gyro read 0.03 + 0.2 about z, and a warming that does not fly was taken for the latter.
    unfit.of_effects_at_rest_rad_s = Vector3::new(0.0, 0.0, 0.2);
    let none_flies = Flight { rest_is_news: true, ..flight(&config) };
    let (_, told) = none_flies.decide(&unfit);
    assert!((Vector3::from(told.b_rad_s) - Vector3::new(0.03, 0.03, 0.23)).norm() < 1e-6, "{told:?}");
    let one_flies = Flight { of_effects_at_rest_rad_s: Vector3::new(0.0, 0.1, 0.0), ..none_flies };
    let (_, told) = one_flies.decide(&unfit);
    assert!((Vector3::from(told.b_rad_s) - Vector3::new(0.03, -0.07, 0.23)).norm() < 1e-6, "{told:?}");
}

#[test]
fn nothing_is_accepted_while_the_sensors_do_not_agree_on_a_turn() {
    let turns = TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG;
    let config = Config::default();
    let flight = |mounting_wrong| Flight { mounting_wrong, ..flight(&config) };
    let update = Update { t_us: 50, effect_us: 51, is_window: true, window_start_us: 10, since_start_us: 50 };
    assert_eq!(flight(TurnFlags::empty()).judged(&update, &posterior(Ok(()))).decision, Decision::Accepted);
    let wrong = flight(turns).judged(&update, &posterior(Ok(())));
    assert_eq!((wrong.decision, wrong.flown), (Decision::Refused(Refusal::WrongMounting { turns }), FLOWN));
}

#[test]
fn what_is_no_model_never_flies() {
    let mut bad = posterior(Ok(()));
    bad.gyro.p[1][1] = f32::NAN;
    bad.bias_only.b_rad_s[2] = f32::INFINITY;
    let config = Config::default();
    let flight = Flight { rest_is_news: true, ..flight(&config) };
    assert_eq!(flight.decide(&bad), (Decision::Refused(Refusal::Diverged { nis: 1.1 }), FLOWN));
}

#[test]
fn a_percent_of_scale_on_every_axis_is_3_6_deg_in_a_turn() {
    let after = GyroModel { p: FLOWN.p.map(|row| row.map(|x| 1.01 * x)), ..FLOWN };
    assert!((deg_per_turn(&FLOWN, &after) - 3.6).abs() < 1e-3);
    assert_eq!(deg_per_turn(&FLOWN, &FLOWN), 0.0);
}

#[test]
fn a_report_holds_the_whole_covariance_of_p_and_of_the_prior_where_there_is_no_result() {
    let config = Config::default();
    let flight = flight(&config);
    let update = Update { t_us: 50, effect_us: 51, is_window: true, window_start_us: 10, since_start_us: 50 };
    let report = flight.judged(&update, &posterior(Ok(())));
    assert_eq!((report.covariance_of_p(0, 0), report.covariance_of_p(3, 1)), (0.0, 7.0));
    assert_eq!((report.covariance_of_p(1, 3), report.covariance_of_p(8, 8)), (7.0, 44.0));
    assert_eq!((report.covariance_of_p(9, 0), report.rank), (0.0, 7));
    assert_eq!((report.t_start_us, report.t_end_us, report.rest_s), (10, 50, 2.0));
    let without = flight.without_result(&update, Refusal::Overrun);
    let sigma = config.identification.prior_sigma_off_diagonal;
    assert_eq!((without.flown, without.covariance_of_p(5, 5)), (FLOWN, sigma * sigma));
    assert_eq!(without.covariance_of_p(5, 4), 0.0);
}
