//! What a minute of drilling costs on the emulated chip.

use super::{
    Effort,
    one_window::scenario,
    table::{Cell, Table},
};
use crate::{
    configuration::of_trace,
    emulate::{Feed, fly_emulated},
    simulate::simulate,
};

/// Length of the run, seconds: one window, its latency and some more.
const DURATION_S: f64 = 60.0;

/// Clock of the STM32F405, Hz, for times of one instruction a cycle.
const CLOCK_HZ: f64 = 168e6;

/// The emulator counts exactly, so one run says it all, however long the bench may take.
pub(super) fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let mut table = Table::new(
        format!("{DURATION_S} s of drilling at 100 Hz on the emulated Cortex-M4F (STM32F405, QEMU), instructions"),
        &["", "vertical", "45 deg", "ms at 168 MHz and one instruction a cycle"],
    );
    let flights = [measure("drilling_vertical")?, measure("drilling_45deg")?];
    for (index, name) in NAMES.iter().enumerate() {
        let counts = [flights[0][index], flights[1][index]];
        let slowest = counts.iter().copied().fold(0.0, f64::max);
        let cells = counts.map(|count| Cell::number(count, 0));
        table.row([Cell::from(*name)].into_iter().chain(cells).chain([Cell::number(1e3 * slowest / CLOCK_HZ, 3)]));
    }
    Ok(vec![table])
}

/// Rows of the table, in the order of [`measure`].
const NAMES: [&str; 4] = [
    "a sample, mean",
    "a sample, worst",
    "identification and diagnosis to a report, worst",
    "longest slice of that work",
];

fn measure(name: &str) -> anyhow::Result<[f64; NAMES.len()]> {
    let mut scenario = scenario(name)?;
    scenario.duration_s = DURATION_S;
    let (trace, _) = simulate(&scenario, 1);
    let emulated = fly_emulated(&of_trace(&trace), &trace.samples, Feed::Direct)?;
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
