//! Gaps, lost samples, clocks that step, and work that is sliced.

use super::*;

#[test]
fn the_result_is_the_same_to_the_bit_however_the_work_is_sliced_and_whenever_time_begins() {
    let simulated = Simulated::new(4, 40.0);
    let whole = posterior::<f32>(&simulated.samples, u32::MAX);
    assert_eq!(posterior::<f32>(&simulated.samples, 150), whole);
    let later: Vec<_> = simulated.samples.iter().map(|(t_us, readings)| (t_us + 7_000_000_000, *readings)).collect();
    assert_eq!(posterior::<f32>(&later, u32::MAX), whole);
}

#[test]
fn a_gap_costs_what_it_spans() {
    let simulated = Simulated::new(5, 60.0);
    let without: Vec<_> =
        simulated.samples.iter().filter(|(t_us, _)| !(30_000_000..32_000_000).contains(t_us)).copied().collect();
    let (whole, cut) = (posterior::<f32>(&simulated.samples, u32::MAX), posterior::<f32>(&without, u32::MAX));
    assert!(
        cut.motion_s > whole.motion_s - 4.0 && cut.motion_s < whole.motion_s,
        "{} {}",
        cut.motion_s,
        whole.motion_s
    );
    let error = largest_difference(&cut.gyro, &simulated.truth);
    assert!(error < 0.3 * largest_difference(&GyroModel::IDENTITY, &simulated.truth), "{error}");
}

#[test]
fn a_few_lost_samples_cost_nothing_but_unusable_ones_do() {
    let simulated = Simulated::new(6, 60.0);
    let is_lost = |t_us: u64| t_us % 2_000_000 < 50_000;
    let lost: Vec<_> = simulated.samples.iter().filter(|(t_us, _)| !is_lost(*t_us)).copied().collect();
    let mut clipped = simulated.samples.clone();
    for (_, readings) in clipped.iter_mut().filter(|(t_us, _)| is_lost(*t_us)) {
        readings[0] = Reading::Unusable;
    }
    let [whole, lost, clipped] =
        [&simulated.samples, &lost, &clipped].map(|samples| posterior::<f32>(samples, u32::MAX));
    assert!((lost.motion_s - whole.motion_s).abs() < 0.5, "{} {}", lost.motion_s, whole.motion_s);
    let error = |found: &Posterior| largest_difference(&found.gyro, &simulated.truth);
    assert!(error(&lost) < 1.5 * error(&whole) + 0.002, "{} {}", error(&lost), error(&whole));
    // A rate beyond the full scale is not between its neighbours.
    assert!(clipped.motion_s < 0.8 * whole.motion_s, "{}", clipped.motion_s);
}

#[test]
fn a_clock_that_steps_is_no_turn() {
    for seed in 0..4 {
        let simulated = Simulated::new(seed, 60.0);
        // Every 3 s by 0.13 s, the first time before much is known.
        let steps = |t_us: u64| (t_us + 2_000_000) / 3_000_000 * 130_000;
        let samples: Vec<_> =
            simulated.samples.iter().map(|(t_us, readings)| (t_us + steps(*t_us), *readings)).collect();
        let error = largest_difference(&posterior::<f32>(&samples, u32::MAX).gyro, &simulated.truth);
        let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
        assert!(error < 0.4 * before, "seed {seed}: {error} of {before}");
    }
}

#[test]
fn gaps_for_half_of_the_time_are_not_the_gyros() {
    let simulated = Simulated::new(5, 120.0);
    let with_gaps: Vec<_> =
        simulated.samples.iter().filter(|(t_us, _)| t_us % 10_000_000 >= 5_500_000).copied().collect();
    let found = posterior::<f32>(&with_gaps, u32::MAX);
    assert_eq!(found.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    let after = largest_difference(&found.gyro, &simulated.truth);
    assert!(after < 0.5 * before, "{after} {before} {}", found.motion_s);
}

#[test]
fn a_posterior_is_of_the_samples_up_to_its_request() {
    let simulated = Simulated::new(16, 30.0);
    let mut estimator = estimator::<f32>();
    let mut late = 0.0;
    for (k, (t_us, [rate, force, field])) in simulated.samples.iter().enumerate() {
        estimator.push(*t_us, [*rate, *force, *field], None);
        // Nothing is done between the two requests.
        if [2_000, 2_060].contains(&k) {
            estimator.close(false);
        }
        while !(2_000..2_060).contains(&k) && estimator.step() > 0 {
            if let Some(posterior) = estimator.posterior().filter(|_| k == 2_060 && late == 0.0) {
                late = posterior.motion_s;
            }
        }
    }
    let mut whole = Box::new(Estimator::<f32>::zero());
    whole.configure(&settings(), &[]);
    for (t_us, [rate, force, field]) in &simulated.samples[..=2_060] {
        whole.push(*t_us, [*rate, *force, *field], None);
        while whole.step() > 0 {}
    }
    whole.close(false);
    while whole.step() > 0 {}
    assert_eq!(late, whole.posterior().unwrap().motion_s);
}
