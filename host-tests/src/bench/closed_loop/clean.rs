//! Names that are given where there is no effect: in clean drilling over a grid of holes and speeds, and for the gyro
//! of recordings.

use std::path::Path;

use anyhow::Context;
use meerkat_mwd::{
    Config,
    compensation::{Sensor, effects::LIBRARY},
    diagnosis::Verdict,
};

use crate::bench::effects::trial::{DATA_S, Outcome, diagnose, drilled};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};
use testbed::{
    flight::{configuration::of_trace, fly},
    trace::{
        Trace,
        recordings::{FOLDER, bundled, given, name},
    },
};

const INCLINATIONS_DEG: [f64; 4] = [0.0, 15.0, 45.0, 70.0];
const SPEEDS_RPM: [f64; 4] = [30.0, 60.0, 120.0, 180.0];

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 30_000;

/// Place in the grid of a run: the speed changes first.
fn drawn(run: u64) -> (f64, f64) {
    let of = |all: [f64; 4], index: u64| all[(index % 4) as usize];
    (of(INCLINATIONS_DEG, run / 4), of(SPEEDS_RPM, run))
}

pub(super) fn drilling(effort: Effort) -> anyhow::Result<Table> {
    let runs = effort.repetitions(100);
    let outcomes = each_seed(0..runs, |run| {
        let (inclination_deg, rpm) = drawn(run);
        let seed = FIRST_SEED + run;
        diagnose(&drilled(inclination_deg, seed, |scenario, _| scenario.rotation.mean_rpm = rpm)?, seed, &LIBRARY)
    })?;
    let mut table = Table::new(
        format!(
            "Clean drilling, {DATA_S} s, {runs} runs spread over these inclinations and over {SPEEDS_RPM:?} rpm: runs in which an effect is \
             named (target: at most one in all, with the recordings)"
        ),
        &["inclination, deg", "runs", "an effect is named", "unexplained", "not enough motion", "named"],
    );
    let mut row = |label: String, of: &dyn Fn(u64) -> bool| {
        let chosen: Vec<&Outcome> = (0..runs).zip(&outcomes).filter(|(run, _)| of(*run)).map(|(_, o)| o).collect();
        let count =
            |is: &dyn Fn(&Outcome) -> bool| Cell::number(chosen.iter().filter(|outcome| is(outcome)).count() as f64, 0);
        let names: Vec<&str> = chosen.iter().flat_map(|outcome| &outcome.names).copied().collect();
        table.row([
            Cell::from(label),
            Cell::number(chosen.len() as f64, 0),
            count(&|outcome| !outcome.names.is_empty()),
            count(&|outcome| outcome.verdict == Some(Verdict::UnexplainedResidual)),
            count(&|outcome| outcome.verdict.is_none()),
            names.join(" ").into(),
        ]);
    };
    for inclination_deg in INCLINATIONS_DEG {
        row(format!("{inclination_deg}"), &|run| drawn(run).0 == inclination_deg);
    }
    row("all".to_owned(), &|_| true);
    Ok(table)
}

pub(super) fn recordings() -> anyhow::Result<Table> {
    let mut paths = given().context(FOLDER)?;
    if paths.is_empty() {
        paths = bundled()?;
    }
    let named = each_seed(0..paths.len() as u64, |index| {
        let path = usize::try_from(index).ok().and_then(|index| paths.get(index)).context("a path")?;
        Ok((name(path), named(path)?))
    })?;
    let mut table = Table::new(
        "Recordings by hand, each as a whole: what is named. Every vector sensor has a little of each of its errors; a name of the gyro's is \
         false, since its lag alone stands out against the reference, and a lag of the gyro against all other sensors is one of theirs",
        &["recording", "of accelerometer and magnetometer", "of the gyro"],
    );
    for (name, [of_vectors, of_gyro]) in named {
        table.row([name, of_vectors.join(" "), of_gyro.join(" ")]);
    }
    Ok(table)
}

fn named(path: &Path) -> anyhow::Result<[Vec<&'static str>; 2]> {
    let mut trace = Trace::read(path)?;
    let config: Config = of_trace(&trace);
    trace.mark_clipped(&config.full_scale);
    let names = Outcome::of(&fly(&config, &trace.samples, |_| {})?, &LIBRARY).names;
    let is_of_gyro =
        |name: &&str| LIBRARY.iter().any(|effect| effect.name() == *name && effect.sensor() == Sensor::Gyro);
    let (of_gyro, of_vectors) = names.into_iter().partition(is_of_gyro);
    Ok([of_vectors, of_gyro])
}
