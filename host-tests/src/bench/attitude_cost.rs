//! Cost of the attitude filter on the emulated chip, beside the filters of `uf-ahrs` on the same samples.

use anyhow::Context;

use crate::target::{machine::run_program, toolchain};
use testbed::study::{Cell, Effort, Table};

/// Cost of a filter at one sample rate.
struct Count {
    name: String,
    rate_hz: u32,
    mean: f64,
    worst: f64,
    stack_bytes: f64,
}

/// Runs the filters once: the emulator counts exactly.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let printed = run_program(&toolchain::prepare()?, "filter-cost")?;
    let counts = printed.lines().map(parse).collect::<anyhow::Result<Vec<Count>>>()?;
    let mut table = Table::new(
        "Instructions of one 9-axis update on the emulated Cortex-M4F (STM32F405, QEMU): ours with compensation, propagation, fusion, \
         angles and their sigmas; those of uf-ahrs 0.2 with nothing beside (targets: ours at most a fifth of VQF, mean at most 2,000, \
         worst at most 6,000, stack under 4 KiB)",
        &["", "rate, Hz", "mean", "worst", "mean of ours over it", "stack, bytes"],
    );
    for count in &counts {
        let ours = counts.iter().find(|other| other.name == "ours" && other.rate_hz == count.rate_hz);
        table.row([
            Cell::from(count.name.as_str()),
            Cell::number(f64::from(count.rate_hz), 0),
            Cell::number(count.mean, 0),
            Cell::number(count.worst, 0),
            Cell::number(ours.map_or(f64::NAN, |ours| ours.mean / count.mean), 3),
            Cell::number(count.stack_bytes, 0),
        ]);
    }
    Ok(vec![table])
}

fn parse(line: &str) -> anyhow::Result<Count> {
    let parsed = || {
        let mut cells = line.split(',');
        Some(Count {
            name: cells.next()?.to_owned(),
            rate_hz: cells.next()?.parse().ok()?,
            mean: cells.next()?.parse().ok()?,
            worst: cells.next()?.parse().ok()?,
            stack_bytes: cells.next()?.parse().ok()?,
        })
    };
    parsed().with_context(|| format!("the emulated program printed {line:?}"))
}
