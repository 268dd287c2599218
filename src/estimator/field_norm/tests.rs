//! Means over the first nodes, and over minutes.

use super::*;

fn add(norms: &mut FieldNorm<f64>, norm: f64) {
    let mut pre = Preintegration::zero();
    pre.field_norms = 4.0 * norm;
    norms.add(&pre, 0.25);
}

#[test]
fn the_mean_of_the_first_nodes_is_theirs() {
    let mut norms = FieldNorm::<f64>::zero();
    assert_eq!(norms.scatter(), None);
    [0.9, 1.1, 1.3].into_iter().for_each(|norm| add(&mut norms, norm));
    assert!((norms.of_their_time() - 1.1).abs() < 1e-12);
}

/// A step is forgotten as exp(-t / 300 s), however long the field was another one before.
#[test]
fn the_mean_follows_a_step_within_minutes_however_long_the_run() {
    let mut norms = FieldNorm::<f64>::zero();
    (0..2_000).for_each(|_| add(&mut norms, 1.0));
    assert!((norms.of_their_time() - 1.0).abs() < 1e-12);
    for minutes in 1..=10 {
        (0..120).for_each(|_| add(&mut norms, 1.2));
        let expected = 1.2 - 0.2 * libm::exp(-f64::from(minutes) / 5.0);
        assert!((norms.of_their_time() - expected).abs() < 2e-3, "{minutes}: {}", norms.of_their_time());
    }
}

#[test]
fn half_of_the_usual_readings_make_a_mean_whatever_the_sensors_rate() {
    let mut pre = Preintegration::<f64>::zero();
    pre.increments = 12;
    for usual in [2, 5, 12] {
        let mut norms = FieldNorm::zero();
        pre.fields = usual;
        for _ in 0..100 {
            assert!(!norms.has_too_few(&pre));
            add(&mut norms, 1.0);
        }
        pre.fields = usual.div_ceil(2);
        assert!(!norms.has_too_few(&pre), "{usual}");
        pre.fields = usual.div_ceil(2) - 1;
        assert!(norms.has_too_few(&pre) || pre.fields == 0, "{usual}");
    }
}
