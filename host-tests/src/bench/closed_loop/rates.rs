//! Rate error that each effect of the gyro leaves, with the loop and without it.

use anyhow::Context;
use meerkat_mwd::{Config, compensation::effects::LIBRARY};

use crate::bench::effects::{cases::CASES, trial::drilled};
use testbed::study::{Cell, Effort, Table, median_and_worst, rms, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly_with},
    simulate::{Scenario, simulate},
};

/// Ends of the part that is learnt from: a window of 50 s after the rest, with the latency of its result; and 205 s.
const LEARNT_S: [f64; 2] = [65.0, 205.0];

/// Length of the part that follows, with parameters and effects frozen, seconds.
const SCORED_S: f64 = 60.0;

/// Effects of the gyro, among the cases of the effects' bench.
const OF_GYRO: [&str; 9] = [
    "nothing",
    "g_sensitivity",
    "g_sensitivity, three times as large",
    "gyro_bias_temperature",
    "gyro_scale_temperature",
    "gyro_bias_step",
    "vibration_rectification",
    "gyro_scale_nonlinearity",
    "gyro_scale_asymmetry",
];

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 40_000;

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.repetitions(10);
    let [first_s, second_s] = LEARNT_S;
    let mut table = Table::new(
        format!(
            "Systematic rate error over the {SCORED_S} s that follow, parameters and effects frozen, without the gyro's noise, deg/s rms, median \
             [worst] of {seeds} runs: drilling at 45 deg with an effect of the gyro, learnt for {first_s} s (one window after the rest) and for \
             {second_s} s; and a vertical hole at 30 Hz"
        ),
        &["effect", "one window: without the loop", "with it", "205 s: without the loop", "with it"],
    );
    let mut row = |name: &str, drawn: &(dyn Fn(u64, f64) -> anyhow::Result<Scenario> + Sync)| -> anyhow::Result<()> {
        let mut cells = vec![Cell::from(name)];
        for learnt_s in LEARNT_S {
            let errors = each_seed(FIRST_SEED..FIRST_SEED + seeds, |seed| {
                errors_deg_s(&drawn(seed, learnt_s)?, seed, learnt_s)
            })?;
            for k in 0..2 {
                cells.push(median_and_worst(&errors.iter().map(|both| both[k]).collect::<Vec<_>>(), 3));
            }
        }
        table.row(cells);
        Ok(())
    };
    for name in OF_GYRO {
        let case = CASES.iter().find(|case| case.name == name).context(name)?;
        row(name, &|seed, learnt_s| {
            let whole = |scenario: &mut Scenario| scenario.duration_s = learnt_s + SCORED_S;
            drilled(45.0, seed, |scenario, random| {
                whole(scenario);
                (case.add)(scenario, random);
            })
        })?;
    }
    row("nothing, vertical, 30 Hz", &|seed, learnt_s| {
        drilled(0.0, seed, |scenario, _| {
            (scenario.duration_s, scenario.sample_period_us) = (learnt_s + SCORED_S, 33_333);
        })
    })?;
    Ok(table)
}

/// Without the loop, and with it.
fn errors_deg_s(scenario: &Scenario, seed: u64, learnt_s: f64) -> anyhow::Result<[f64; 2]> {
    let (mut trace, _) = simulate(scenario, seed);
    let freeze_us = trace.first_us() + (learnt_s * 1e6) as u64;
    let config = Config { seed, ..of_trace(&trace) };
    // The same run of a gyro without noise: its readings are what is scored.
    let mut quiet = scenario.clone();
    quiet.gyro.noise_deg_s_rthz = 0.0;
    let (silent, _) = simulate(&quiet, seed);
    for (sample, silent) in trace.samples.iter_mut().zip(&silent.samples).filter(|(s, _)| s.t_us >= freeze_us) {
        sample.gyro_rad_s = silent.gyro_rad_s;
    }
    let truth = trace.true_rate.as_deref().context("the true rate")?;
    let error = |effects: bool| -> anyhow::Result<f64> {
        let flight = fly_with(&LIBRARY, &Config { effects, ..config }, Some(freeze_us), &trace.samples)?;
        let pairs = flight.outputs.iter().zip(truth).filter(|(output, _)| output.t_us >= freeze_us);
        let off: Vec<f64> = pairs
            .flat_map(|(output, truth)| {
                output.rate_rad_s.into_iter().zip(*truth).map(|(flown, truth)| f64::from(flown) - truth)
            })
            .collect();
        Ok(rms(&off).to_degrees())
    };
    Ok([error(false)?, error(true)?])
}
