//! Harm by a turntable: its window shows few parameters, and the result is flown while drilling.

use anyhow::Context;
use meerkat_mwd::{
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};

use testbed::study::{
    Cell, Effort, Table, median_and_worst,
    one_window::{Run, WINDOW_S, scenario},
    seeds::each_seed,
};
use testbed::{
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, simulate},
};

/// Factor of the wider prior, to see what the prior is worth: nearly as wide as the configuration allows.
const WIDER: f32 = 10.0;

/// Length of the drilling on which the models are scored, seconds.
const DRILLED_S: f64 = 120.0;

/// Rests before the table turns, seconds; without one the bias must come from the turning too.
const RESTS_S: [f64; 2] = [10.0, 0.0];

/// Rate errors of one seed, deg/s, with the library's prior and with a wider one.
struct Trial {
    raw: f64,
    bias_only: [f64; 2],
    /// Error of the fit; `None` if nothing was fitted.
    fitted: [Option<f64>; 2],
    flown: [f64; 2],
    accepted: [bool; 2],
}

/// Picks a figure of a trial for one of the two priors.
type Figure = fn(&Trial, usize) -> Option<f64>;

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(200);
    let mut table = Table::new(
        format!(
            "Parameters from a 50 s window on the turntable (180 deg/s about z, 100 Hz), on the motion of drilling at 45 deg: systematic \
             rate error, deg/s, median [worst] of {seeds} seeds (target for flown: at most 0.45 [0.8])"
        ),
        &["", "prior", "prior 10 times wider", "no rest: prior", "prior 10 times wider"],
    );
    let both = [trials(RESTS_S[0], seeds)?, trials(RESTS_S[1], seeds)?];
    let columns = || both.iter().flat_map(|trials| [(trials, 0), (trials, 1)]);
    let rows: [(&str, Figure); 4] = [
        ("raw", |t, _| Some(t.raw)),
        ("bias only", |t, prior| Some(t.bias_only[prior])),
        (
            "fitted (the better of IMOA's answer and the least-squares point; refused windows are left out)",
            |t, prior| t.fitted[prior],
        ),
        ("flown", |t, prior| Some(t.flown[prior])),
    ];
    for (name, figure) in rows {
        let cells = columns().map(|(trials, prior)| {
            median_and_worst(&trials.iter().filter_map(|t| figure(t, prior)).collect::<Vec<_>>(), 3)
        });
        table.row([Cell::from(name)].into_iter().chain(cells));
    }
    let mut share = |name: &str, counts: fn(&Trial, usize) -> bool| {
        let cells = columns().map(|(trials, prior)| {
            Cell::percent(trials.iter().filter(|t| counts(t, prior)).count() as f64 / trials.len() as f64, 1)
        });
        table.row([Cell::from(name)].into_iter().chain(cells));
    };
    share("fitted, %", |t, prior| t.fitted[prior].is_some());
    share("accepted, %", |t, prior| t.accepted[prior]);
    Ok(vec![table])
}

fn trials(rest_s: f64, seeds: u64) -> anyhow::Result<Vec<Trial>> {
    let drilling = scenario("drilling_45deg")?;
    let table = Scenario {
        rest_s,
        duration_s: WINDOW_S + 6.0,
        sample_period_us: drilling.sample_period_us,
        oversampling: drilling.oversampling,
        ..scenario("turntable_30hz")?
    };
    let drilling = Scenario { duration_s: DRILLED_S, ..drilling };
    each_seed(0..seeds, |seed| {
        let run = Run::simulate(&table, seed)?;
        let (drilled, _) = simulate(&drilling, seed);
        let rates = drilled.true_rate.context("a simulated trace has true rates")?;
        let error = |model: &GyroModel| {
            systematic_rate_error_rad_s(&run.true_model(), model, &rates)
                .map(f64::to_degrees)
                .context("no rate to score over")
        };
        let mut wide = run.config;
        let id = &mut wide.identification;
        id.prior_sigma_diagonal *= WIDER;
        id.prior_sigma_off_diagonal *= WIDER;
        id.prior_sigma_bias_rad_s *= WIDER;
        let reports = [run.identify(OptimizerKind::Imoa)?, run.identify_as(&wide)?];
        let [with, without] = &reports;
        // Without a cost nothing was fitted.
        let fitted = |report: &WindowReport| report.cost_after.map(|_| error(&report.fitted)).transpose();
        Ok(Trial {
            raw: error(&GyroModel::IDENTITY)?,
            bias_only: [error(&with.bias_only)?, error(&without.bias_only)?],
            fitted: [fitted(with)?, fitted(without)?],
            flown: [error(&with.flown)?, error(&without.flown)?],
            accepted: reports.map(|report| report.decision == Decision::Accepted),
        })
    })
}
