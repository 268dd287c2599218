//! Every bus fault survived: each kind at every transaction of two seconds, no panic, no wrong sample unflagged.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod emulated;
mod mocked;
mod through_sensors;

use mwd::bus_faults::{
    Motion, Outcome, RUN_US, Run, judge,
    kinds::{KINDS, Part, cases},
    run, sweep,
};

/// A motion that no other test or table has, and the run without a fault.
fn motion() -> (Motion, Run) {
    let motion = Motion::new(RUN_US, 77);
    let clean = run(&motion, None);
    (motion, clean)
}

#[test]
fn without_a_fault_every_sample_is_right_and_hardly_one_is_flagged() {
    let (motion, clean) = motion();
    let judgement = judge(&motion, &clean, 0);
    assert_eq!(judgement.wrong, []);
    assert!(clean.samples.len() as u64 > (RUN_US - 100_000) / 4_900, "{}", clean.samples.len());
    assert!(judgement.flagged.len() <= 6, "{:?}", judgement.flagged);
    let mut times = clean.samples.windows(2).map(|pair| pair[1].1.t_us - pair[0].1.t_us);
    assert!(times.all(|step_us| (3_800..5_900).contains(&step_us)));
}

/// The whole of it; a frozen output and a dead axis take their time, which is bounded here.
fn sweep_all(part: Part) {
    let (motion, clean) = motion();
    for kind in KINDS {
        let outcome = sweep(&motion, &clean, part, kind, 1);
        println!("{part:?}, {}: {outcome:?}", kind.name);
        let Outcome { runs, wrong_runs, wrong_samples, wrong_noises, not_recovered, silent, .. } = outcome;
        let transactions = clean.transactions[usize::from(part == Part::Rm3100)] as usize;
        let expected = (kind.faults)(part).len() * transactions * 2 / 3;
        assert!(runs >= expected, "{runs} runs of over {expected}: a run has panicked");
        assert_eq!(not_recovered, 0);
        match kind.name {
            "bit flipped" => {
                assert_eq!(wrong_runs, 0);
                assert!(outcome.attitude_deg <= 0.1, "{} deg", outcome.attitude_deg);
            }
            "short read" => {
                assert_eq!(wrong_runs, 0);
                assert!(outcome.attitude_deg <= 0.15, "{} deg", outcome.attitude_deg);
            }
            "one axis dead for 300 ms" | "output frozen for 300 ms" => {
                // One that stops where it is expected to be shows as soon as it should have moved on, and one that has never moved by the
                // count of its repeats, after each start.
                assert!(wrong_runs * 10 < runs && wrong_samples <= 45 && wrong_noises < 100.0, "{outcome:?}");
            }
            // A part without a FIFO leaves no trace of a reading that nobody has read.
            "FIFO overrun, or a reading lost" if part == Part::Rm3100 => assert_eq!(wrong_runs, 0),
            _ => assert_eq!((wrong_runs, silent), (0, silent.min(2)), "{outcome:?}"),
        }
        assert!(outcome.recovery_us < 400_000, "{kind:?}: {} us", outcome.recovery_us);
    }
}

#[test]
fn every_fault_at_every_transaction_with_the_gyro_and_accelerometer_is_survived() {
    sweep_all(Part::Ism330dhcx);
}

#[test]
fn every_fault_at_every_transaction_with_the_magnetometer_is_survived() {
    sweep_all(Part::Rm3100);
}

/// What the sweep could not see it would not find: a judge that accepts everything.
#[test]
fn the_judge_finds_a_stale_and_a_shifted_and_a_scaled_sample() {
    let (motion, clean) = motion();
    let spoil = |spoil: fn(&mut meerkat_mwd::Sample, &meerkat_mwd::Sample)| {
        let mut spoilt = clean.clone();
        let before = spoilt.samples[250].1;
        spoil(&mut spoilt.samples[260].1, &before);
        judge(&motion, &spoilt, 0).wrong.len()
    };
    assert_eq!(spoil(|_, _| {}), 0);
    assert!(spoil(|sample, before| sample.gyro_rad_s = before.gyro_rad_s) > 0);
    assert!(spoil(|sample, _| sample.t_us += 20_000) > 0);
    assert!(spoil(|sample, _| sample.accel_m_s2[1] += 0.5) > 0);
    assert!(spoil(|sample, _| sample.gyro_rad_s[2] *= 1.2) > 0);
}

#[test]
fn the_cases_are_one_of_each_kind_at_each_transaction() {
    let all: usize = KINDS.iter().map(|kind| cases(kind, Part::Ism330dhcx, 100).len()).sum();
    assert_eq!(all, 100 * KINDS.iter().map(|kind| (kind.faults)(Part::Ism330dhcx).len()).sum::<usize>());
    assert!(all > 2_500);
}
