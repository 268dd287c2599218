//! Seeded schedules of faults: an attitude that no flag marks is within five of its deviations.
//! `cargo mwd bench --only honesty` plays ten thousand of them.

use mwd::bench::honesty::schedules::{Played, play};

/// Seeds that nothing else uses.
const SEEDS: std::ops::Range<u64> = (1 << 40)..(1 << 40) + 60;

/// Share of the attitudes without a flag that may be beyond where a gyro reads another rate than there is; measured here:
/// 0.8 %. Nothing tells a slow wrong rate from a tool that turns before gravity and field have contradicted it.
const WITH_A_WRONG_GYRO: f64 = 0.02;

#[test]
fn an_attitude_that_no_flag_marks_is_within_five_deviations_unless_a_gyro_reads_wrong() {
    let played: Vec<(u64, Played)> = SEEDS.map(|seed| (seed, play(seed).unwrap())).collect();
    for (seed, one) in played.iter().filter(|(_, one)| one.seen.beyond > 0) {
        println!("{seed}: {:?} {:?}", one.seen, one.faults);
    }
    let of = |is_wrong: bool| {
        let chosen = played.iter().map(|(_, one)| one).filter(|one| one.gyro_reads_wrong() == is_wrong);
        chosen.fold((0, 0), |(count, beyond), one| (count + one.seen.count, beyond + one.seen.beyond))
    };
    let (sound, wrong) = (of(false), of(true));
    println!("beyond, of attitudes without a flag: {sound:?} with a sound gyro, {wrong:?} without");
    assert!(sound.0 > 100_000 && sound.1 == 0, "{sound:?}");
    assert!(wrong.0 > 100_000 && (wrong.1 as f64) < WITH_A_WRONG_GYRO * wrong.0 as f64, "{wrong:?}");
}
