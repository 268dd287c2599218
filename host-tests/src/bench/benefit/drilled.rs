//! The benefit in simulated drilling: every window of runs in which identification never stops.

use anyhow::Context;
use meerkat_mwd::{
    compensation::GyroModel,
    identification::{Decision, WindowReport},
};

use super::{Effort, each_seed, largest, mean, middle, number};
use testbed::study::{Table, one_window::scenario, rms};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::{
        nees::{covariance, normalised, p_of},
        systematic_rate_error_rad_s,
    },
    simulate::{Scenario, simulate},
};

/// Scenario files, with the inclination of the hole where it is another, degrees, and a description.
const SCENARIOS: [(&str, Option<f64>, &str); 5] = [
    ("drilling_vertical", None, "vertical"),
    ("drilling_45deg", Some(20.0), "20 deg"),
    ("drilling_45deg", None, "45 deg"),
    ("drilling_45deg", Some(70.0), "70 deg"),
    ("real_drilling_30hz", None, "sensors as noisy as real ones, 30 Hz"),
];

/// Benefit of one window.
struct Window {
    is_first: bool,
    accepted: bool,
    flown_deg_s: f64,
    bias_only_deg_s: f64,
    nees: Option<f64>,
}

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.repetitions(24);
    let mut table = Table::new(
        format!(
            "Simulated drilling, {seeds} runs each, every window; systematic rate error over the whole run, deg/s, of a window 5 s after \
             its end. NEES / 9 of P against the \
             simulator's. The simulation's sensors flatter: they have no errors but those of the scenario"
        ),
        &[
            "drilling",
            "windows",
            "accepted",
            "bias only, median",
            "flown, rms, first windows",
            "later",
            "flown / bias only, worst",
            "NEES / 9, first windows, median",
            "later, median",
            "mean of all",
            "largest",
        ],
    );
    for (file, inclination_deg, name) in SCENARIOS {
        let mut scenario = scenario(file)?;
        scenario.hole.inclination_deg = inclination_deg.unwrap_or(scenario.hole.inclination_deg);
        let windows: Vec<Window> = each_seed(0..seeds, |seed| run(&scenario, seed))?.into_iter().flatten().collect();
        let flown = |first: bool| -> Vec<f64> {
            windows.iter().filter(|window| window.is_first == first).map(|window| window.flown_deg_s).collect()
        };
        let all = |of: &dyn Fn(&Window) -> Option<f64>| windows.iter().filter_map(of).collect::<Vec<f64>>();
        let nees = all(&|window| window.nees);
        table.row([
            name.into(),
            number(windows.len() as f64, 0),
            number(windows.iter().filter(|window| window.accepted).count() as f64, 0),
            number(middle(&all(&|window| Some(window.bias_only_deg_s))), 3),
            number(rms(&flown(true)), 3),
            number(rms(&flown(false)), 3),
            number(largest(&all(&|window| Some(window.flown_deg_s / window.bias_only_deg_s))), 3),
            number(middle(&all(&|window| window.nees.filter(|_| window.is_first))), 2),
            number(middle(&all(&|window| window.nees.filter(|_| !window.is_first))), 2),
            number(mean(&nees), 2),
            number(largest(&nees), 2),
        ]);
    }
    Ok(table)
}

fn run(scenario: &Scenario, seed: u64) -> anyhow::Result<Vec<Window>> {
    let (trace, truth) = simulate(scenario, seed);
    let mut config = of_trace(&trace);
    // Only the identification is measured.
    config.effects = false;
    let rates = trace.true_rate.as_deref().context("a simulated run knows its rate")?;
    let flight = fly(&config, &trace.samples, |_| {})?;
    let window = |(index, report): (usize, &WindowReport)| {
        let truth = truth.gyro_at(trace.samples.partition_point(|sample| sample.t_us < report.t_end_us));
        let error = |model: &GyroModel| {
            let error = systematic_rate_error_rad_s(&truth, model, rates).context("no rate to score over")?;
            anyhow::Ok(error.to_degrees())
        };
        anyhow::Ok(Window {
            is_first: index == 0,
            accepted: report.decision == Decision::Accepted,
            flown_deg_s: error(&report.flown)?,
            bias_only_deg_s: error(&report.bias_only)?,
            nees: normalised(report.fitted.p.as_flattened(), &covariance(report), &p_of(&truth)),
        })
    };
    flight.reports.iter().enumerate().map(window).collect()
}
