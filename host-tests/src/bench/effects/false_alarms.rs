//! False alarms: how often an effect is named when there is none.

use meerkat_mwd::{compensation::effects::LIBRARY, diagnosis::Verdict};

use super::trial::{DATA_S, diagnose, drilled};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 10_000;

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let runs = effort.repetitions(100);
    let outcomes =
        each_seed(FIRST_SEED..FIRST_SEED + runs, |seed| diagnose(&drilled(45.0, seed, |_, _| {})?, seed, &LIBRARY))?;
    let count = |verdict: Verdict| {
        Cell::number(outcomes.iter().filter(|outcome| outcome.verdict == Some(verdict)).count() as f64, 0)
    };
    let mut names: Vec<&str> = outcomes.iter().flat_map(|outcome| &outcome.names).copied().collect();
    names.sort_unstable();
    let alarms = outcomes.iter().filter(|outcome| !outcome.names.is_empty()).count();
    let mut table = Table::new(
        format!(
            "False alarms: runs without any effect, drilling at 45 deg, {DATA_S} s (target: named in at most 3 of 100)"
        ),
        &["runs", "an effect is named", "unexplained", "sufficient", "named"],
    );
    table.row([
        Cell::number(runs as f64, 0),
        Cell::number(alarms as f64, 0),
        count(Verdict::UnexplainedResidual),
        count(Verdict::ModelSufficient),
        names.join(" ").into(),
    ]);
    Ok(table)
}
