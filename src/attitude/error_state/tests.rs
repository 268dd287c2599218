//! The scalar updates agree with the textbook's matrix form.

use super::*;
use crate::rotation::exp_matrix;
use nalgebra::SMatrix;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

type Dense = SMatrix<f64, STATES, STATES>;

fn dense(e: &ErrorState) -> Dense {
    Dense::from_fn(|r, c| f64::from(e.covariance[r.min(c)][r.max(c)]))
}

fn started() -> ErrorState {
    let mut e = ErrorState::new();
    for (state, variance) in [0.01, 0.02, 1.0, 4e-4, 4e-4, 4e-4, 0.25, 0.25].into_iter().enumerate() {
        e.reset(state, variance);
    }
    e
}

fn noise() -> ProcessNoise {
    ProcessNoise {
        attitude: Matrix3::from_diagonal(&Vector3::new(1e-5, 2e-5, 3e-5)),
        bias: 1e-6,
        bounded_bias: [1e-5, 6e-4],
        velocity: 1e-5,
        scale: 1e-5,
    }
}

/// Variances that a step adds to the dense covariance's states, and to its scale's where there is one.
fn added<const N: usize>(expected: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let bias = |k: usize| 1e-6 + if expected[(k, k)] < 6e-4 { 1e-5 } else { 0.0 };
    let states = [1e-5, 2e-5, 3e-5, bias(BIAS), bias(BIAS + 1), bias(BIAS + 2), 1e-5, 1e-5];
    SMatrix::from_fn(|r, c| if r == c { states.get(r).copied().unwrap_or(1e-5) } else { 0.0 })
}

/// Each covariance to the part of the two deviations that single precision leaves after some steps.
fn are_close<const N: usize>(found: &SMatrix<f64, N, N>, expected: &SMatrix<f64, N, N>) -> bool {
    (0..N).all(|r| {
        (0..N).all(|c| {
            let deviations = libm::sqrt(expected[(r, r)] * expected[(c, c)]);
            (found[(r, c)] - expected[(r, c)]).abs() <= 3e-5 * deviations
        })
    })
}

#[test]
fn a_step_is_the_dense_product() {
    let mut e = started();
    let mut expected = dense(&e);
    for i in 0..50_u8 {
        let c = exp_matrix(&Vector3::new(0.1 * f32::from(i), 0.3, -0.2)) * 0.02;
        let mut f = Dense::identity();
        for r in 0..3 {
            for k in 0..3 {
                f[(r, BIAS + k)] = -f64::from(c[(r, k)]);
            }
        }
        f[(VELOCITY, 1)] = -0.196;
        f[(VELOCITY + 1, 0)] = 0.196;
        expected = f * expected * f.transpose() + added(&expected);
        e.predict(&c, 0.196, &Vector3::zeros(), &noise());
    }
    assert!(are_close(&dense(&e), &expected), "{}", dense(&e) - expected);
    // The bound was reached on the way.
    assert!((6e-4..6.5e-4).contains(&expected[(BIAS, BIAS)]), "{}", expected[(BIAS, BIAS)]);
}

#[test]
fn an_optimal_and_a_restricted_gain_agree_with_the_dense_joseph_form() {
    for gain in [Gain::Every, Gain::Heading([true; 3]), Gain::Heading([false, false, true]), Gain::Heading([false; 3])]
    {
        let mut e = started();
        for _ in 0..20 {
            e.predict(&(exp_matrix(&Vector3::new(0.5, 0.2, 0.1)) * 0.02), 0.196, &Vector3::zeros(), &noise());
        }
        let p = dense(&e);
        let slope = Vector2::new(-1.5, 0.7);
        let mut h = SMatrix::<f64, 1, STATES>::zeros();
        (h[0], h[1], h[HEADING]) = (slope.x.into(), slope.y.into(), 1.0);
        let variance = 0.3_f32;
        let seen = (h * p * h.transpose())[0];
        assert!((f64::from(e.seen_heading_variance(&slope)) - seen).abs() < 1e-5 * seen);
        let mut k = p * h.transpose() / (seen + f64::from(variance));
        let still: &[usize] = match gain {
            Gain::Every => &[],
            Gain::Heading([true, ..]) => &[0, 1, 6, 7],
            Gain::Heading([_, _, true]) => &[0, 1, 3, 4, 6, 7],
            Gain::Heading(_) => &[0, 1, 3, 4, 5, 6, 7],
        };
        still.iter().for_each(|i| k[*i] = 0.0);
        let rest = Dense::identity() - k * h;
        let expected = rest * p * rest.transpose() + k * k.transpose() * f64::from(variance);
        e.update_heading(0.2, &slope, variance, gain);
        assert!((dense(&e) - expected).norm() < 1e-5 * expected.norm());
        let (attitude, _, velocity, _) = e.take_correction();
        assert!((f64::from(attitude.z) - 0.2 * k[HEADING]).abs() < 1e-6);
        assert_eq!(gain != Gain::Every, attitude.xy().norm() == 0.0 && velocity.norm() == 0.0);
    }
}

#[test]
fn an_hour_keeps_the_covariance_positive_definite() {
    let mut e = started();
    for i in 0..180_000_u32 {
        let angle = f32::from(u16::try_from(i % 6_283).unwrap_or(0)) * 0.001;
        e.predict(&(exp_matrix(&Vector3::new(0.3, angle, -2.0 * angle)) * 0.02), 0.196, &Vector3::zeros(), &noise());
        e.update(VELOCITY, 0.0, 7.5, Gain::Every);
        e.update(VELOCITY + 1, 0.0, 7.5, Gain::Every);
        e.update_heading(0.0, &Vector2::new(-2.0, 0.5), 2.0, Gain::Heading([true; 3]));
        if i % 3_000 < 500 {
            (BIAS..VELOCITY).for_each(|k| e.update(k, 0.0, 1e-5, Gain::Every));
        }
    }
    assert!(e.is_sound() && dense(&e).cholesky().is_some());
}

/// Number of all states: the scale's errors come after the others.
const ALL: usize = STATES + SCALES;
type Whole = SMatrix<f64, ALL, ALL>;

fn whole(e: &ErrorState) -> Whole {
    Whole::from_fn(|r, c| {
        f64::from(match (r.min(c), r.max(c)) {
            (one, other) if other < STATES => e.covariance[one][other],
            (one, other) if one < STATES => e.scale.cross[one][other - STATES],
            (one, other) => e.scale.own[one - STATES][other - STATES],
        })
    })
}

fn with_scale() -> ErrorState {
    let mut e = started();
    e.estimate_scale(&[0.03, 0.01, 0.012, 0.01, 0.02, 0.01, 0.015, 0.01, 0.04]);
    e
}

fn turned(e: &mut ErrorState, i: u8) -> (Matrix3<f32>, Vector3<f32>) {
    let c = exp_matrix(&Vector3::new(0.1 * f32::from(i), 0.3, -0.2)) * 0.02;
    let rate = Vector3::new(2.0, -1.0 + 0.1 * f32::from(i), 0.5);
    e.predict(&c, 0.196, &rate, &noise());
    (c, rate)
}

#[test]
fn a_step_with_the_scale_is_the_dense_product() {
    let mut e = with_scale();
    let mut expected = whole(&e);
    for i in 0..50_u8 {
        let (c, rate) = turned(&mut e, i);
        let mut f = Whole::identity();
        for r in 0..3 {
            for k in 0..3 {
                f[(r, BIAS + k)] = -f64::from(c[(r, k)]);
                for m in 0..3 {
                    f[(r, STATES + 3 * k + m)] = f64::from(c[(r, k)] * rate[m]);
                }
            }
        }
        // The scale's errors reach the velocity through the attitude at the end of the step.
        let mut late = Whole::identity();
        late[(VELOCITY, 1)] = -0.196;
        late[(VELOCITY + 1, 0)] = 0.196;
        let mut early = f;
        for r in 0..3 {
            for k in 0..SCALES {
                early[(r, STATES + k)] = 0.0;
            }
        }
        early[(VELOCITY, 1)] = -0.196;
        early[(VELOCITY + 1, 0)] = 0.196;
        let f = Whole::from_fn(|r, c| if c < STATES { early[(r, c)] } else { (late * f)[(r, c)] });
        expected = f * expected * f.transpose() + added(&expected);
    }
    assert!(are_close(&whole(&e), &expected), "{}", whole(&e) - expected);
}

#[test]
fn updates_with_the_scale_agree_with_the_dense_joseph_form() {
    // A gain moves every state and the scale; or the heading with some axes of the bias, and the scale with any.
    let heading = [HEADING];
    let cases: [(Gain, &[usize], bool); 4] = [
        (Gain::Every, &[0, 1, 2, 3, 4, 5, 6, 7], true),
        (Gain::Heading([true; 3]), &[HEADING, BIAS, BIAS + 1, BIAS + 2], true),
        (Gain::Heading([false, false, true]), &[HEADING, BIAS + 2], true),
        (Gain::Heading([false; 3]), &heading, false),
    ];
    for (gain, moved, is_scale_moved) in cases {
        let mut e = with_scale();
        for i in 0..20 {
            turned(&mut e, i);
        }
        let p = whole(&e);
        let slope = Vector2::new(-1.5, 0.7);
        let mut h = SMatrix::<f64, 1, ALL>::zeros();
        (h[0], h[1], h[HEADING]) = (slope.x.into(), slope.y.into(), 1.0);
        let variance = 0.3_f32;
        let mut k = p * h.transpose() / ((h * p * h.transpose())[0] + f64::from(variance));
        let moves = |state: usize| if state < STATES { moved.contains(&state) } else { is_scale_moved };
        (0..ALL).filter(|state| !moves(*state)).for_each(|state| k[state] = 0.0);
        let rest = Whole::identity() - k * h;
        let expected = rest * p * rest.transpose() + k * k.transpose() * f64::from(variance);
        e.update_heading(0.2, &slope, variance, gain);
        assert!(are_close(&whole(&e), &expected), "{}", whole(&e) - expected);
        let (.., scale) = e.take_correction();
        (0..SCALES).for_each(|s| assert!((f64::from(scale[(s / 3, s % 3)]) - 0.2 * k[STATES + s]).abs() < 1e-6));
    }
}

#[test]
fn an_observation_that_is_taken_out_leaves_what_was_before() {
    let mut e = with_scale();
    for i in 0..20 {
        turned(&mut e, i);
    }
    let before = whole(&e);
    e.update_scale(4, 0.01, 1e-4);
    let known = whole(&e);
    assert!(known[(STATES + 4, STATES + 4)] < 0.5 * before[(STATES + 4, STATES + 4)]);
    e.update_scale(4, 0.01, -1e-4);
    assert!((whole(&e) - before).norm() < 1e-4 * before.norm());
    let (attitude, .., scale) = e.take_correction();
    assert!(attitude.norm() < 1e-5 && scale.norm() < 1e-5, "{attitude} {scale}");
}

/// Mean of the scale's errors, row-major, and log likelihood of random observations of the attitude while the probe
/// turns, from a prior with these deviations.
fn observed(e: &mut ErrorState, deviations: &[f32; SCALES], seed: u64) -> (SMatrix<f32, 9, 1>, f64) {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut random = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
    *e = ErrorState::new();
    (0..STATES).for_each(|state| e.reset(state, 1e-4));
    e.estimate_scale(deviations);
    let (mut mean, mut log_likelihood) = (SMatrix::<f64, 17, 1>::zeros(), 0.0);
    for i in 0..60_u8 {
        let c = exp_matrix(&Vector3::new(0.1 * f32::from(i), random(), random())) * 0.05;
        let rate = Vector3::new(random(), random(), random()) * 8.0;
        e.predict(&c, 0.0, &rate, &ProcessNoise { scale: 0.0, ..noise() });
        // The mean goes the same way: phi' = C (D w - db).
        let d = Matrix3::from_fn(|r, k| mean[STATES + 3 * r + k] as f32);
        let bias = Vector3::from_fn(|k, _| mean[BIAS + k] as f32);
        let turn = c * (d * rate - bias);
        (0..3).for_each(|k| mean[k] += f64::from(turn[k]));
        for state in 0..3 {
            let (seen, variance) = (0.1 * random(), 1e-4);
            let expected = f64::from(e.variance(state) + variance);
            let innovation = f64::from(seen) - mean[state];
            log_likelihood -= 0.5 * (innovation * innovation / expected + expected.ln());
            e.update(state, innovation as f32, variance, Gain::Every);
            let correction = (e.correction, e.scale.take_correction());
            (0..STATES).for_each(|k| mean[k] += f64::from(correction.0[k]));
            (0..SCALES).for_each(|k| mean[STATES + k] += f64::from(correction.1[(k / 3, k % 3)]));
            e.correction = [0.0; STATES];
        }
    }
    (SMatrix::from_fn(|k, _| mean[STATES + k] as f32), log_likelihood)
}

#[test]
fn a_prior_that_is_widened_is_as_if_it_had_been_wide_from_the_start_and_tells_how_much_more_probable_it_is() {
    let (sigma, wide) = (0.02_f32, [0.06_f32, 0.03]);
    let widths = core::array::from_fn(|k| if k % 4 == 0 { wide[0] } else { wide[1] });
    let (mut more_probable, mut less_probable) = (0, 0);
    for seed in 0..20 {
        let (mut narrow, mut expected) = (started(), started());
        let (mean, likelihood) = observed(&mut narrow, &[sigma; SCALES], seed);
        let (wide_mean, wide_likelihood) = observed(&mut expected, &widths, seed);
        let found = narrow.widen_scale(&Matrix3::from_row_slice(mean.as_slice()), sigma, wide);
        let gained = wide_likelihood - likelihood;
        assert!((f64::from(found) - gained).abs() < 0.05 + 0.01 * gained.abs(), "{found} {gained}");
        assert!((whole(&narrow) - whole(&expected)).norm() < 1e-2 * whole(&expected).norm());
        let correction = narrow.scale.take_correction().transpose();
        let off = mean + SMatrix::<f32, 9, 1>::from_column_slice(correction.as_slice()) - wide_mean;
        assert!(off.norm() < 0.01 * wide_mean.norm(), "{off} {wide_mean}");
        (more_probable, less_probable) =
            (more_probable + i32::from(found > 0.5), less_probable + i32::from(found < -0.5));
    }
    assert!(more_probable > 0 && less_probable > 0, "{more_probable} {less_probable}");
}

#[test]
fn a_prior_that_is_no_wider_changes_nothing() {
    let mut e = with_scale();
    turned(&mut e, 1);
    let before = whole(&e);
    assert_eq!(e.widen_scale(&Matrix3::identity(), 0.06, [0.06, 0.03]), 0.0);
    assert_eq!(whole(&e), before);
}
