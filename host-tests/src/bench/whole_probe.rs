//! The whole probe under attack: what went wrong, what was checked and what did not hold.

use super::kept::each_block;
use anyhow::bail;
use attack::whole_probe::{DAY_S, KINDS, Run, Tally, VIOLATIONS, fly, fly_day, static_bytes};
use serde::{Deserialize, Serialize};
use std::{ops::Range, time::Instant};
use testbed::study::{Cell, Effort, Table, median_and_worst, seeds::each_seed};

/// Runs that a failure lists.
const LISTED: usize = 10;

/// Results of a block of seeds.
#[derive(Default, Serialize, Deserialize)]
struct Flown {
    tally: Tally,
    /// The seeds in which something did not hold, and what.
    failed: Vec<String>,
    seconds: f64,
}

/// Most days at real proportions, and the seeds in compressed time for each of them.
const DAYS: u64 = 20;
const SEEDS_A_DAY: u64 = 50;

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.seeds(1_000);
    let number = seeds.end - seeds.start;
    let all = sum(each_block("whole_probe", seeds.clone(), |block| fly_all(block, fly))?, number)?;
    // Fewer seeds than belong to a day fly the first hours of one.
    let days = number.div_ceil(SEEDS_A_DAY).min(DAYS);
    let length_s = DAY_S * (number as f64 / SEEDS_A_DAY as f64).min(1.0);
    let of_days = fly_all(seeds.start..seeds.start + days, |seed| fly_day(seed, length_s))?;
    let of_days = sum(vec![of_days], days)?;
    let hours = length_s / 3_600.0;
    let mut by_seed = flown(&all.tally);
    let seeds_per_s = Cell::number(number as f64 / all.seconds, 1);
    by_seed.row([Cell::from("seeds a second of this machine, which did other work beside"), seeds_per_s]);
    let mut by_day = flown(&of_days.tally);
    for (name, number, decimals) in [
        ("longest time from a start to its end, h", of_days.tally.longest_us as f64 / 3.6e9, 1),
        ("most erasures of a sector of the flash in one of these runs", of_days.tally.erasures as f64, 0),
        ("most commands sent in one of them, numbered by 16 bits from 65,435", of_days.tally.frames as f64, 0),
        ("hours a second of this machine, which did other work beside", days as f64 * hours / of_days.seconds, 1),
    ] {
        by_day.row([Cell::from(name), Cell::number(number, decimals)]);
    }
    Ok(vec![
        checks(&all.tally, format!("The whole probe under attack, {number} seeds: what has to hold")),
        troubles(&all.tally),
        by_seed,
        checks(&of_days.tally, format!("{days} times {hours:.1} hours at real proportions: what has to hold")),
        troubles(&of_days.tally),
        by_day,
    ])
}

/// Sum of the results of all blocks, of so many seeds together.
///
/// # Errors
/// Something did not hold.
fn sum(blocks: Vec<Flown>, seeds: u64) -> anyhow::Result<Flown> {
    let mut all = Flown::default();
    for block in blocks {
        all.tally.add(&block.tally);
        all.failed.extend(block.failed);
        all.seconds += block.seconds;
    }
    if !all.failed.is_empty() {
        let listed = all.failed.iter().take(LISTED).cloned().collect::<Vec<_>>().join("\n");
        let table = checks(&all.tally, "What has to hold".to_owned());
        bail!("{} of {seeds} seeds violate what has to hold:\n{listed}\n{table}", all.failed.len());
    }
    Ok(all)
}

fn fly_all(seeds: Range<u64>, fly: impl Fn(u64) -> anyhow::Result<Run> + Sync) -> anyhow::Result<Flown> {
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

fn checks(all: &Tally, title: String) -> Table {
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

fn flown(all: &Tally) -> Table {
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
}
