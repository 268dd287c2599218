//! A part that misbehaves, and the readings handed out meanwhile.

use std::{cell::RefCell, rc::Rc};

use meerkat_mwd::{
    SampleFlags,
    sensors::{
        InertialReading, Mounting, Trigger,
        blocking::{InertialSource, Supervised},
    },
};

use super::fake_part::{FROZEN, FakePart, GYRO_CLIP, PERIOD_US, SETTLING, World, lateness_us, read};

struct Run {
    world: Rc<RefCell<World>>,
    source: Supervised<FakePart, 2>,
    readings: Vec<InertialReading>,
    now_ms: u32,
}

impl Run {
    fn new(seed: u64) -> Self {
        let world = World::new(seed);
        let source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        Self { world, source, readings: Vec::new(), now_ms: 0 }
    }

    /// Reads every 5 ms until then.
    fn until_ms(&mut self, ms: u32) -> &mut Self {
        while self.now_ms < ms {
            self.world.borrow_mut().advance_to(f64::from(self.now_ms) * 1e3);
            read(&mut self.source, u64::from(self.now_ms) * 1_000, Trigger::Polled, &mut self.readings);
            self.now_ms += 5;
        }
        self
    }

    fn but(&mut self, change: impl FnOnce(&mut World)) -> &mut Self {
        change(&mut self.world.borrow_mut());
        self
    }

    fn after_ms(&self, ms: u32) -> impl Iterator<Item = &InertialReading> {
        self.readings.iter().filter(move |reading| reading.t_us > u64::from(ms) * 1_000)
    }

    fn every_believed_reading_has_its_time(&self) {
        for reading in self.readings.iter().filter(|reading| !reading.flags.contains(SampleFlags::GYRO_MISSING)) {
            let late_us = lateness_us(reading);
            assert!(late_us.abs() < 1.05 * f64::from(PERIOD_US), "{} us late at {}", late_us, reading.t_us);
        }
    }
}

#[test]
fn a_blow_to_the_end_of_the_range_that_lasts_one_sample_is_clipped() {
    let mut run = Run::new(2);
    for ms in (1_000..3_000).step_by(500) {
        run.until_ms(ms).but(|world| world.is_hit = true).until_ms(ms + 5).but(|world| world.is_hit = false);
    }
    run.until_ms(4_000);
    let clipped = run.readings.iter().filter(|reading| reading.flags.contains(SampleFlags::ACCEL_CLIPPED));
    assert_eq!(clipped.count(), 4);
}

#[test]
fn a_reset_is_found_before_its_frames_are_believed_and_the_part_started_anew() {
    let mut run = Run::new(1);
    run.until_ms(1_000).but(World::reset).until_ms(3_000);
    let counters = run.source.counters();
    assert_eq!((counters.resets, counters.restarts, counters.bus_errors), (1, 1, 0));
    let first = run.after_ms(1_000).next().unwrap().t_us;
    let settled_us = 1_000_000 + u64::from(SETTLING + 7) * u64::from(PERIOD_US);
    assert!(first < settled_us, "measures again after {} us", first - 1_000_000);
    run.every_believed_reading_has_its_time();
}

#[test]
fn a_dead_bus_is_left_alone_for_longer_and_longer() {
    let mut run = Run::new(2);
    run.until_ms(1_000).but(|world| world.bus_fails = true).until_ms(61_000);
    let (starts, attempts) = (run.world.borrow().starts.clone(), run.world.borrow().starts.len());
    // 10 ms doubled to 5.12 s are ten starts in 10 s, and then one in 5.12 s.
    assert!((15..25).contains(&attempts), "{attempts} starts in a minute");
    assert!(starts[1..].windows(3).all(|three| three[2] - three[1] >= three[1] - three[0] - 5e3));
    run.but(|world| world.bus_fails = false).until_ms(70_000);
    assert!(run.after_ms(66_500).next().is_some());
    assert!(run.source.counters().bus_errors as usize >= attempts);
    run.every_believed_reading_has_its_time();
    // It is well for long: the next trouble gets a short pause again.
    run.but(|world| world.bus_fails = true).until_ms(70_100);
    run.but(|world| world.bus_fails = false).until_ms(70_300);
    assert!(run.after_ms(70_200).next().is_some());
}

/// Four failures in a row cost no restart, and what waits in the FIFO meanwhile is read.
#[test]
fn a_bus_locked_for_20_ms_costs_nothing() {
    let mut run = Run::new(3);
    run.until_ms(1_000).but(|world| world.bus_fails = true).until_ms(1_020);
    run.but(|world| world.bus_fails = false).until_ms(2_000);
    assert_eq!((run.source.counters().restarts, run.source.counters().lost_frames), (0, 0));
    assert_eq!(run.source.counters().bus_errors, 4);
    let times: Vec<u64> = run.readings.iter().map(|reading| reading.t_us).collect();
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] < 2 * u64::from(PERIOD_US)));
    run.every_believed_reading_has_its_time();
}

#[test]
fn another_part_is_never_read() {
    let mut run = Run::new(4);
    run.but(|world| world.identity = false).until_ms(2_000);
    assert!(run.readings.is_empty());
    assert_eq!(run.source.counters().wrong_identity as usize, run.world.borrow().starts.len());
    run.but(|world| world.identity = true).until_ms(6_000);
    assert!(!run.readings.is_empty());
}

#[test]
fn a_silent_part_is_started_anew() {
    let mut run = Run::new(5);
    run.until_ms(1_000).but(|world| world.silent = true).until_ms(1_200);
    assert!(run.source.counters().silences >= 1);
    run.but(|world| world.silent = false).until_ms(3_000);
    assert!(run.after_ms(1_700).next().is_some());
    run.every_believed_reading_has_its_time();
}

/// The other sensor is read until the start.
#[test]
fn a_part_of_which_one_sensor_falls_silent_is_started_anew() {
    for (sensor, missing) in [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING].into_iter().enumerate() {
        let mut run = Run::new(13 + sensor as u64);
        run.until_ms(1_000).but(|world| world.codeless = Some(sensor)).until_ms(3_000);
        let counters = run.source.counters();
        assert_eq!((counters.silences, counters.restarts, counters.corrupt_frames), (1, 1, 0));
        assert!(run.after_ms(1_005).next().unwrap().flags.contains(missing));
        let back = run.after_ms(1_350).filter(|reading| !reading.flags.contains(missing)).count();
        assert!(back > 300, "{back} readings of both sensors");
        let times: Vec<u64> = run.readings.iter().map(|reading| reading.t_us).collect();
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] < 60_000));
        run.every_believed_reading_has_its_time();
    }
}

/// Each start is of a silence of its own, and costs the other sensor little.
#[test]
fn a_sensor_that_stays_silent_has_its_part_started_after_longer_and_longer() {
    let mut run = Run::new(15);
    for ms in (1_000..61_000).step_by(5) {
        run.until_ms(ms).but(|world| world.codeless = Some(1));
    }
    let counters = run.source.counters();
    assert!((15..25).contains(&counters.restarts), "{} restarts in a minute", counters.restarts);
    assert!(counters.silences.abs_diff(counters.restarts) <= 1);
    assert!(run.readings.len() > 11_500);
}

/// In a backlog the BMI088's accelerometer has codes for the newest frame alone.
#[test]
fn frames_without_codes_before_one_with_them_are_no_silence() {
    let mut run = Run::new(16);
    for ms in (1_000..5_000).step_by(500) {
        run.until_ms(ms + 5).but(|world| world.codeless = Some(1)).until_ms(ms + 200);
        run.but(|world| world.codeless = None).until_ms(ms + 205);
        // Nothing is read for 0.3 s.
        run.but(|world| {
            world.codeless = Some(1);
            world.advance_to(f64::from(ms + 494) * 1e3);
            world.codeless = None;
        });
        run.now_ms = ms + 500;
    }
    run.until_ms(6_000);
    assert_eq!((run.source.counters().silences, run.source.counters().restarts), (0, 0));
}

#[test]
fn a_frozen_output_is_flagged_until_it_moves_again() {
    let mut run = Run::new(6);
    run.until_ms(1_000)
        .but(|world| world.frozen = true)
        .until_ms(5_000)
        .but(|world| world.frozen = false)
        .until_ms(20_000);
    let limit_us = 1_000_000 + u64::from(FROZEN + 2) * u64::from(PERIOD_US);
    let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING;
    for reading in &run.readings {
        let expected = reading.t_us > limit_us && reading.t_us < 4_990_000;
        assert!(!expected || reading.flags.contains(missing), "believed at {}", reading.t_us);
        assert!(!expected || reading.gyro_rad_s == [0.0; 3]);
        assert!(reading.t_us < 5_100_000 || !reading.flags.intersects(missing), "not believed at {}", reading.t_us);
    }
    assert_eq!(run.source.counters().frozen, 1);
    assert!(run.source.counters().restarts >= 1);
}

#[test]
fn one_dead_axis_takes_its_sensor_and_not_the_other() {
    for axis in [1, 2] {
        let mut run = Run::new(7 + axis as u64);
        run.until_ms(1_000).but(|world| world.dead_axis = Some(axis)).until_ms(6_000);
        let limit_us = 1_000 + u32::from(3 * FROZEN + 2) * PERIOD_US / 1_000;
        assert!(run.after_ms(limit_us).all(|reading| reading.flags.contains(SampleFlags::GYRO_MISSING)));
        assert!(run.readings.iter().all(|reading| !reading.flags.contains(SampleFlags::ACCEL_MISSING)));
    }
}

/// An hour of a sound part whose noise is only five codes wide: its accelerometer, at rest, repeats itself
/// once in 125 readings.
#[test]
fn hardly_anything_is_suspected_in_an_hour_of_a_sound_part() {
    let mut run = Run::new(9);
    run.until_ms(3_600_000);
    let flags = |reading: &InertialReading| reading.flags - SampleFlags::TEMPERATURE_MISSING;
    assert!(run.readings.iter().all(|reading| (flags(reading) - SampleFlags::ACCEL_MISSING).is_empty()));
    let doubted = run.readings.iter().filter(|reading| !flags(reading).is_empty()).count();
    assert!(doubted * 1_000 < run.readings.len(), "{doubted} of {}", run.readings.len());
    let counters = run.source.counters();
    assert_eq!((counters.frozen, counters.restarts, counters.lost_frames, counters.early_frames), (0, 0, 0, 0));
    assert!(run.readings.len() >= 719_900);
}

#[test]
fn the_end_of_the_range_is_flagged_and_is_not_frozen() {
    let mut run = Run::new(10);
    run.until_ms(1_000).but(|world| world.clipped = true).until_ms(3_000);
    // The first one may be a flipped bit.
    assert!(run.after_ms(1_020).all(|reading| reading.flags.contains(SampleFlags::GYRO_CLIPPED)));
    assert!(run.after_ms(1_020).all(|reading| reading.gyro_rad_s[2] == -GYRO_CLIP as f32));
    assert_eq!(run.source.counters().frozen, 0);
}

/// A part without a FIFO, polled more often than it measures, whose data-ready bit stays set.
#[test]
fn a_stuck_data_ready_does_not_repeat_readings() {
    let mut run = Run::new(11);
    run.but(|world| (world.fifo_frames, world.true_period_us) = (1, f64::from(PERIOD_US)));
    run.source = Supervised::new(FakePart(run.world.clone()), Mounting::ALIGNED);
    run.until_ms(1_000).but(|world| world.ready_is_stuck = true);
    for now_us in (1_000_000..3_000_000_u64).step_by(2_000) {
        run.world.borrow_mut().advance_to(now_us as f64);
        read(&mut run.source, now_us, Trigger::Polled, &mut run.readings);
    }
    let times: Vec<f32> = run.readings.iter().map(|reading| reading.gyro_rad_s[0]).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(run.source.counters().early_frames > 500);
    run.every_believed_reading_has_its_time();
}
