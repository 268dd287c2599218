//! Every bus fault survived: each kind at every seventh transaction of two seconds, no panic, no wrong sample
//! unflagged. `cargo mwd bench --only bus_faults` tries every transaction.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../rig/mod.rs"]
mod rig;
mod checked;
mod emulated;
mod mocked;
mod through_sensors;

use mwd::bus_faults::{
    Bus, Motion, Outcome, RUN_US, Run, judge,
    kinds::{KINDS, Part, cases},
    run, sweep,
};

/// A motion that no other test or table has, and the run without a fault.
fn motion(bus: Bus) -> (Motion, Run) {
    let motion = Motion::new(RUN_US, 77);
    let clean = run(&motion, bus, None);
    (motion, clean)
}

#[test]
fn without_a_fault_every_sample_is_right_and_hardly_one_is_flagged() {
    for bus in [Bus::Spi, Bus::I2c] {
        let (motion, clean) = motion(bus);
        let judgement = judge(&motion, &clean, 0, &[]);
        assert_eq!(judgement.wrong, []);
        assert!(clean.samples.len() as u64 > (RUN_US - 100_000) / 4_900, "{}", clean.samples.len());
        assert!(judgement.flagged.len() <= 6, "{:?}", judgement.flagged);
        let mut times = clean.samples.windows(2).map(|pair| pair[1].1.t_us - pair[0].1.t_us);
        assert!(times.all(|step_us| (3_800..5_900).contains(&step_us)));
    }
}

/// From one transaction with a fault to the next: no divisor of the number of transactions that a sample takes.
const STRIDE: usize = 7;

/// Checks that no sample is wrong, apart from a payload that the wire spoilt by less than the innovation
/// limit, which no part here can detect.
fn sweep_all(bus: Bus, part: Part) {
    let (motion, clean) = motion(bus);
    for kind in KINDS {
        let outcome = sweep(&motion, &clean, part, kind, STRIDE);
        println!("{bus:?}, {part:?}, {}: {outcome:?}", kind.name);
        let Outcome { runs, wrong_runs, wrong_samples, not_recovered, silent, .. } = outcome;
        let transactions = clean.transactions[usize::from(part == Part::Rm3100)] as usize;
        let expected = (kind.faults)(part).len() * (transactions / STRIDE) * 2 / 3;
        assert!(runs >= expected, "{runs} runs of over {expected}: a run has panicked");
        assert_eq!((not_recovered, wrong_runs, wrong_samples), (0, 0, 0), "{kind:?}: {outcome:?}");
        match kind.name {
            "bit flipped" => assert!(outcome.attitude_deg <= 0.1, "{} deg", outcome.attitude_deg),
            "short read" => assert!(outcome.attitude_deg <= 0.15, "{} deg", outcome.attitude_deg),
            // A part without a FIFO leaves no trace of a reading that nobody has read.
            "FIFO overrun, or a reading lost" if part == Part::Rm3100 => {}
            _ => assert!(silent <= 2, "{outcome:?}"),
        }
        assert!(outcome.recovery_us < 400_000, "{kind:?}: {} us", outcome.recovery_us);
    }
}

#[test]
fn every_fault_of_the_gyro_and_accelerometer_is_survived() {
    sweep_all(Bus::Spi, Part::Ism330dhcx);
    sweep_all(Bus::I2c, Part::Ism330dhcx);
}

#[test]
fn every_fault_of_the_magnetometer_is_survived() {
    sweep_all(Bus::Spi, Part::Rm3100);
    sweep_all(Bus::I2c, Part::Rm3100);
}

/// The judge must find faults: one that accepts everything would make the sweep useless.
#[test]
fn the_judge_finds_a_stale_and_a_shifted_and_a_scaled_sample() {
    let (motion, clean) = motion(Bus::Spi);
    let spoil = |spoil: fn(&mut meerkat_mwd::Sample, &meerkat_mwd::Sample)| {
        let mut spoilt = clean.clone();
        let before = spoilt.samples[250].1;
        spoil(&mut spoilt.samples[260].1, &before);
        judge(&motion, &spoilt, 0, &[]).wrong.len()
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
