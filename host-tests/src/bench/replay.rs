//! Speed and memory of `replay` on this machine, one recording at a time on one core.

use super::attitude::vqf;
use anyhow::ensure;
use std::{
    env,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};
use testbed::{
    process_memory::largest_kib,
    simulate::simulate,
    study::{Cell, Effort, Table, one_window::scenario},
};

/// Time between two looks at a running program's memory.
const LOOK: Duration = Duration::from_millis(5);

pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let title = "A recording without a reference, simulated drilling at 45 deg and 100 Hz, as plain text: `replay` as a program of its own, \
                 from its start to its end, and VQF on the same samples in memory";
    let columns = ["hours", "samples", "s", "samples a second", "of VQF's time", "most memory, MiB"];
    let mut table = Table::new(title, &columns);
    for hours in [1, effort.repetitions(10)] {
        let mut scenario = scenario("drilling_45deg")?;
        scenario.duration_s = 3_600.0 * hours as f64;
        let (mut trace, _) = simulate(&scenario, 0);
        trace.reference.clear();
        trace.true_rate = None;
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("trace.csv");
        trace.write(&path)?;
        let begun = Instant::now();
        ensure!(vqf(&trace).len() == trace.len(), "VQF gives an attitude for each sample");
        let vqf_s = begun.elapsed().as_secs_f64();
        let samples = trace.len() as f64;
        drop(trace);
        let (seconds, most_kib) = replayed(&path)?;
        let memory = most_kib.map_or_else(|| Cell::from("-"), |kib| Cell::number(kib as f64 / 1_024.0, 0));
        table.row([
            Cell::number(hours as f64, 0),
            Cell::number(samples, 0),
            Cell::number(seconds, 2),
            Cell::number(samples / seconds, 0),
            Cell::number(seconds / vqf_s, 2),
            memory,
        ]);
    }
    Ok(vec![table])
}

/// Replays a trace; returns the time that it takes, seconds, and the most memory, KiB, where the system tells it.
fn replayed(path: &Path) -> anyhow::Result<(f64, Option<u64>)> {
    let begun = Instant::now();
    let mut program = Command::new(env::current_exe()?)
        .args(["replay", "-q"])
        .arg(path)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let mut most_kib = None;
    loop {
        let ended = program.try_wait()?;
        if let Some(status) = ended {
            ensure!(status.success(), "replay of {}: {status}", path.display());
            return Ok((begun.elapsed().as_secs_f64(), most_kib));
        }
        most_kib = most_kib.max(largest_kib(program.id()));
        sleep(LOOK);
    }
}
