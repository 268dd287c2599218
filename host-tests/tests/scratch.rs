#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]
use meerkat_mwd::{compensation::GyroModel, config::OptimizerKind};
use mwd::{
    configuration::of_trace,
    flight::fly,
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, simulate},
};
use std::path::Path;
fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2]
}
#[test]
fn scratch() {
    for name in ["drilling_vertical.toml", "drilling_45deg.toml"] {
        let mut scenario = Scenario::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)).unwrap();
        scenario.duration_s = 200.0;
        if std::env::var("NOWALK").is_ok() {
            scenario.gyro.bias_walk_deg_s_rts = 0.0;
        }
        for opt in [OptimizerKind::Ls, OptimizerKind::Lm, OptimizerKind::Imoa] {
            let mut e: Vec<Vec<f64>> = vec![vec![]; 4];
            let mut rank = 0.0;
            let mut acc = 0;
            for seed in 0..20 {
                let (trace, truth) = simulate(&scenario, seed);
                let mut config = of_trace(&trace);
                config.identification.optimizer = opt;
                config.freeze_at_us = Some(trace.first_us() + 56_000_000);
                let flight = fly(&config, &trace.samples, |_| {}).unwrap();
                let r = flight.reports[0];
                let from = trace.samples.partition_point(|s| s.t_us < config.freeze_at_us.unwrap());
                let rates = &trace.true_rate.as_ref().unwrap()[from..];
                for (k, m) in [GyroModel::IDENTITY, r.bias_only, r.fitted, r.flown].iter().enumerate() {
                    e[k].push(systematic_rate_error_rad_s(&truth.gyro, m, rates).unwrap().to_degrees());
                }
                rank += f64::from(r.rank) / 20.0;
                acc += i32::from(r.decision == meerkat_mwd::identification::Decision::Accepted);
            }
            println!(
                "{name} {opt:?} raw {:.3} bias {:.3} fitted {:.4} flown {:.4} rank {rank} accepted {acc}",
                median(e[0].clone()),
                median(e[1].clone()),
                median(e[2].clone()),
                median(e[3].clone())
            );
        }
    }
}
