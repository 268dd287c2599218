//! Cost of the sampling path on the emulated chip.

use crate::target::emulate::{Feed, fly_emulated};
use testbed::study::{Cell, Effort, Table, one_window::scenario};
use testbed::{flight::configuration::of_trace, simulate::simulate};

/// Length of the run, seconds.
const DURATION_S: f64 = 20.0;

/// Runs once: the emulator counts exactly.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let mut scenario = scenario("drilling_45deg")?;
    scenario.duration_s = DURATION_S;
    let (trace, _) = simulate(&scenario, 1);
    let config = of_trace(&trace);
    let emulated = fly_emulated(&config, None, &trace.samples, Feed::ThroughSensors)?;
    let cost = emulated.sampling.ok_or_else(|| anyhow::anyhow!("the firmware says nothing of its sampling"))?;
    let mut table = Table::new(
        format!(
            "The sampling path of an ISM330DHCX and an RM3100 on the emulated Cortex-M4F, {DURATION_S} s of drilling, instructions"
        ),
        &["", "a sample"],
    );
    table.row(["adapters, supervision and combiner".into(), Cell::number(cost.adapters, 0)]);
    table.row(["wires and register models, which a board has hardware for".into(), Cell::number(cost.wires, 0)]);
    table.row(["the most of both together".into(), Cell::number(cost.most, 0)]);
    Ok(vec![table])
}
