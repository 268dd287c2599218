//! Cost of a minute of drilling on the emulated chip.

use super::{
    effort::Effort,
    one_window::scenario,
    table::{Cell, Table},
};
use crate::{
    flight::configuration::of_trace,
    simulate::simulate,
    target::{
        emulate::{Feed, fly_emulated},
        parts::{PartCost, count_parts},
    },
};
use meerkat_mwd::{Config, Sample};

/// Length of the run, seconds: one window, its latency and some more.
const DURATION_S: f64 = 60.0;

/// Clock of the STM32F405, Hz, for times of one instruction a cycle.
const CLOCK_HZ: f64 = 168e6;

/// Runs once, whatever the effort: the emulator counts exactly.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let mut table = Table::new(
        format!("{DURATION_S} s of drilling at 100 Hz on the emulated Cortex-M4F (STM32F405, QEMU), instructions"),
        &["", "vertical", "45 deg", "ms at 168 MHz and one instruction a cycle"],
    );
    let flown = [drilling("drilling_vertical")?, drilling("drilling_45deg")?];
    let flights = [measure(&flown[0])?, measure(&flown[1])?];
    for (index, name) in NAMES.iter().enumerate() {
        let counts = [flights[0][index], flights[1][index]];
        let slowest = counts.iter().copied().fold(0.0, f64::max);
        let cells = counts.map(|count| Cell::number(count, 0));
        table.row([Cell::from(*name)].into_iter().chain(cells).chain([Cell::number(1e3 * slowest / CLOCK_HZ, 3)]));
    }
    let parts = [count_parts(&flown[0].0, &flown[0].1)?, count_parts(&flown[1].0, &flown[1].1)?];
    Ok(vec![table, identification(&parts)])
}

/// Table of the run's one identification, part by part.
fn identification(flights: &[Vec<PartCost>; 2]) -> Table {
    let mut table = Table::new(
        "One identification of a window of 50 s on the same chip: instructions, and cycles estimated from the processor's instruction timings with \
         memory that never waits",
        &["", "vertical", "45 deg", "cycles, vertical", "cycles, 45 deg", "ms at 168 MHz"],
    );
    let mut row = |name: &str, costs: [PartCost; 2]| {
        let instructions = costs.map(|cost| Cell::number(cost.instructions as f64, 0));
        let cycles = costs.map(|cost| cost.cycles as f64);
        let slowest = cycles.into_iter().fold(0.0, f64::max);
        let cells = instructions.into_iter().chain(cycles.map(|cycles| Cell::number(cycles, 0)));
        table.row([Cell::from(name)].into_iter().chain(cells).chain([Cell::number(1e3 * slowest / CLOCK_HZ, 2)]));
    };
    let [vertical, inclined] = flights;
    for (a, b) in vertical.iter().zip(inclined) {
        row(a.name, [*a, *b]);
    }
    let sum = |parts: &Vec<PartCost>| {
        parts.iter().fold(PartCost { name: "all of it", instructions: 0, cycles: 0 }, |sum, part| PartCost {
            instructions: sum.instructions + part.instructions,
            cycles: sum.cycles + part.cycles,
            ..sum
        })
    };
    row("all of it", flights.each_ref().map(sum));
    table
}

/// Rows of the table, in the order of [`measure`].
const NAMES: [&str; 4] = [
    "a sample, mean",
    "a sample, worst",
    "identification and diagnosis to a report, worst",
    "longest slice of that work",
];

/// A configuration and the samples of a minute.
fn drilling(name: &str) -> anyhow::Result<(Config, Vec<Sample>)> {
    let mut scenario = scenario(name)?;
    scenario.duration_s = DURATION_S;
    let (trace, _) = simulate(&scenario, 1);
    Ok((of_trace(&trace), trace.samples))
}

fn measure((config, samples): &(Config, Vec<Sample>)) -> anyhow::Result<[f64; NAMES.len()]> {
    let emulated = fly_emulated(config, samples, Feed::Direct)?;
    let identification = emulated.poll_instructions.iter().max().copied().unwrap_or(0);
    let summary = &emulated.summary;
    let counts = [
        summary.push.instructions_mean(),
        summary.push.instructions_max,
        identification,
        summary.poll.instructions_max,
    ];
    Ok(counts.map(|count| count as f64))
}
