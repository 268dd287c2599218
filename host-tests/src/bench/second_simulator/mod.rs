//! Effects that are named in the traces of a second simulator, and the benefit of naming them there.

pub(super) mod blind;
mod cases;

use super::effects::{
    cases::is_of_vectors,
    trial::{Outcome, attitude_error_deg},
};
use super::worse::{MATTERS_DEG, is_worse_by_what_matters};
use crate::second_simulator::{Added, Plan, simulate};
use cases::{CASES, Case};
use meerkat_mwd::{Config, compensation::effects::LIBRARY, diagnosis::Verdict};
use testbed::study::{Cell, Effort, Table, median_and_worst, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly_with},
    simulate::Random,
    trace::Trace,
};

/// Length of a run, and from where its attitude is scored, seconds.
const DURATION_S: f64 = 180.0;
const SCORED_FROM_S: f64 = 120.0;

struct Trial {
    outcome: Outcome,
    /// Without effects, with them.
    attitude_deg: [f64; 2],
}

/// The run of a case and a seed.
fn drawn(case: &Case, seed: u64) -> (Trace, Config) {
    let (plan, added) = planned(case, seed);
    let mut trace = simulate(&plan, &added, seed);
    let scored_us = trace.first_us() + (SCORED_FROM_S * 1e6) as u64;
    trace.movement = Some(trace.samples.iter().map(|sample| sample.t_us >= scored_us).collect());
    let config = Config { seed, ..of_trace(&trace) };
    (trace, config)
}

fn planned(case: &Case, seed: u64) -> (Plan, Added) {
    let mut plan = Plan {
        duration_s: DURATION_S,
        inclination_deg: [15.0, 75.0],
        reverses: false,
        temperature: None,
        shock_s: None,
    };
    let mut random = Random::new(seed ^ 0xca5e);
    let mut added = Added { low_pass: random.uniform() < 0.5, ..Added::default() };
    (case.add)(&mut plan, &mut added, &mut random);
    (plan, added)
}

/// Outcome of the loop in a run.
fn outcome(case: &Case, seed: u64) -> anyhow::Result<Outcome> {
    let (trace, config) = drawn(case, seed);
    Ok(Outcome::of(&fly_with(&LIBRARY, &config, None, &trace.samples)?, &LIBRARY))
}

fn trial(case: &Case, seed: u64) -> anyhow::Result<Trial> {
    let (trace, config) = drawn(case, seed);
    let without = fly_with(&LIBRARY, &Config { effects: false, ..config }, None, &trace.samples)?;
    let with = fly_with(&LIBRARY, &config, None, &trace.samples)?;
    let attitude_deg = [&without, &with].map(|flight| attitude_error_deg(&trace, &config, flight));
    Ok(Trial { outcome: Outcome::of(&with, &LIBRARY), attitude_deg })
}

impl Trial {
    fn is_named(&self, case: &Case) -> bool {
        self.outcome.names.iter().any(|name| case.names.contains(name))
    }

    /// Names other than the case's: of errors that are there in every run, or of ones that are not there.
    fn others(&self, case: &Case, are_there: bool) -> Vec<&'static str> {
        let is_other = |name: &&str| !case.names.contains(name) && is_of_vectors(name) == are_there;
        self.outcome.names.iter().copied().filter(is_other).collect()
    }

    /// Returns true if the loop makes the attitude clearly worse, and by an amount that matters.
    fn is_harmed(&self) -> bool {
        is_worse_by_what_matters(&self.attitude_deg)
    }
}

/// Prints the table.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(20);
    let mut table = Table::new(
        format!(
            "Runs of {DURATION_S} s of a second simulator, {seeds} seeds, sizes drawn at random: those in which the effect that was added is \
             named, by its own name or by one that cannot be told from it; in which an error of a vector sensor is, of which every run has one \
             within its data sheet; in which one is that is not there; verdicts; and attitude as flown over the last minute, deg rms, median \
             [worst]; runs in which the loop makes it worse by {MATTERS_DEG} deg"
        ),
        &[
            "added",
            "named",
            "within data sheets",
            "false",
            "unexplained",
            "without the loop",
            "with it",
            "worse",
            "false names",
        ],
    );
    for case in &CASES {
        let trials = each_seed(0..seeds, |seed| trial(case, seed))?;
        let count =
            |is: &dyn Fn(&Trial) -> bool| Cell::number(trials.iter().filter(|trial| is(trial)).count() as f64, 0);
        let attitude = |k: usize| {
            let errors: Vec<f64> = trials.iter().map(|trial| trial.attitude_deg[k]).collect();
            median_and_worst(&errors, 2)
        };
        let mut named: Vec<&str> = trials.iter().flat_map(|trial| trial.others(case, false)).collect();
        named.sort_unstable();
        named.dedup();
        table.row([
            Cell::from(case.name),
            if case.names.is_empty() { Cell::from("-") } else { count(&|trial| trial.is_named(case)) },
            count(&|trial| !trial.others(case, true).is_empty()),
            count(&|trial| !trial.others(case, false).is_empty()),
            count(&|trial| trial.outcome.verdict == Some(Verdict::UnexplainedResidual)),
            attitude(0),
            attitude(1),
            count(&Trial::is_harmed),
            Cell::from(named.join(" ")),
        ]);
    }
    Ok(vec![table])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{super::worse::CLEARLY, *};
    use testbed::study::median;

    fn trials(name: &str) -> Vec<Trial> {
        let case = CASES.iter().find(|case| case.name == name).unwrap();
        (40..46).map(|seed| trial(case, seed).unwrap()).collect()
    }

    /// Sensors within their data sheets: what is named of them is small, and what of it does not show is not made up.
    #[test]
    fn errors_within_data_sheets_are_taken_out_without_harm() {
        let case = &CASES[0];
        for trial in trials("nothing") {
            assert!(trial.others(case, false).is_empty(), "{:?}", trial.outcome.names);
            let [without, with] = trial.attitude_deg;
            assert!(with < CLEARLY * without + 0.05, "{without} {with}");
        }
    }

    /// No motion of a straight hole shows a field along the tool; the declared field of the earth does.
    #[test]
    fn an_axial_field_is_found_from_the_declared_field() {
        let trials = trials("axial_interference");
        let ratios: Vec<f64> = trials.iter().map(|trial| trial.attitude_deg[1] / trial.attitude_deg[0]).collect();
        assert!(trials.iter().all(|trial| !trial.is_harmed()), "{ratios:?}");
        assert!(median(&ratios) < 0.3, "{ratios:?}");
    }
}
