//! Does the diagnosis name what is there? Simulated drilling with effects that nobody declares to the pipeline.

use meerkat_mwd::{
    Config,
    compensation::effects::LIBRARY,
    diagnosis::{DiagnosisReport, Verdict},
};

use super::{
    Effort,
    effect_cases::{CASES, Case},
    one_window::scenario,
    seeds::each_seed,
    table::{Cell, Table},
};
use crate::{
    configuration::of_trace,
    flight::fly,
    simulate::{Random, Scenario, simulate},
};

/// Data of one run, seconds.
const DURATION_S: f64 = 120.0;

/// What came of one run.
struct Trial {
    /// Names found, in the order in which they were chosen.
    names: Vec<&'static str>,
    verdict: Option<Verdict>,
}

pub(super) fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(20);
    let mut tables = Vec::new();
    for (inclination_deg, hole) in [(45.0, "45 deg"), (0.0, "vertical")] {
        let mut table = Table::new(
            format!(
                "Effects, one at a time and together, drilling at {hole}, {DURATION_S} s, 100 Hz, {seeds} seeds, sizes and gyro errors drawn at random: \
                 share of runs in which all of them are named, each by its own name or by one that cannot be told from it; in which another effect \
                 is named; and verdicts"
            ),
            &["effect", "named %", "other names %", "unexplained %", "sufficient %", "other names"],
        );
        for case in CASES {
            let trials = each_seed(0..seeds, |seed| trial(case, inclination_deg, seed))?;
            table.row(row(case, &trials));
        }
        tables.push(table);
    }
    Ok(tables)
}

fn trial(case: &Case, inclination_deg: f64, seed: u64) -> anyhow::Result<Trial> {
    let mut drilled = Scenario { duration_s: DURATION_S, ..scenario("drilling_45deg")? };
    drilled.hole.inclination_deg = inclination_deg;
    (case.add)(&mut drilled, &mut Random::new(seed ^ 0x5eed));
    let (trace, _) = simulate(&drilled, seed);
    let config = Config { seed, ..of_trace(&trace) };
    let flight = fly(&config, &trace.samples, |_| {})?;
    let last = flight.diagnoses.iter().rev().find(|report| report.is_conclusive());
    Ok(Trial { names: last.map(names).unwrap_or_default(), verdict: last.map(|report| report.verdict) })
}

fn names(report: &DiagnosisReport) -> Vec<&'static str> {
    let found = report.effects.iter().take(report.count.into());
    found.filter_map(|effect| LIBRARY.get(usize::from(effect.found.index))).map(|effect| effect.name()).collect()
}

fn row(case: &Case, trials: &[Trial]) -> Vec<Cell> {
    let share = |is: &dyn Fn(&Trial) -> bool| {
        Cell::percent(trials.iter().filter(|trial| is(trial)).count() as f64 / trials.len() as f64, 0)
    };
    let right = |name: &&str| case.names.iter().any(|names| names.contains(name));
    let all = |trial: &Trial| case.names.iter().all(|names| trial.names.iter().any(|name| names.contains(name)));
    let mut others: Vec<&str> =
        trials.iter().flat_map(|trial| &trial.names).filter(|name| !right(name)).copied().collect();
    others.sort_unstable();
    others.dedup();
    vec![
        case.name.into(),
        if case.names.is_empty() { Cell::from("-") } else { share(&all) },
        share(&|trial| trial.names.iter().any(|name| !right(name))),
        share(&|trial| trial.verdict == Some(Verdict::UnexplainedResidual)),
        share(&|trial| trial.verdict == Some(Verdict::ModelSufficient)),
        others.join(" ").into(),
    ]
}
