use super::ideal::{attitude, files, smooth};
use nalgebra::{UnitQuaternion, Vector3};
use testbed::simulate::{Scenario, simulate};

#[test]
fn the_true_rate_integrates_to_the_true_attitude() {
    for scenario in files() {
        let (trace, _) = simulate(&Scenario { duration_s: 75.0, ..scenario }, 3);
        let rates = trace.true_rate.as_ref().unwrap();
        let first = 1_000;
        let mut q = attitude(&trace, first);
        for i in first..first + 6_000 {
            let [a, b] = [Vector3::from(rates[i]), Vector3::from(rates[i + 1])];
            q *= UnitQuaternion::from_scaled_axis((a + b) * 0.005 + a.cross(&b) * (1e-4 / 12.0));
        }
        let error = q.angle_to(&attitude(&trace, first + 6_000)).to_degrees();
        assert!(error < 0.05, "{error} deg after 60 s");
    }
}

#[test]
fn the_tool_stands_still_then_turns_between_nothing_and_twice_the_mean() {
    for scenario in files() {
        let (trace, _) = simulate(&smooth(scenario), 9);
        let rates = trace.true_rate.unwrap();
        let deg_s = |i: usize| rates[i][2].to_degrees();
        assert!((0..999).all(|i| rates[i] == [0.0; 3]));
        let drilling = 1_300..rates.len();
        assert!(drilling.clone().all(|i| deg_s(i) > -1e-9 && deg_s(i) < 2.0 * 180.0 * 0.96));
        assert!(drilling.clone().any(|i| deg_s(i) < 30.0) && drilling.clone().any(|i| deg_s(i) > 330.0));
        let mean = drilling.clone().map(deg_s).sum::<f64>() / drilling.len() as f64;
        assert!((mean - 180.0).abs() < 2.0, "{mean}");
    }
}
