mod tumbling;

use super::*;
use crate::window::{SampleStream, UNDER_WAY};
use crate::{
    compensation::GyroModel,
    config::IdentificationConfig,
    identification::{
        least_squares::{MagnetometerErrors, ROUNDS, solve_with_variances},
        prior::Prior,
    },
};
use nalgebra::Vector3;
use tumbling::{HOP, tumbling};

/// What the graduation came to.
struct Weighed {
    weights: RobustWeights,
    solution: [f32; MAGNETIC],
    rounds: usize,
    /// Whether too few agreed.
    again: bool,
}

const THETA: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// All the test windows of a stream.
fn windows(stream: &SampleStream) -> TestWindows {
    windows_of(UNDER_WAY, stream)
}

/// The same of so many quarters of the longest.
fn windows_of(quarters: usize, stream: &SampleStream) -> TestWindows {
    let mut tests = TestWindows::zero();
    tests.start(stream, (0, stream.increments.count()), &THETA, quarters);
    while tests.make(stream, 100).unwrap() {}
    tests
}

fn summed(tests: &TestWindows, weights: &RobustWeights) -> Equations {
    let mut sum = Equations::zero();
    for (number, test) in tests.numbered() {
        sum.add(test, &THETA, weights.of(number));
    }
    sum
}

/// Solves, measures and weighs until it is done.
fn weighed(tests: &TestWindows) -> Weighed {
    let prior = Prior::new(&IdentificationConfig::default(), &GyroModel::IDENTITY, None);
    let solve = |sum: &Equations| {
        let round = |before: Option<&[f32; MAGNETIC]>| {
            solve_with_variances(sum, &prior, &THETA, MagnetometerErrors::LagAndIron, before).unwrap().0
        };
        (1..ROUNDS).fold(round(None), |x, _| round(Some(&x)))
    };
    let mut weights = RobustWeights::zero();
    weights.start();
    let mut sum = summed(tests, &weights);
    let mut solution = solve(&sum);
    weights.measure(tests, &THETA, &solution);
    let (mut rounds, mut again) = (0, false);
    while weights.is_running() {
        weights.weigh(tests.numbered(), &THETA, &solution, &mut sum);
        solution = solve(&sum);
        rounds += 1;
        assert!(rounds < 100, "it ends");
        match weights.advance(tests) {
            Round::Next => {}
            Round::Again => {
                again = true;
                break;
            }
            Round::Done => break,
        }
    }
    // Taking in and out by differences comes to the same as adding with the weights.
    let anew = solve(&summed(tests, &weights));
    for (i, (x, y)) in solution.iter().zip(&anew).enumerate().take(12) {
        assert!((x - y).abs() < 2e-4, "{i}: {x} {y}");
    }
    Weighed { weights, solution, rounds, again }
}

/// Largest error of the scale factors and couplings found.
fn p_error(solution: &[f32; MAGNETIC]) -> f32 {
    let truth: [f32; 9] = [1.0 / 1.02 - 1.0, 0.0, 0.0, 0.0, 1.0 / 0.97 - 1.0, 0.0, 0.0, 0.0, 1.0 / 1.01 - 1.0];
    solution.iter().zip(&truth).map(|(x, truth)| (x - truth).abs()).max_by(f32::total_cmp).unwrap()
}

/// Whether increment `k` lies in one of three stretches of four seconds.
fn in_trouble(k: u32) -> bool {
    [400..600, 1_100..1_300, 1_900..2_100].iter().any(|stretch| stretch.contains(&k))
}

/// How much of a test window's sin^2 lies in trouble, 0 to 1.
fn share_in_trouble(number: usize) -> f32 {
    let length = 4 * HOP;
    let weight = |k: u32| 1.0 - libm::cosf(core::f32::consts::TAU * (k as f32 + 0.5) / length as f32);
    (0..length).filter(|k| in_trouble(number as u32 * HOP + k)).map(weight).sum::<f32>() / length as f32
}

#[test]
fn a_clean_window_keeps_every_weight_and_nothing_is_begun() {
    let tests = &windows(&tumbling(|_, _| {}));
    let clean = weighed(tests);
    assert_eq!((clean.rounds, clean.again), (0, false));
    assert!(tests.all().count() > 90);
    assert!(tests.numbered().all(|(number, _)| clean.weights.of(number) == [1.0; 2]));
    assert!(p_error(&clean.solution) < 2e-3, "{:?}", clean.solution);
    assert_eq!(clean.weights.field_agreement(tests), tests.all().count() as f32);
}

/// Steel beside the tool: the field is another for some seconds.
#[test]
fn windows_that_another_field_bends_end_without_weight_and_the_others_keep_theirs() {
    let tests = &windows(&tumbling(|k, [_, _, field]| {
        if in_trouble(k) {
            *field += Vector3::new(12.0, -9.0, 14.0);
        }
    }));
    let found = weighed(tests);
    assert!(!found.again && found.rounds > 8, "{}", found.rounds);
    let (mut bent, mut clean, mut kept) = (0, 0, 0);
    for (number, _) in tests.numbered() {
        let [gravity, field] = found.weights.of(number);
        let share = share_in_trouble(number);
        if share > 0.05 && share < 0.95 {
            // Where the field changes.
            assert!(field < 0.05, "{number}: {field}");
            bent += 1;
        } else if share == 0.0 {
            clean += 1;
            kept += u32::from(gravity > 0.5 && field > 0.5);
            assert!(gravity > 0.1 && field > 0.1, "{number}: {gravity} {field}");
        }
        assert!(gravity <= field, "{number}");
    }
    assert!(bent > 15 && clean > 50 && 10 * kept > 9 * clean, "{bent} {clean} {kept}");
    assert!(p_error(&found.solution) < 3e-3, "{:?}", found.solution);
}

/// Three tenths of the test windows with a fault in them; gravity, which vibrates, hardly shows it.
#[test]
fn a_fault_of_the_gyro_that_only_the_field_shows_takes_gravitys_weight_too() {
    let fault = Vector3::new(0.06, -0.05, 0.05);
    let tests = &windows(&tumbling(|k, [rate, _, _]| {
        if in_trouble(k) {
            *rate += fault;
        }
    }));
    let found = weighed(tests);
    assert!(!found.again);
    let (mut bent, mut shown_by_gravity) = (0, 0);
    for (number, test) in tests.numbered() {
        let [gravity, field] = found.weights.of(number);
        if share_in_trouble(number) > 0.3 {
            assert!(gravity < 0.02 && field < 0.02, "{number}: {gravity} {field}");
            let [Some(square), _] = squares_of(test, &THETA, &found.solution) else { panic!("gravity was read") };
            bent += 1;
            shown_by_gravity += u32::from(Graduation::Tukey(0).weight(square / found.weights.variances[0]) == 0.0);
        } else if share_in_trouble(number) == 0.0 {
            assert!(gravity > 0.5 && field > 0.5, "{number}: {gravity} {field}");
        }
    }
    assert!(bent >= 24 && 2 * shown_by_gravity < bent, "{shown_by_gravity} of {bent}");
    assert!(p_error(&found.solution) < 3e-3, "{:?}", found.solution);
}

/// A soft iron bends every test window by more than the sensor's noise, a little or a lot: no disturbance of some.
#[test]
fn where_what_bends_them_is_the_rule_hardly_any_window_agrees() {
    for (x, z) in [(1.02, 0.985), (1.2, 0.85)] {
        let tests = &windows(&tumbling(|_, [_, _, field]| field.component_mul_assign(&Vector3::new(x, 1.0, z))));
        let found = weighed(tests);
        assert!(found.again);
    }
}

/// Two fifths of the time another field, and never two seconds without: whole are only shorter test windows.
#[test]
fn shorter_test_windows_are_whole_between_frequent_disturbances() {
    let is_hit = |k: u32| k % 125 >= 75;
    let stream = tumbling(|k, [_, _, field]| {
        if is_hit(k) {
            // Each time another.
            let turn = (k / 125) as f32;
            *field += Vector3::new(libm::sinf(3.0 * turn), libm::cosf(5.0 * turn), libm::sinf(7.0 * turn)) * 20.0;
        }
    });
    assert!(weighed(&windows(&stream)).again);
    let tests = &windows_of(1, &stream);
    let found = weighed(tests);
    assert!(!found.again);
    for (number, _) in tests.numbered() {
        let mut hits = (number as u32 * HOP..(number as u32 + 1) * HOP).map(is_hit);
        let [_, field] = found.weights.of(number);
        if hits.all(|hit| !hit) {
            assert!(field > 0.1, "{number}: {field}");
        }
    }
    assert!(p_error(&found.solution) < 1e-2, "{:?}", found.solution);
}

#[test]
fn a_sensor_without_a_scale_begins_nothing() {
    let mut weights = RobustWeights::zero();
    weights.variances = [1.0, 0.0];
    weights.begin(1e9);
    assert!(!weights.is_running());
    weights.variances = [1.0; 2];
    weights.begin(f32::NAN);
    assert!(!weights.is_running());
}
