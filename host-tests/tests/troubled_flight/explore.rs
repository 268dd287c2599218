use crate::rig::*;
use mwd::simulate::Scenario;

#[test]
fn explore() {
    for period in [100, 500, 1_000, 2_500, 3_333, 3_500, 5_000, 5_800, 6_000, 7_000, 9_000, 10_000, 12_000, 13_334, 15_000, 16_667, 19_000, 20_000] {
        let mut line = String::new();
        let mut errs = Vec::new();
        for seed in 0..4 {
            let r = of_scenario(&Scenario { duration_s: 56.0, sample_period_us: period, ..scenario("drilling_45deg.toml") }, seed);
            let f = mwd::flight::fly(&r.config, &r.trace.samples, |_| {}).unwrap();
            sound(&f, r.trace.samples.len());
            let rep = &f.reports[0];
            let [b, fit, flown] = r.rate_errors_deg_s(rep);
            errs.push(flown);
            line += &format!(" [{b:.2} {fit:.3} {flown:.3} {} ev {} ov {}]", if accepted(rep) {"acc".into()} else {format!("{:?}", rep.decision)}, rep.evaluations, f.counters.overruns);
        }
        println!("{period}: {:.1} Hz {line}", 1e6 / f64::from(period));
    }
}
