//! Harm and missed benefit of what flies: random faults and effects, one window, the six minutes after it.

use meerkat_mwd::{
    Config,
    compensation::GyroModel,
    identification::{Decision, Refusal},
};

use super::{
    faults::{CLASSES, draw},
    rotation_error::rotation_error_deg,
};
use testbed::study::{Cell, Effort, Table, one_window::Run, seeds::each_seed};

/// Ratio of errors that counts as a clear difference.
const CLEARLY: f64 = 1.1;

/// Measures of a model on the six minutes after the window, one a table.
const MEASURES: [&str; 2] = ["rotation over each second, readings as they are", "systematic rate"];

/// Errors of one model in the order of [`MEASURES`].
type Errors = [f64; MEASURES.len()];

/// Errors of the models of one window.
struct Trial {
    classes: [bool; CLASSES.len()],
    decision: Decision,
    swapped: bool,
    /// Errors of the model that flew before, of bias only, of what flies now, and of the fit.
    before: Errors,
    bias_only: Errors,
    flown: Errors,
    fitted: Option<Errors>,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.repetitions(500);
    let trials = each_seed(0..seeds, trial)?;
    let mut tables: Vec<Table> =
        MEASURES.iter().enumerate().map(|(index, name)| by_class(&trials, index, name)).collect();
    tables.push(by_reason(&trials));
    Ok(tables)
}

fn trial(seed: u64) -> anyhow::Result<Trial> {
    let drawn = draw(seed);
    let run = Run::simulate(&drawn.scenario, seed)?;
    // The whole loop, as it flies.
    let report = run.identify_as(&Config { effects: true, ..run.config })?;
    let before = run.config.gyro;
    let errors = |model: &GyroModel| -> anyhow::Result<Errors> {
        Ok([rotation_error_deg(&run, model), run.rate_error_deg_s(model)?])
    };
    Ok(Trial {
        classes: drawn.classes,
        decision: report.decision,
        swapped: report.flown != before,
        before: errors(&before)?,
        bias_only: errors(&report.bias_only)?,
        flown: errors(&report.flown)?,
        // An overrun has no fit.
        fitted: report.t_effect_us.map(|_| errors(&report.fitted)).transpose()?,
    })
}

fn by_class(trials: &[Trial], measure: usize, name: &str) -> Table {
    let mut table = Table::new(
        format!(
            "What flies under random faults and effects, {} windows: {name}, over the next six minutes, \
             errors more than 10 % apart; count of how many, and % (targets: harmful under 1, missed under 5)",
            trials.len()
        ),
        &[
            "runs with",
            "windows",
            "swaps worse than what flew before",
            "P accepted, worse than bias only",
            "P refused, though the fit was better than what flies",
        ],
    );
    let all = [("all", trials.iter().collect::<Vec<_>>())];
    let classes = CLASSES.iter().enumerate().map(|(class, name)| {
        let of_class = trials.iter().filter(|trial| trial.classes.get(class) == Some(&true)).collect();
        (*name, of_class)
    });
    for (name, trials) in all.into_iter().chain(classes) {
        let worse = |a: &Errors, b: &Errors| a[measure] > CLEARLY * b[measure];
        let cells = [
            share(&trials, |t| t.swapped, |t| worse(&t.flown, &t.before)),
            share(&trials, Trial::accepted, |t| worse(&t.flown, &t.bias_only)),
            share(&trials, |t| !t.accepted(), |t| t.missed(measure)),
        ];
        let count = Cell { value: Some(trials.len() as f64), ..Cell::from(trials.len().to_string()) };
        table.row([Cell::from(name), count].into_iter().chain(cells));
    }
    table
}

/// Reasons of refusal, and how often each was wrong.
fn by_reason(trials: &[Trial]) -> Table {
    let mut table = Table::new(
        "Why P was refused in the same windows, and in how many of these the fit was better, by the rotation over each second",
        &["reason", "windows", "though the fit was better than what flies"],
    );
    let refused: Vec<(&str, &Trial)> = trials.iter().filter_map(|t| Some((t.reason()?, t))).collect();
    let mut reasons: Vec<&str> = refused.iter().map(|(reason, _)| *reason).collect();
    reasons.sort_unstable();
    reasons.dedup();
    for reason in reasons {
        let for_it: Vec<&Trial> = refused.iter().filter(|(why, _)| *why == reason).map(|(_, trial)| *trial).collect();
        let count = Cell { value: Some(for_it.len() as f64), ..Cell::from(for_it.len().to_string()) };
        table.row([Cell::from(reason), count, share(&for_it, |_| true, |t| t.missed(0))]);
    }
    table
}

impl Trial {
    fn accepted(&self) -> bool {
        self.decision == Decision::Accepted
    }

    /// Returns true if the fit would have been clearly better than what flies.
    fn missed(&self, measure: usize) -> bool {
        self.fitted.as_ref().is_some_and(|fitted| self.flown[measure] > CLEARLY * fitted[measure])
    }

    fn reason(&self) -> Option<&'static str> {
        let Decision::Refused(refusal) = self.decision else { return None };
        Some(match refusal {
            Refusal::NotEnoughMotion { .. } => "not enough motion",
            Refusal::Overrun => "not ready in time",
            Refusal::NoAccelerometer => "no accelerometer",
            Refusal::GyroUnusable { .. } => "gyro unusable",
            Refusal::Diverged { .. } => "diverged",
            Refusal::MagnetometerUncalibrated { .. } => "magnetometer uncalibrated",
            Refusal::NoMagnetometer { .. } => "no magnetometer",
            Refusal::Implausible { .. } => "implausible",
            Refusal::WrongMounting { .. } => "wrong mounting",
            _ => "other",
        })
    }
}

/// Share, among the trials that count, of those that are `found`.
fn share(trials: &[&Trial], counts: impl Fn(&Trial) -> bool, found: impl Fn(&Trial) -> bool) -> Cell {
    let of = trials.iter().filter(|trial| counts(trial)).count();
    let number = trials.iter().filter(|trial| counts(trial) && found(trial)).count();
    let percent = 100.0 * number as f64 / of as f64;
    Cell { text: format!("{number} of {of} ({})", Cell::number(percent, 1).text), ..Cell::number(percent, 1) }
}
