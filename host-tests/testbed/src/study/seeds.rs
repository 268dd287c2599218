//! Repetition of a trial over many seeds, on every core.

use std::{
    num::NonZero,
    ops::Range,
    panic,
    sync::atomic::{AtomicU64, Ordering},
    thread,
};

use crate::progress_bar::progress_bar;

/// Results of `trial` for every seed, in the order of the seeds.
///
/// # Errors
/// The error of the lowest seed whose trial fails.
pub fn each_seed<T: Send>(
    seeds: Range<u64>,
    trial: impl Fn(u64) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let bar = progress_bar(usize::try_from(seeds.end.saturating_sub(seeds.start)).unwrap_or(usize::MAX));
    let next = AtomicU64::new(seeds.start);
    let work = || {
        let mut done = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return done;
            }
            done.push((seed, trial(seed)));
            bar.inc(1);
        }
    };
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut done: Vec<(u64, anyhow::Result<T>)> = thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().unwrap_or_else(|payload| panic::resume_unwind(payload)))
            .collect()
    });
    bar.finish_and_clear();
    done.sort_by_key(|&(seed, _)| seed);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_order_is_that_of_the_seeds_and_the_first_failure_is_told() {
        assert_eq!(each_seed(3..300, |seed| Ok(seed * seed)).unwrap(), (3..300).map(|s| s * s).collect::<Vec<u64>>());
        let failing = each_seed(0..100, |seed| if seed % 40 == 39 { Err(anyhow::anyhow!("{seed}")) } else { Ok(()) });
        assert_eq!(failing.unwrap_err().to_string(), "39");
        assert!(each_seed(5..5, |_| Ok(())).unwrap().is_empty());
    }
}
