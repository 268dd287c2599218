use meerkat_mwd::{
    SampleFlags,
    sensors::{Combiner, InertialReading, MagneticReading},
};
use proptest::prelude::*;

const PERIOD_US: u64 = 5_000;

/// A magnetic reading that carries its time in its value.
fn magnetic(t_us: u64, flags: SampleFlags) -> MagneticReading {
    MagneticReading { t_us, mag_ut: [t_us as f32, 1.0, 2.0], flags, ..MagneticReading::default() }
}

proptest! {
    /// Every magnetic reading is in one sample, or counted as lost, or still waits; one that is in a sample
    /// is at most one and a half periods old, and younger than its sample by no more than stamps err.
    #[test]
    fn readings_are_neither_lost_in_silence_nor_doubled(
        steps in prop::collection::vec(1_000_u64..40_000, 1..60), late in prop::collection::vec(0_usize..3, 60), bursts in 1_usize..8
    ) {
        let mut combiner = Combiner::new(PERIOD_US as u32);
        let mut t_us = 20_000;
        let mut coming: Vec<MagneticReading> = Vec::new();
        for (step, late) in steps.iter().zip(late) {
            t_us += step;
            // Now and then one comes with a later burst than its time's.
            coming.push(MagneticReading { temperature_c: late as f32, ..magnetic(t_us, SampleFlags::empty()) });
        }
        let (given, end_us) = (coming.len(), t_us + 100_000);
        let (mut with, mut samples, mut k) = (0, 0, 0);
        let mut next = coming.into_iter().peekable();
        while k * PERIOD_US < end_us {
            let burst: Vec<u64> = (k..k + bursts as u64).map(|k| k * PERIOD_US).collect();
            k += bursts as u64;
            let now_us = k * PERIOD_US;
            while let Some(reading) = next.next_if(|reading| reading.t_us + reading.temperature_c as u64 * 20_000 <= now_us) {
                combiner.magnetic(reading);
            }
            for t_us in burst {
                let sample = combiner.inertial(&InertialReading { t_us, ..InertialReading::default() }).unwrap();
                samples += 1;
                assert_eq!(sample.t_us, t_us);
                if !sample.flags.contains(SampleFlags::MAG_MISSING) {
                    with += 1;
                    let age_us = t_us as f32 - sample.mag_ut[0];
                    assert!((-(PERIOD_US as f32) / 16.0..=1.5 * PERIOD_US as f32).contains(&age_us));
                }
            }
        }
        prop_assert_eq!(samples, k as usize);
        prop_assert_eq!(with + combiner.lost_magnetic() as usize + next.count(), given);
    }
}

/// 100 Hz of field beside 200 Hz of the rest: every second sample has it.
#[test]
fn a_slower_magnetometer_is_missing_in_between() {
    let mut combiner = Combiner::new(PERIOD_US as u32);
    let mut seen = Vec::new();
    for k in 1..=400_u64 {
        if k % 2 == 0 {
            combiner.magnetic(magnetic(k * PERIOD_US - 700, SampleFlags::empty()));
        }
        let reading =
            InertialReading { t_us: k * PERIOD_US, flags: SampleFlags::ACCEL_CLIPPED, ..InertialReading::default() };
        seen.push(combiner.inertial(&reading).unwrap().flags);
    }
    assert!(
        seen.chunks(2)
            .all(|pair| pair == [SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_MISSING, SampleFlags::ACCEL_CLIPPED])
    );
    assert_eq!(combiner.lost_magnetic(), 0);
}

#[test]
fn a_magnetometers_fault_is_not_the_inertial_sensors() {
    let mut combiner = Combiner::new(PERIOD_US as u32);
    for (t_us, flags, expected) in [
        (5_000, SampleFlags::FAULT, SampleFlags::MAG_MISSING),
        (10_000, SampleFlags::MAG_MISSING, SampleFlags::MAG_MISSING),
        (15_000, SampleFlags::MAG_CLIPPED, SampleFlags::MAG_CLIPPED),
        (20_000, SampleFlags::TEMPERATURE_MISSING, SampleFlags::empty()),
    ] {
        combiner.magnetic(magnetic(t_us, flags));
        let sample = combiner.inertial(&InertialReading { t_us, ..InertialReading::default() }).unwrap();
        assert_eq!(sample.flags, expected);
    }
    assert_eq!(combiner.inertial(&InertialReading { t_us: 20_000, ..InertialReading::default() }), None);
    assert_eq!(combiner.lost_inertial(), 1);
}

/// Interrupts of both: whenever the field comes between two samples, none is lost.
#[test]
fn a_field_that_comes_between_samples_is_not_lost() {
    let mut combiner = Combiner::new(PERIOD_US as u32);
    let (mut with, mut ages_us, mut next_us) = (0, 0.0, 6_831);
    for k in 1..=4_000_u64 {
        let mut given = 0;
        while next_us <= k * PERIOD_US {
            combiner.magnetic(magnetic(next_us, SampleFlags::empty()));
            next_us += 6_831;
            given += 1;
        }
        let sample = combiner.inertial(&InertialReading { t_us: k * PERIOD_US, ..InertialReading::default() }).unwrap();
        assert_eq!(given, u32::from(!sample.flags.contains(SampleFlags::MAG_MISSING)));
        if given > 0 {
            (with, ages_us) = (with + 1, ages_us + (k * PERIOD_US) as f64 - f64::from(sample.mag_ut[0]));
        }
    }
    assert_eq!(combiner.lost_magnetic(), 0);
    approx::assert_relative_eq!(
        ages_us / f64::from(with) * 1e-6,
        f64::from(combiner.mean_delay_s()),
        max_relative = 0.02
    );
}

/// Two parts that convert together, with stamps that err by up to a fiftieth of a period: the field is never a sample
/// old.
#[test]
fn a_field_of_the_samples_time_is_in_its_sample_however_the_stamps_err() {
    let mut combiner = Combiner::new(PERIOD_US as u32);
    for k in 1..=1_000_u64 {
        let [magnetic_us, t_us] = [37, 61].map(|step| k * PERIOD_US + k * step % (PERIOD_US / 50));
        combiner.magnetic(magnetic(magnetic_us, SampleFlags::empty()));
        let sample = combiner.inertial(&InertialReading { t_us, ..InertialReading::default() }).unwrap();
        assert_eq!(sample.mag_ut[0], magnetic_us as f32);
    }
    assert_eq!(combiner.lost_magnetic(), 0);
}
