//! Sets of traces as a stranger would send them: one of each effect and one without, of this simulator and seeds that
//! nothing else uses.

use meerkat_mwd::diagnosis::Verdict;

use super::{Case, Trial, cases::CASES, outcome};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};

/// First seed.
const FIRST_SEED: u64 = 5_000;

pub(in crate::bench) fn table(effort: Effort) -> anyhow::Result<Table> {
    let sets = effort.repetitions(5);
    let cases: Vec<&Case> = CASES.iter().filter(|case| !case.names.is_empty() || case.name == "nothing").collect();
    let count = cases.len();
    let of = |index: usize| cases[index % count];
    let trials = each_seed(0..sets * count as u64, |index| {
        let outcome = outcome(of(index as usize), FIRST_SEED + index)?;
        Ok(Trial { outcome, attitude_deg: [f64::NAN; 2] })
    })?;
    let mut table = Table::new(
        format!(
            "{sets} sets of {count} blind traces of the second simulator, one of each effect and one without: right name or rightly none (target: \
             17 of 18, none false)"
        ),
        &["set", "right", "false", "what was there and what was named, where it is not right"],
    );
    for (set, trials) in trials.chunks(count).enumerate() {
        let is_false = |index: usize, trial: &Trial| !trial.others(of(index), false).is_empty();
        let is_right = |index: usize, trial: &Trial| {
            let of = of(index);
            let is_told = of.names.is_empty() || trial.is_named(of);
            is_told && !is_false(index, trial)
        };
        let number = |is: &dyn Fn(usize, &Trial) -> bool| {
            Cell::number(trials.iter().enumerate().filter(|(index, trial)| is(*index, trial)).count() as f64, 0)
        };
        let wrong = trials.iter().enumerate().filter(|(index, trial)| !is_right(*index, trial));
        let wrong: Vec<String> = wrong
            .map(|(index, trial)| {
                let unexplained = trial.outcome.verdict == Some(Verdict::UnexplainedResidual);
                let verdict = if unexplained { ", unexplained" } else { "" };
                let named = match trial.outcome.names.as_slice() {
                    [] => "nothing".to_owned(),
                    names => names.join(" "),
                };
                format!("{}: {named}{verdict}", of(index).name)
            })
            .collect();
        table.row([
            Cell::number((set + 1) as f64, 0),
            number(&is_right),
            number(&is_false),
            Cell::from(wrong.join("; ")),
        ]);
    }
    Ok(table)
}
