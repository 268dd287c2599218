//! The whole probe under attack: what went wrong, what was checked and what did not hold.

use super::{
    effort::Effort,
    kept::each_block,
    seeds::each_seed,
    table::{Cell, Table, median_and_worst},
};
use crate::whole_probe::{KINDS, Tally, VIOLATIONS, fly, static_bytes};
use anyhow::bail;
use serde::{Deserialize, Serialize};
use std::{ops::Range, time::Instant};

/// Runs that a failure lists.
const LISTED: usize = 10;

/// What a block of seeds gave.
#[derive(Default, Serialize, Deserialize)]
struct Flown {
    tally: Tally,
    /// The seeds in which something did not hold, and what.
    failed: Vec<String>,
    seconds: f64,
}

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.seeds(1_000);
    let mut all = Flown::default();
    for block in each_block("whole_probe", seeds.clone(), fly_all)? {
        all.tally.add(&block.tally);
        all.failed.extend(block.failed);
        all.seconds += block.seconds;
    }
    let Flown { tally, failed, seconds } = all;
    let seeds = seeds.end - seeds.start;
    if !failed.is_empty() {
        let listed = failed.iter().take(LISTED).cloned().collect::<Vec<_>>().join("\n");
        bail!("{} of {seeds} seeds violate what has to hold:\n{listed}\n{}", failed.len(), checks(&tally, seeds));
    }
    Ok(vec![checks(&tally, seeds), troubles(&tally), flown(&tally, seeds as f64 / seconds)])
}

fn fly_all(seeds: Range<u64>) -> anyhow::Result<Flown> {
    let begun = Instant::now();
    let mut all = Flown::default();
    for (seed, run) in seeds.clone().zip(each_seed(seeds, fly)?) {
        if run.tally.all_violations() > 0 {
            let told = format!("seed {seed}: {}", run.tally.first.as_deref().unwrap_or("?"));
            // At once, for all of them together may take hours.
            eprintln!("{told}");
            all.failed.push(told);
        }
        all.tally.add(&run.tally);
    }
    all.seconds = begun.elapsed().as_secs_f64();
    Ok(all)
}

fn count(number: u64) -> Cell {
    Cell::number(number as f64, 0)
}

fn checks(all: &Tally, seeds: u64) -> Table {
    let title = format!("The whole probe under attack, {seeds} seeds: what has to hold");
    let mut table = Table::new(title, &["", "checked", "violations"]);
    for (violation, name) in VIOLATIONS {
        let place = violation as usize;
        table.row([Cell::from(name), count(all.checks[place]), count(all.violations[place])]);
    }
    table
}

fn troubles(all: &Tally) -> Table {
    let mut table = Table::new("The same runs: what went wrong", &["", "times"]);
    for (kind, times) in KINDS.into_iter().zip(all.troubles) {
        table.row([Cell::from(kind), count(times)]);
    }
    table
}

fn flown(all: &Tally, seeds_per_s: f64) -> Table {
    let mut table =
        Table::new("The same runs: what was flown; times are median [worst] of starts with sound sensors", &["", ""]);
    let rows = [
        ("starts", all.starts),
        ("samples", all.samples),
        ("of these lost and counted", all.lost),
        ("most that waited, of 31", all.queue),
        ("results that newer ones pushed out, counted", all.results_lost),
        ("bytes of static memory, as this machine lays them out", static_bytes() as u64),
        ("most bytes of this machine's stack at a call of the board, of 24,576", all.stack),
        ("commands of the owner", all.commands),
        ("attitudes without a flag in the 30 s after a start or a fault", all.soon[0]),
        ("of these beyond 5 sigma", all.soon[1]),
        ("angles of surveys while an effect is taken out, in the 30 s after a start or a fault", all.misled[0]),
        ("of these beyond 5 sigma", all.misled[1]),
        ("models stored", all.models),
        ("models restored", all.restored),
    ];
    for (name, number) in rows {
        table.row([Cell::from(name), count(number)]);
    }
    let [at_rest, drilling, unflagged] = &all.back_s;
    for (name, times) in [
        ("from a start at rest to the first attitude on the line, s", at_rest),
        ("the same of a start while drilling, s", drilling),
        ("from a start to the first attitude without a flag, s", unflagged),
    ] {
        table.row([Cell::from(name), median_and_worst(times, 2)]);
    }
    table
        .row([Cell::from("seeds a second of this machine, which did other work beside"), Cell::number(seeds_per_s, 1)]);
    table
}
