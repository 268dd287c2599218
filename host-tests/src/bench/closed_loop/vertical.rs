//! Accelerometer bias and turned axes of the magnetometer in a vertical hole, which resemble each other there.

use anyhow::Context;
use meerkat_mwd::{
    Config,
    compensation::{
        Effect,
        effects::{AccelBias, LIBRARY, MagMisalignment},
    },
    diagnosis::DiagnosisReport,
};

use crate::bench::effects::trial::drilled;
use testbed::study::{Cell, Effort, Table, median, median_and_worst, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly},
    score::{
        nees::{covariance, normalised, p_of},
        systematic_rate_error_rad_s,
    },
    simulate::{Random, Scenario, simulate},
};

/// Length of a run, seconds.
const DURATION_S: f64 = 205.0;

/// The two errors.
const BOTH: [&dyn Effect; 2] = [&AccelBias, &MagMisalignment];

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 50_000;

type Case = (&'static str, fn(&mut Scenario, &mut Random));

const CASES: [Case; 3] = [
    ("accelerometer bias of 0.05 to 0.3 m/s^2", bias),
    ("magnetometer turned by 0.3 to 1.5 deg", turned),
    ("both", |scenario, random| {
        bias(scenario, random);
        turned(scenario, random);
    }),
];

fn bias(scenario: &mut Scenario, random: &mut Random) {
    let length = random.between(0.05, 0.3);
    scenario.effects.accel_bias_m_s2 = random.direction().map(|x| x * length);
}

fn turned(scenario: &mut Scenario, random: &mut Random) {
    let angle = random.between(0.3, 1.5).to_radians();
    let [x, y, z] = random.direction().map(|x| x * angle);
    scenario.effects.mag_matrix = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
}

struct Run {
    /// For each of the two: is it named, and is it named or told as an alias?
    named: [bool; 2],
    told: [bool; 2],
    nees: f64,
    error_deg_s: f64,
}

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.repetitions(20);
    let mut table = Table::new(
        format!(
            "A vertical hole, {DURATION_S} s, {seeds} runs: which of accelerometer bias and turned magnetometer is named; runs in which both are \
             told, by name or as an alias; P's squared error in its stated covariance over 9 (target: mean of 0.5 to 2); and the systematic rate \
             error, deg/s, median [worst]"
        ),
        &["error", "accel_bias named", "mag_misalignment named", "both told", "NEES / 9, mean", "median", "rate error"],
    );
    for (name, add) in CASES {
        let runs = each_seed(FIRST_SEED..FIRST_SEED + seeds, |seed| flown(seed, add))?;
        let count = |is: &dyn Fn(&Run) -> bool| Cell::number(runs.iter().filter(|run| is(run)).count() as f64, 0);
        let nees: Vec<f64> = runs.iter().map(|run| run.nees).collect();
        let errors: Vec<f64> = runs.iter().map(|run| run.error_deg_s).collect();
        table.row([
            Cell::from(name),
            count(&|run| run.named[0]),
            count(&|run| run.named[1]),
            count(&|run| run.told == [true; 2]),
            Cell::number(nees.iter().sum::<f64>() / nees.len() as f64, 2),
            Cell::number(median(&nees), 2),
            median_and_worst(&errors, 3),
        ]);
    }
    Ok(table)
}

fn flown(seed: u64, add: fn(&mut Scenario, &mut Random)) -> anyhow::Result<Run> {
    let scenario = Scenario { duration_s: DURATION_S, ..drilled(0.0, seed, add)? };
    let (trace, truth) = simulate(&scenario, seed);
    let config = Config { seed, ..of_trace(&trace) };
    let flight = fly(&config, &trace.samples, |_| {})?;
    let diagnosis = flight.diagnoses.iter().rev().find(|report| report.is_conclusive()).context("a diagnosis")?;
    let window = flight.reports.last().context("a window")?;
    let rates = trace.true_rate.as_deref().context("the true rate")?;
    let fitted = window.fitted.p.as_flattened();
    Ok(Run {
        named: BOTH.map(|effect| names(diagnosis, effect).0),
        told: BOTH.map(|effect| names(diagnosis, effect).1),
        nees: normalised(fitted, &covariance(window), &p_of(&truth.gyro)).context("a covariance")?,
        error_deg_s: systematic_rate_error_rad_s(&truth.gyro, &window.flown, rates).context("a rate")?.to_degrees(),
    })
}

/// True if an effect is named, and true if it is named or an alias of one that is.
fn names(report: &DiagnosisReport, own: &dyn Effect) -> (bool, bool) {
    let index = LIBRARY.iter().position(|effect| effect.name() == own.name());
    let is_own = |index: usize| report.found().any(|found| usize::from(found.found.index) == index);
    let is_rival = |index: usize| report.found().any(|found| found.rivals >> index & 1 == 1);
    index.map_or((false, false), |index| (is_own(index), is_own(index) || is_rival(index)))
}
