//! The field: slow, turned, weaker and with another iron.

use super::*;

/// A magnetometer at 10 Hz is slower than the increments.
#[test]
fn a_slow_magnetometer_is_one() {
    let simulated = Simulated::new(6, 60.0);
    let mut samples = simulated.samples.clone();
    for (_, readings) in samples.iter_mut().enumerate().filter(|(k, _)| k % 10 != 0).map(|(_, sample)| sample) {
        readings[2] = Reading::Missing;
    }
    let found = posterior::<f32>(&samples, u32::MAX);
    assert_eq!(found.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    let error = largest_difference(&found.gyro, &simulated.truth);
    assert!(error < 0.4 * before, "{error} of {before}");
}

/// The samples with the field changed from one second to another, and back.
fn with_field(
    simulated: &Simulated,
    from_s: u64,
    to_s: u64,
    change: impl Fn(Vector3<f32>) -> Vector3<f32>,
) -> Posterior {
    let within = from_s * 1_000_000..to_s * 1_000_000;
    let changed = simulated.samples.iter().map(|(t_us, readings)| match readings {
        [rate, force, Reading::Usable(field)] if within.contains(t_us) => {
            (*t_us, [*rate, *force, Reading::Usable(change(*field))])
        }
        _ => (*t_us, *readings),
    });
    posterior::<f32>(&changed.collect::<Vec<_>>(), u32::MAX)
}

#[test]
fn a_field_that_is_turned_for_seconds_is_none() {
    for seed in 10..14 {
        let simulated = Simulated::new(seed, 60.0);
        let clean = largest_difference(&posterior::<f32>(&simulated.samples, u32::MAX).gyro, &simulated.truth);
        // Its norm stays.
        let hit =
            with_field(&simulated, 30, 34, |field| Rotation3::from_scaled_axis(Vector3::new(0.5, 0.0, 0.3)) * field);
        let error = largest_difference(&hit.gyro, &simulated.truth);
        assert_eq!(hit.fitness, Ok(()), "seed {seed}");
        assert!(error < 1.1 * clean + 1e-4, "seed {seed}: {error}, clean {clean}");
    }
}

/// By hand a field is judged by its usual norm.
#[test]
fn a_field_that_stays_weaker_is_the_usual_one_when_it_is_learnt_anew() {
    let simulated = Simulated::new(17, 140.0);
    let mut estimator = estimator::<f32>();
    for (t_us, [rate, force, field]) in &simulated.samples {
        let weaker = |field: &Vector3<f32>| Reading::Usable(field * if *t_us < 100_000_000 { 1.0 } else { 0.75 });
        let field = if let Reading::Usable(field) = field { weaker(field) } else { *field };
        estimator.push(*t_us, [*rate, *force, field], None);
        while estimator.step() > 0 {}
    }
    let usual = estimator.filter.node.norms.of_their_time();
    assert!((usual - 0.75).abs() < 0.03, "{usual} of the first field's norm");
}

#[test]
fn a_configuration_forgets_how_noisy_the_field_was() {
    let simulated = Simulated::new(18, 40.0);
    let mut estimator = estimator::<f32>();
    for (t_us, readings) in &simulated.samples {
        estimator.push(*t_us, *readings, None);
        while estimator.step() > 0 {}
    }
    assert!(estimator.filter.remainder.dispersion() > 0.0);
    estimator.configure(&settings(), &[]);
    assert_eq!(estimator.filter.remainder.dispersion(), 0.0);
}

#[test]
fn a_hard_iron_that_stays_another_is_learnt_anew() {
    let simulated = Simulated::new(15, 140.0);
    let other = with_field(&simulated, 60, 140, |field| field + Vector3::new(15.0, 0.0, -10.0));
    assert_eq!(other.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    assert!(largest_difference(&other.gyro, &simulated.truth) < 0.25 * before);
}
