//! Flash, RAM and stack of the firmware by module: the page that tests hold the firmware against.

use crate::target::{
    module_sizes::{Sizes, measured},
    toolchain,
};
use testbed::study::{Cell, Effort, Table, one_window::scenario};
use testbed::{simulate::simulate, trace::Trace};

/// Length of the flight whose stack is measured, seconds: one window and its latency.
const DURATION_S: f64 = 56.0;

/// Runs once, whatever the effort.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let version = toolchain::prepare()?.compiler_version()?;
    let mut table = Table::new(
        format!("Firmware of the STM32F405 with all that it says, {version}; modules and statics of 1 KiB and more"),
        &["", "bytes"],
    );
    for (name, bytes) in measured(&flight()?)? {
        table.row([Cell::from(name), Cell::number(bytes as f64, 0)]);
    }
    Ok(vec![table])
}

/// The flight whose stack is measured.
///
/// # Errors
/// Its scenario cannot be read.
pub fn flight() -> anyhow::Result<Trace> {
    let mut scenario = scenario("drilling_45deg")?;
    scenario.duration_s = DURATION_S;
    Ok(simulate(&scenario, 1).0)
}

/// Sizes of a written page; `None` if it was measured with another compiler.
#[must_use]
pub fn of_page(page: &str, version: &str) -> Option<Sizes> {
    let row = |line: &str| {
        let mut cells = line.strip_prefix("| ")?.split(" | ");
        Some((cells.next()?.to_owned(), cells.next()?.trim_end_matches(" |").parse().ok()?))
    };
    page.contains(version).then(|| page.lines().filter_map(row).collect())
}
