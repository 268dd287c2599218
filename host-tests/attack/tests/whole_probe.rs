//! The whole probe under attack: a share of the seeds that `mwd bench --only whole_probe` flies.
#![allow(clippy::unwrap_used)]

use attack::whole_probe::{KINDS, Tally, VIOLATIONS, fly, fly_day};
use testbed::study::seeds::each_seed;

const SEEDS: u64 = 1_000;

#[test]
fn what_has_to_hold_holds_whatever_goes_wrong() {
    let mut all = Tally::default();
    for (seed, run) in each_seed(0..SEEDS, fly).unwrap().iter().enumerate() {
        assert_eq!(run.tally.all_violations(), 0, "seed {seed}: {:?}", run.tally.first);
        all.add(&run.tally);
    }
    println!("{all:#?}");
    // A clock that steps ahead by a fraction of a second while the tool turns looks like lost samples.
    let [soon, outside] = all.soon;
    assert!(outside * 10_000 <= soon, "{outside} of {soon} attitudes soon after a fault are not within 5 sigma");
    for (kind, times) in KINDS.iter().zip(all.troubles) {
        assert!(times > 0, "no {kind} in {SEEDS} seeds");
    }
    for ((_, name), checks) in VIOLATIONS.iter().zip(all.checks) {
        assert!(checks > 0, "never looked whether {name}");
    }
}

/// Seeds beyond the first thousand that have violated what has to hold.
#[test]
fn seeds_that_have_violated_do_so_no_more() {
    for seed in [5_047, 70_581, 71_501] {
        let tally = fly(seed).unwrap().tally;
        assert_eq!(tally.all_violations(), 0, "seed {seed}: {:?}", tally.first);
    }
}

#[test]
fn a_seed_gives_the_same_bytes_every_time() {
    let (one, again, other) = (fly(7).unwrap(), fly(7).unwrap(), fly(8).unwrap());
    assert_eq!(one, again);
    assert_ne!(one.digest, other.digest);
}

/// So many that a clock of microseconds in 32 bits wraps, and at real proportions: the first hours of some days.
#[test]
fn what_has_to_hold_holds_at_real_proportions() {
    let mut all = Tally::default();
    for (seed, run) in each_seed(0..4, |seed| fly_day(seed, 4_500.0)).unwrap().iter().enumerate() {
        assert_eq!(run.tally.all_violations(), 0, "day {seed}: {:?}", run.tally.first);
        all.add(&run.tally);
    }
    println!("{all:#?}");
    assert!(all.longest_us > 1 << 32, "no start lasts longer than {} us", all.longest_us);
    assert!(all.models > 0 && all.restored > 0, "{} models stored, {} restored", all.models, all.restored);
}
