//! The whole probe under attack: what went wrong, what was checked and what did not hold.

use super::{does_not_hold::DoesNotHold, kept::each_block};
use attack::whole_probe::{DAY_S, KINDS, Run, Tally, VIOLATIONS, fly, fly_day, static_bytes};
use serde::{Deserialize, Serialize};
use std::{ops::Range, time::Instant};
use testbed::study::{Cell, Effort, Table, median_and_worst, seeds::each_seed};

/// Runs in which something did not hold that the page lists.
const LISTED: usize = 100;

/// Results of a block of seeds.
#[derive(Default, Serialize, Deserialize)]
struct Flown {
    tally: Tally,
    /// The seeds in which something did not hold, how often, and what was the first of it.
    failed: Vec<(u64, u64, String)>,
    seconds: f64,
}

/// Most days at real proportions, and the seeds in compressed time for each of them.
const DAYS: u64 = 20;
const SEEDS_A_DAY: u64 = 50;

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let seeds = effort.seeds(1_000);
    let number = seeds.end - seeds.start;
    let all = sum(each_block("whole_probe", seeds.clone(), |block| fly_all(block, fly))?);
    // Fewer seeds than belong to a day fly the first hours of one.
    let days = number.div_ceil(SEEDS_A_DAY).min(DAYS);
    let length_s = DAY_S * (number as f64 / SEEDS_A_DAY as f64).min(1.0);
    let of_days = fly_all(seeds.start..seeds.start + days, |seed| fly_day(seed, length_s))?;
    all_tables(&all, number, &of_days, days, length_s / 3_600.0)
}

/// Tables of so many seeds, and of so many days of so many hours.
///
/// # Errors
/// Something did not hold, [`DoesNotHold`]: the same tables, and one more for the seeds and one for the days in which
/// it did not.
fn all_tables(all: &Flown, number: u64, of_days: &Flown, days: u64, hours: f64) -> anyhow::Result<Vec<Table>> {
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
    let mut tables = Vec::new();
    for (flown, title, last) in [
        (all, format!("The whole probe under attack, {number} seeds: what has to hold"), by_seed),
        (of_days, format!("{days} times {hours:.1} hours at real proportions: what has to hold"), by_day),
    ] {
        tables.push(checks(&flown.tally, title));
        tables.extend(failures(&flown.failed));
        tables.extend([troubles(&flown.tally), last]);
    }
    let failed = [all, of_days].map(|flown| flown.failed.len());
    if failed == [0, 0] {
        return Ok(tables);
    }
    let words = format!("{} of {number} seeds and {} of {days} days violate what has to hold", failed[0], failed[1]);
    Err(DoesNotHold { tables, words }.into())
}

/// Sum of the results of all blocks.
fn sum(blocks: Vec<Flown>) -> Flown {
    let mut all = Flown::default();
    for block in blocks {
        all.tally.add(&block.tally);
        all.failed.extend(block.failed);
        all.seconds += block.seconds;
    }
    all
}

fn fly_all(seeds: Range<u64>, fly: impl Fn(u64) -> anyhow::Result<Run> + Sync) -> anyhow::Result<Flown> {
    let begun = Instant::now();
    let mut all = Flown::default();
    for (seed, run) in seeds.clone().zip(each_seed(seeds, fly)?) {
        if run.tally.all_violations() > 0 {
            let first = run.tally.first.clone().unwrap_or_else(|| "?".to_owned());
            // At once, for all of them together may take hours.
            eprintln!("seed {seed}: {first}");
            all.failed.push((seed, run.tally.all_violations(), first));
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

/// The seeds in which something did not hold; `None` where all did.
fn failures(failed: &[(u64, u64, String)]) -> Option<Table> {
    let more = failed.len().saturating_sub(LISTED);
    let of_more = if more > 0 { format!("; {more} more are not listed") } else { String::new() };
    let title = format!("Runs in which something did not hold: {}{of_more}", failed.len());
    let mut table = Table::new(title, &["seed", "violations", "the first of them"]);
    for (seed, violations, first) in failed.iter().take(LISTED) {
        // A bar would end the cell.
        table.row([Cell::from(seed.to_string()), count(*violations), Cell::from(first.replace('|', "/"))]);
    }
    (!failed.is_empty()).then_some(table)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use attack::whole_probe::Violation;

    fn flown(seeds: Range<u64>, violating: u64) -> Flown {
        let fly = |seed| {
            let mut tally = Tally::default();
            tally.checked(Violation::Survey);
            if seed == violating {
                tally.violated(Violation::Survey, || "azimuth | 9 sigma off".to_owned());
            }
            Ok(Run { tally, digest: 0 })
        };
        fly_all(seeds, fly).unwrap()
    }

    #[test]
    fn what_does_not_hold_ends_with_an_error_that_has_every_table_and_one_of_the_seeds() {
        let (sound, of_days) = (flown(0..4, 9), flown(0..2, 9));
        let tables = all_tables(&sound, 4, &of_days, 2, 0.1).unwrap();
        assert_eq!(tables.len(), 6);
        let told = all_tables(&sum(vec![sound, flown(4..8, 7)]), 8, &of_days, 2, 0.1).unwrap_err();
        assert_eq!(told.to_string(), "1 of 8 seeds and 0 of 2 days violate what has to hold");
        let found: DoesNotHold = told.downcast().unwrap();
        assert_eq!(found.tables.len(), 7);
        let [checks, failures] = [0, 1].map(|k| found.tables[k].to_string());
        assert!(checks.contains("| a survey is of a rest and within 5 sigma | 8 | 1 |"), "{checks}");
        assert!(failures.starts_with("Runs in which something did not hold: 1\n"), "{failures}");
        assert!(failures.contains("| 7 | 1 | 0.000 s: Survey: azimuth / 9 sigma off |"), "{failures}");
        // Below the tables of the seeds are those of the days, as without a violation.
        assert_eq!(found.tables[4], tables[3]);
    }
}
