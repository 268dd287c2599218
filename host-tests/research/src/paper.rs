//! The experiments of the paper as scenarios, beside what it prints (its Tables 1 to 3).

use anyhow::Context;
use meerkat_mwd::Config;

use super::{
    contenders::{Contenders, NAMES, TRUE},
    pure_integration::Drift,
};
use testbed::{
    simulate::Scenario,
    study::{
        Cell, Effort, Table,
        cramer_rao::Vibration,
        median_and_lowest, median_and_worst,
        one_window::{Run, scenario},
        rms,
        seeds::each_seed,
    },
};

/// Table 1: turntable SNR in dB and RMSE, simulated drilling SNR and RMSE.
const PRINTED_RATES: [(&str, [f64; 4]); 4] = [
    ("raw data", [41.2, 4.6, 37.4, 4.9]),
    ("PSO", [49.1, 2.9, 42.6, 3.1]),
    ("MOA", [57.3, 1.4, 50.3, 1.5]),
    ("IMOA", [69.3, 0.8, 58.5, 1.1]),
];

/// Table 2: RMSE of the vertical hole. Table 3: RMSE and SD at 30, 45 and 60 deg.
const PRINTED_INCLINATIONS: [(&str, [f64; 7]); 4] = [
    ("raw", [5.3, 4.8, 4.2, 5.2, 4.4, 3.9, 3.4]),
    ("PSO", [4.6, 3.2, 3.1, 4.1, 3.2, 2.8, 2.1]),
    ("MOA", [3.3, 2.3, 1.7, 2.4, 1.9, 1.4, 0.9]),
    ("IMOA", [1.2, 1.1, 0.9, 1.2, 1.0, 0.6, 0.4]),
];

/// Inclinations of Tables 2 and 3, deg.
const INCLINATIONS_DEG: [f64; 4] = [0.0, 30.0, 45.0, 60.0];

/// Paper's rate and the one that we advise: period in microseconds, steps of the truth in it, name.
const RATES: [(u32, u32, &str); 2] = [(33_333, 12, "30 Hz, as the paper"), (5_000, 2, "200 Hz, as we advise")];

/// The paper's Tables 1 to 3, at its rate and at ours.
///
/// # Errors
/// A scenario cannot be read or flown.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let mut tables = Vec::new();
    for (period_us, oversampling, name) in RATES {
        let sampled = |file: &str| -> anyhow::Result<Scenario> {
            Ok(Scenario { sample_period_us: period_us, oversampling, ..scenario(file)? })
        };
        let seeds = effort.repetitions(20);
        let rates = [sampled("turntable_30hz")?, sampled("simulated_drilling_30hz")?];
        tables.push(rate_table(&rates, seeds, name)?);
        tables.push(inclination_table(&sampled("real_drilling_30hz")?, effort.repetitions(20), name)?);
    }
    Ok(tables)
}

/// SNR in dB and RMSE in deg/s of one seed, in the order of [`NAMES`] but with the bound in its last place.
struct RateTrial {
    accepted: bool,
    snr_db: Vec<f64>,
    rmse_deg_s: Vec<f64>,
}

fn rate_table(scenarios: &[Scenario; 2], seeds: u64, sampling: &str) -> anyhow::Result<Table> {
    let evaluations = Config::default().identification.max_evaluations;
    let mut table = Table::new(
        format!(
            "The paper's Table 1 at {sampling}: rate after one 50 s window, over the rest of 5,000 / 30 Hz = 167 s; RMSE over axes, deg/s, \
             without sensor noise, of the better of each search's answer and the least-squares point about which all search with {evaluations} \
             evaluations, and of that point where the window is refused; SNR = 10 log10(power of the true rate / power of its error), dB; median [worst] of {seeds} seeds"
        ),
        &["", "turntable SNR", "turntable RMSE", "simulated drilling SNR", "simulated drilling RMSE"],
    );
    let mut all = Vec::new();
    for scenario in scenarios {
        all.push(each_seed(0..seeds, |seed| rate_trial(&Run::simulate(scenario, seed)?, seed))?);
    }
    for (name, figures) in PRINTED_RATES {
        let cells = figures.iter().map(|&x| Cell::number(x, 1));
        table.row([Cell::from(format!("printed in the paper: {name}"))].into_iter().chain(cells));
    }
    for (index, name) in NAMES.iter().enumerate().filter(|&(index, _)| index != TRUE) {
        let column = |trials: &[RateTrial], figures: fn(&RateTrial) -> &Vec<f64>| -> Vec<f64> {
            trials.iter().filter_map(|trial| figures(trial).get(index).copied()).collect()
        };
        let cells = all.iter().flat_map(|trials| {
            [
                median_and_lowest(&column(trials, |t| &t.snr_db), 1),
                median_and_worst(&column(trials, |t| &t.rmse_deg_s), 4),
            ]
        });
        let name = if index == NAMES.len() - 1 { "Cramer-Rao bound" } else { name };
        table.row([Cell::from(name)].into_iter().chain(cells));
    }
    let refused = all.iter().flat_map(|trials| {
        let refused = trials.iter().filter(|trial| !trial.accepted).count();
        [Cell::from(""), Cell { value: Some(refused as f64), ..Cell::from(format!("{refused} of {seeds}")) }]
    });
    table.row([Cell::from("P refused (bias only flies)")].into_iter().chain(refused));
    Ok(table)
}

fn rate_trial(run: &Run, seed: u64) -> anyhow::Result<RateTrial> {
    let contenders = Contenders::of(run, seed)?;
    let mut rmse_deg_s = Vec::new();
    for model in &contenders.models {
        rmse_deg_s.push(run.rate_error_deg_s(model)?);
    }
    if let Some(last) = rmse_deg_s.last_mut() {
        *last = run.bound_deg_s(Vibration::Coloured);
    }
    let rates: Vec<f64> = run.rates_ahead().iter().flatten().copied().collect();
    let signal_deg_s = rms(&rates).to_degrees();
    let snr_db = rmse_deg_s.iter().map(|error| 20.0 * (signal_deg_s / error).log10()).collect();
    Ok(RateTrial { accepted: contenders.accepted, snr_db, rmse_deg_s })
}

fn inclination_table(scenario: &Scenario, seeds: u64, sampling: &str) -> anyhow::Result<Table> {
    let mut table = Table::new(
        format!(
            "The paper's Tables 2 and 3 at {sampling}: inclination every 30 s of six minutes of the gyro alone, RMSE and standard deviation \
             of its error, deg; median [worst] of {seeds} seeds"
        ),
        &["", "vertical RMSE", "30 deg RMSE", "30 deg SD", "45 deg RMSE", "45 deg SD", "60 deg RMSE", "60 deg SD"],
    );
    let mut all = Vec::new();
    for inclination_deg in INCLINATIONS_DEG {
        let mut scenario = scenario.clone();
        scenario.hole.inclination_deg = inclination_deg;
        all.push(each_seed(0..seeds, |seed| {
            let run = Run::simulate(&scenario, seed)?;
            let drift = |model| Drift::of(&run, model).context("the run is shorter than six minutes");
            Contenders::of(&run, seed)?.models.iter().map(drift).collect::<anyhow::Result<Vec<_>>>()
        })?);
    }
    for (name, figures) in PRINTED_INCLINATIONS {
        let cells = figures.iter().map(|&x| Cell::number(x, 1));
        table.row([Cell::from(format!("printed in the paper: {name}"))].into_iter().chain(cells));
    }
    for (index, name) in NAMES.iter().enumerate() {
        let cells = all.iter().enumerate().flat_map(|(hole, trials)| {
            let figure = |f: fn(&[f64]) -> f64| -> Vec<f64> {
                trials.iter().filter_map(|drifts| drifts.get(index)).map(|drift| f(&drift.inclination_deg)).collect()
            };
            let rmse = median_and_worst(&figure(rms), 2);
            // The paper's Table 2 has no SD.
            let sd = (hole > 0).then(|| median_and_worst(&figure(standard_deviation), 2));
            std::iter::once(rmse).chain(sd)
        });
        table.row([Cell::from(*name)].into_iter().chain(cells));
    }
    Ok(table)
}

fn standard_deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms(&values.iter().map(|x| x - mean).collect::<Vec<_>>())
}
