//! Flies seeds of the whole-probe simulation until one violates what has to hold: `simulation SEEDS`.

use attack::whole_probe;
use std::{
    sync::atomic::{AtomicU64, Ordering},
    thread,
};

fn main() -> anyhow::Result<()> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(1_000), |text| text.parse())?;
    // Panics of mutated code are not printed: they count as violations, and the last line says so.
    std::panic::set_hook(Box::new(|_| ()));
    let (next, found) = (AtomicU64::new(0), AtomicU64::new(seeds));
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= found.load(Ordering::Relaxed) {
                return;
            }
            if whole_probe::fly(seed).is_ok_and(|run| run.tally.all_violations() > 0) {
                found.fetch_min(seed, Ordering::Relaxed);
            }
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| (0..cores).for_each(|_| drop(scope.spawn(work))));
    let found = found.into_inner();
    if found == seeds {
        println!("none of {seeds} seeds");
        return Ok(());
    }
    let first = whole_probe::fly(found)?.tally.first.unwrap_or_default();
    println!("seed {found} | {}", first.split("; started").next().unwrap_or_default());
    Ok(())
}
