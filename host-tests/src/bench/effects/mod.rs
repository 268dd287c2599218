//! Does the diagnosis name what is there, and does it help? Simulated drilling with effects that nobody
//! declares to the pipeline.

pub(super) mod cases;
mod false_alarms;
mod observable;
mod sizes;
mod together;
pub(super) mod trial;

use meerkat_mwd::diagnosis::Verdict;

use super::worse::{MATTERS_DEG, is_worse};
use cases::{CASES, Case};
use testbed::study::{Cell, Effort, Table, median_and_worst, seeds::each_seed};
use trial::{DATA_S, Errors, HELD_OUT_S, Outcome, diagnose_and_score, drilled};

struct Trial {
    outcome: Outcome,
    errors: Errors,
    /// True if what was drawn can be seen and matters, if one effect should be named.
    observable: Option<bool>,
    /// Sizes that were drawn, if they can be compared with those that are found.
    drawn: Option<Vec<f64>>,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(20);
    let mut tables = Vec::new();
    for (inclination_deg, hole) in [(45.0, "45 deg"), (0.0, "vertical")] {
        let mut names = Table::new(
            format!(
                "Effects, one at a time and together, drilling at {hole}, {DATA_S} s, 100 Hz, {seeds} seeds, sizes and gyro errors drawn at random, the gyro's delay declared as 0: \
                 share of runs in which all of them are named, each by its own name or by one that cannot be told from it; in which another effect \
                 is named; and verdicts. Of observable: runs in which it is named, or unexplained where the library does not have it, of those in \
                 which what was drawn matters and is beyond the threshold by its Cramer-Rao bound (target: 95 %)"
            ),
            &["effect", "named %", "other names %", "unexplained %", "of observable", "sufficient %", "other names"],
        );
        let mut errors = Table::new(
            format!(
                "Errors of the same runs over the {HELD_OUT_S} s that follow, parameters and effects frozen, deg rms, median [worst]: rotation over \
                 2 s by the gyro alone, and attitude as flown, against the truth; runs in which the loop makes it worse by more than 5 % \
                 (target: none), and those of them in which by more than {MATTERS_DEG} deg"
            ),
            &[
                "effect",
                "rotation: bias only",
                "without the loop",
                "with it",
                "worse",
                "attitude: without the loop",
                "with it",
                "worse",
            ],
        );
        let mut sizes = sizes::table(hole);
        let mut all = [0; 2];
        for case in CASES {
            let trials = each_seed(0..seeds, |seed| {
                let scenario = drilled(inclination_deg, seed, case.add)?;
                let (outcome, errors, gyro) = diagnose_and_score(&scenario, seed, case.library())?;
                let (observable, drawn) = (case.is_observable(&scenario, seed), sizes::drawn(case, &scenario, &gyro));
                Ok(Trial { outcome, errors, observable, drawn })
            })?;
            if case.is_alone() {
                let [met, observable] = met_of_observable(case, &trials);
                all = [all[0] + met, all[1] + observable];
            }
            names.row(name_cells(case, &trials));
            errors.row(error_cells(case, &trials));
            if let Some(cells) = sizes::row(case, &trials) {
                sizes.row(cells);
            }
        }
        let of_all = format!("{} of {}", all[0], all[1]);
        names.row(["all of the library, alone", "", "", "", &of_all, "", ""]);
        tables.extend([names, errors, sizes]);
    }
    tables.push(false_alarms::table(effort)?);
    tables.extend(together::tables(effort)?);
    Ok(tables)
}

fn name_cells(case: &Case, trials: &[Trial]) -> Vec<Cell> {
    let share = |is: &dyn Fn(&Outcome) -> bool| {
        Cell::percent(trials.iter().filter(|trial| is(&trial.outcome)).count() as f64 / trials.len() as f64, 0)
    };
    let found = trials.iter().flat_map(|trial| &trial.outcome.names);
    let mut others: Vec<&str> = found.filter(|name| !case.allows(name)).copied().collect();
    others.sort_unstable();
    others.dedup();
    let [met, observable] = met_of_observable(case, trials);
    let is_told = trials.iter().any(|trial| trial.observable.is_some());
    let observable = if is_told { format!("{met} of {observable}") } else { String::new() };
    vec![
        case.name.into(),
        if case.effects.is_empty() { Cell::from("-") } else { share(&|outcome| case.is_named_by(&outcome.names)) },
        share(&|outcome| outcome.names.iter().any(|name| !case.allows(name))),
        share(&|outcome| outcome.verdict == Some(Verdict::UnexplainedResidual)),
        observable.into(),
        share(&|outcome| outcome.verdict == Some(Verdict::ModelSufficient)),
        others.join(" ").into(),
    ]
}

/// Number of runs with a right outcome among those whose effect can be seen and matters, and number of the
/// latter.
fn met_of_observable(case: &Case, trials: &[Trial]) -> [usize; 2] {
    let observable = || trials.iter().filter(|trial| trial.observable == Some(true));
    [observable().filter(|trial| case.is_met(&trial.outcome)).count(), observable().count()]
}

fn error_cells(case: &Case, trials: &[Trial]) -> Vec<Cell> {
    let figures = |of: fn(&Errors) -> f64| -> Vec<f64> { trials.iter().map(|trial| of(&trial.errors)).collect() };
    let cell = |of: fn(&Errors) -> f64| median_and_worst(&figures(of), 2);
    let worse = |of: fn(&Errors) -> [f64; 2]| {
        let by: Vec<f64> = trials
            .iter()
            .map(|trial| of(&trial.errors))
            .filter(is_worse)
            .map(|[without, with]| with - without)
            .collect();
        let matters = by.iter().filter(|by| **by > MATTERS_DEG).count();
        Cell { text: format!("{}, {matters}", by.len()), value: Some(by.len() as f64), ..Cell::default() }
    };
    vec![
        case.name.into(),
        cell(|errors| errors.bias_only),
        cell(|errors| errors.rotation[0]),
        cell(|errors| errors.rotation[1]),
        worse(|errors| errors.rotation),
        cell(|errors| errors.attitude[0]),
        cell(|errors| errors.attitude[1]),
        worse(|errors| errors.attitude),
    ]
}
