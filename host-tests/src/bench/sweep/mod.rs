//! Tools that are drawn whole, hole, motion, sensors and effects together: what a bench with a scenario of its own
//! keeps fixed hides what goes wrong elsewhere.

mod draw;
mod gate;

use meerkat_mwd::{Config, compensation::effects::LIBRARY, identification::Decision};

use super::{
    effects::trial::Outcome,
    honesty::seen::{Unflagged, unflagged},
    worse::{MATTERS_DEG, is_worse_by_what_matters},
};
use crate::import::plausible::checked;
use draw::{Drawn, draw};
use testbed::{
    flight::{Flight, configuration::of_trace, fly_with},
    score::{self, Reference},
    simulate::simulate,
    study::{Cell, Effort, Table, median_and_worst, seeds::each_seed},
};

/// Inclination below which a hole is called vertical, degrees.
const VERTICAL_BELOW_DEG: f64 = 5.0;

/// Start of a flight in which nothing is said of its attitude, and longest stretch that is let pass, seconds.
const FROM_S: f64 = 3.0;
const LET_PASS_S: f64 = 1.0;

/// One tool, flown.
struct Trial {
    drawn: Drawn,
    flown: Option<Flown>,
}

/// Outcome of a flight whose readings the gate lets in.
struct Flown {
    /// True if P of some window was accepted.
    accepted: bool,
    /// Names that are neither there nor look like what is.
    false_names: Vec<&'static str>,
    /// Rotation over 2 s, degrees rms: the factory's P and the bias, without the loop, with it.
    rotation_deg: [f64; 3],
    /// Attitude against the truth, degrees rms: without the loop, with it.
    attitude_deg: [f64; 2],
    /// Attitudes that no flag marks.
    unflagged: Unflagged,
}

impl Flown {
    fn is_harmed(&self) -> bool {
        let [bias_only, _, with] = self.rotation_deg;
        is_worse_by_what_matters(&[bias_only, with])
    }
    fn is_rotation_worse_by_loop(&self) -> bool {
        let [_, without, with] = self.rotation_deg;
        is_worse_by_what_matters(&[without, with])
    }
    fn is_attitude_worse_by_loop(&self) -> bool {
        is_worse_by_what_matters(&self.attitude_deg)
    }
    fn is_wrong_in_silence(&self) -> bool {
        self.unflagged.longest_s > LET_PASS_S
    }
}

fn trial(seed: u64) -> anyhow::Result<Trial> {
    let drawn = draw(seed);
    let (mut trace, _) = simulate(&drawn.scenario, seed);
    let mut config = Config { seed, ..of_trace(&trace) };
    if checked(&mut trace, &mut config, false).is_err() {
        return Ok(Trial { drawn, flown: None });
    }
    let scored = |config: &Config, flight: &Flight| -> Reference {
        score::score(&trace, flight, &score::Settings::of(&trace, config, flight)).unwrap_or_default()
    };
    let alone = Config { effects: false, ..config };
    let without = scored(&alone, &fly_with(&LIBRARY, &alone, None, &trace.samples)?);
    let flight = fly_with(&LIBRARY, &config, None, &trace.samples)?;
    let with = scored(&config, &flight);
    let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
    let names = Outcome::of(&flight, &LIBRARY).names;
    let flown = Flown {
        accepted: flight.reports.iter().any(|report| report.decision == Decision::Accepted),
        false_names: names.into_iter().filter(|name| !drawn.allows(name)).collect(),
        rotation_deg: [
            with.orientation_2s_rms_deg.bias_only,
            without.orientation_2s_rms_deg.with_effects,
            with.orientation_2s_rms_deg.with_effects,
        ]
        .map(number),
        attitude_deg: [without, with].map(|scores| number(scores.attitude_rms_deg.total)),
        unflagged: unflagged(&trace, &flight, FROM_S),
    };
    Ok(Trial { drawn, flown: Some(flown) })
}

/// A property with the word for it.
type Named<T> = (&'static str, fn(&T) -> bool);

/// Faults that a flight may have, by name.
const WRONG: [Named<Flown>; 5] = [
    ("named falsely", |flown| !flown.false_names.is_empty()),
    ("worse than bias only", Flown::is_harmed),
    ("rotation worse by the loop", Flown::is_rotation_worse_by_loop),
    ("attitude worse by the loop", Flown::is_attitude_worse_by_loop),
    ("wrong in silence", Flown::is_wrong_in_silence),
];

/// Tools that are told apart.
const KINDS: [Named<Drawn>; 9] = [
    ("all", |_| true),
    ("without an effect", |drawn| drawn.cases.is_empty()),
    ("with one", |drawn| drawn.cases.len() == 1),
    ("with two or three", |drawn| drawn.cases.len() > 1),
    ("vertical, below 5 deg", |drawn| drawn.scenario.hole.inclination_deg < VERTICAL_BELOW_DEG),
    ("steady rotation", |drawn| drawn.scenario.rotation.stick_slip == 0.0),
    ("full stick-slip", |drawn| drawn.scenario.rotation.stick_slip > 0.9),
    ("90 rpm and more", |drawn| drawn.scenario.rotation.mean_rpm >= 90.0),
    ("start in motion", |drawn| drawn.scenario.rest_s == 0.0),
];

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.seeds(300);
    let trials: Vec<(u64, Trial)> = seeds.clone().zip(each_seed(seeds, trial)?).collect();
    Ok(vec![by_kind(&trials), gate::table(effort)?, listed(&trials)])
}

fn by_kind(trials: &[(u64, Trial)]) -> Table {
    let mut table = Table::new(
        format!(
            "{} tools drawn whole: refused at the gate, though units and axes are right; P accepted; an effect named that is \
             neither there nor looks like one that is; rotation over 2 s worse than by bias only; rotation and attitude worse by \
             the loop; an angle beyond five stated deviations without a flag for over {LET_PASS_S:.0} s; worse: by a twentieth \
             and {MATTERS_DEG} deg; errors in deg rms, median [worst]",
            trials.len()
        ),
        &[
            "tools",
            "number",
            "refused",
            "P accepted",
            "named falsely",
            "worse than bias only",
            "rotation worse by the loop",
            "attitude worse by the loop",
            "wrong in silence",
            "rotation: bias only",
            "as flown",
            "attitude as flown",
        ],
    );
    for (name, is_of) in KINDS {
        let of: Vec<&Trial> = trials.iter().map(|(_, trial)| trial).filter(|trial| is_of(&trial.drawn)).collect();
        let flown: Vec<&Flown> = of.iter().filter_map(|trial| trial.flown.as_ref()).collect();
        let count = |is: &dyn Fn(&Flown) -> bool| {
            Cell::number(flown.iter().copied().filter(|flown| is(flown)).count() as f64, 0)
        };
        let error = |of: fn(&Flown) -> f64| {
            let errors: Vec<f64> = flown.iter().copied().map(of).filter(|error| error.is_finite()).collect();
            median_and_worst(&errors, 2)
        };
        let mut cells = vec![
            Cell::from(name),
            Cell::number(of.len() as f64, 0),
            Cell::number((of.len() - flown.len()) as f64, 0),
            count(&|flown| flown.accepted),
        ];
        cells.extend(WRONG.iter().map(|(_, is)| count(is)));
        cells.extend([
            error(|flown| flown.rotation_deg[0]),
            error(|flown| flown.rotation_deg[2]),
            error(|flown| flown.attitude_deg[1]),
        ]);
        table.row(cells);
    }
    table
}

/// The tools with which something went wrong.
fn listed(trials: &[(u64, Trial)]) -> Table {
    let mut table = Table::new(
        "The same tools, those with which something went wrong; `--first-seed N --seeds 1` flies one again",
        &[
            "seed",
            "tool",
            "wrong",
            "rotation: bias only",
            "without the loop",
            "with it",
            "attitude: without",
            "with it",
        ],
    );
    for (seed, trial) in trials {
        let Some(flown) = &trial.flown else {
            table.row([Cell::number(*seed as f64, 0), Cell::from(trial.drawn.told()), Cell::from("refused")]);
            continue;
        };
        let mut wrong: Vec<String> =
            WRONG.iter().filter(|(_, is)| is(flown)).map(|(name, _)| (*name).to_owned()).collect();
        if wrong.is_empty() {
            continue;
        }
        wrong.extend(flown.false_names.iter().map(ToString::to_string));
        if flown.is_wrong_in_silence() {
            let Unflagged { worst, longest_s, .. } = flown.unflagged;
            wrong.push(format!("{worst:.0} deviations, {longest_s:.0} s"));
        }
        let mut cells =
            vec![Cell::number(*seed as f64, 0), Cell::from(trial.drawn.told()), Cell::from(wrong.join(", "))];
        cells.extend(flown.rotation_deg.iter().chain(&flown.attitude_deg).map(|error| Cell::number(*error, 2)));
        table.row(cells);
    }
    table
}
