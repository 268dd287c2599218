//! Stamps of readings against the times at which the part really measured.

use meerkat_mwd::{
    SampleFlags,
    sensors::{
        InertialReading, Mounting, Trigger,
        blocking::{InertialSource, Supervised},
    },
};

use super::fake_part::{FakePart, PERIOD_US, World, lateness_us, read};

/// Oscillators off by up to 8 %, polls at irregular times, from every period to every eighth: polled stamps
/// are within a period of the truth, and every frame comes out once.
#[test]
fn polled_stamps_are_within_a_period_and_nothing_is_lost() {
    for seed in 0..300 {
        let world = World::new(seed);
        let offset = (world.borrow_mut().uniform() - 0.5) * 0.16;
        world.borrow_mut().true_period_us = f64::from(PERIOD_US) * (1.0 + offset);
        let mean_us = f64::from(PERIOD_US) * (0.3 + 8.0 * world.borrow_mut().uniform());
        let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let (mut now_us, mut readings) = (0.0, Vec::new());
        while now_us < 30e6 {
            world.borrow_mut().advance_to(now_us);
            read(&mut source, now_us as u64, Trigger::Polled, &mut readings);
            now_us += mean_us * (0.5 + world.borrow_mut().uniform());
        }
        assert!(readings.windows(2).all(|pair| pair[0].t_us < pair[1].t_us), "seed {seed}");
        let counters = *source.counters();
        assert_eq!((counters.lost_frames, counters.early_frames, counters.restarts), (0, 0, 0), "seed {seed}");
        // An axis that has not moved since the start is not believed.
        let dead = |reading: &&InertialReading| reading.flags.contains(SampleFlags::GYRO_MISSING);
        let times: Vec<f64> =
            readings.iter().skip_while(dead).map(|reading| f64::from(reading.gyro_rad_s[0])).collect();
        assert!(times.len() + 3 > readings.len(), "seed {seed}");
        let steps: Vec<f64> = times.windows(2).map(|pair| (pair[1] - pair[0]) * 10.0).collect();
        assert!(
            steps.iter().all(|step| (step - world.borrow().true_period_us).abs() < 30.0),
            "seed {seed}: a frame is missing"
        );
        for reading in readings.iter().skip(1_500) {
            let late_us = lateness_us(reading);
            assert!(
                late_us.abs() < 1.05 * world.borrow().true_period_us,
                "seed {seed}: {late_us} of {} us",
                world.borrow().true_period_us
            );
        }
        // Once settled, steps between stamps are the part's own, except for a few bursts that correct the
        // phase.
        let period_us = world.borrow().true_period_us;
        let steps = readings[2_000..].windows(2).map(|pair| (pair[1].t_us - pair[0].t_us) as f64);
        let off = steps.filter(|step_us| (step_us / period_us - 1.0).abs() > 0.05).count();
        assert!(off < readings.len() / 20, "seed {seed}: {off} steps of {}", readings.len());
    }
}

/// With the interrupt's time, which may be late by up to 200 us, stamps are right to as much.
#[test]
fn stamps_follow_the_interrupt() {
    for seed in 0..20 {
        let world = World::new(seed);
        let offset = (world.borrow_mut().uniform() - 0.5) * 0.16;
        world.borrow_mut().true_period_us = f64::from(PERIOD_US) * (1.0 + offset);
        let watermark = 1.0 + f64::from((seed % 4) as u32);
        let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let (mut k, mut readings) = (0.0, Vec::new());
        while k < 6_000.0 {
            let put_out_us = k * world.borrow().true_period_us;
            let now_us = put_out_us + 200.0 * world.borrow_mut().uniform();
            world.borrow_mut().advance_to(now_us);
            read(&mut source, now_us as u64, Trigger::Interrupt, &mut readings);
            k += watermark;
        }
        assert_eq!(source.counters().lost_frames, 0, "seed {seed}");
        for reading in readings.iter().skip(1_000) {
            let late_us = lateness_us(reading);
            assert!((-30.0..230.0).contains(&late_us), "seed {seed}: {late_us} us");
        }
    }
}

/// Nobody reads for longer than the FIFO lasts: what is lost is counted, and the rest has its right time.
#[test]
fn an_overrun_is_counted_and_the_rest_has_its_time() {
    for seed in 0..20 {
        let world = World::new(seed);
        let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let mut readings = Vec::new();
        let run = |source: &mut Supervised<FakePart, 2>, from_ms: u32, to_ms: u32, readings: &mut Vec<_>| {
            for ms in (from_ms..to_ms).step_by(7) {
                world.borrow_mut().advance_to(f64::from(ms) * 1e3);
                read(source, u64::from(ms) * 1_000, Trigger::Polled, readings);
            }
        };
        run(&mut source, 0, 5_000, &mut readings);
        let before = readings.len();
        let gap_ms = 400 + 10 * seed as u32;
        run(&mut source, 5_000 + gap_ms, 8_000, &mut readings);
        assert_eq!(source.counters().overruns, 1);
        let missing =
            (lateness_us(&readings[before - 1]), readings[before].gyro_rad_s[0] - readings[before - 1].gyro_rad_s[0]);
        let lost = f64::from(missing.1) * 10.0 / f64::from(PERIOD_US) - 1.0;
        assert!(
            (f64::from(source.counters().lost_frames) - lost).abs() <= 1.0,
            "{} and {lost}",
            source.counters().lost_frames
        );
        assert!(readings.iter().all(|reading| lateness_us(reading).abs() < 1.05 * f64::from(PERIOD_US)));
    }
}

/// A part tells its overrun until its FIFO is empty, and there is room for a few readings at a time: what waits has its
/// own time.
#[test]
fn a_backlog_after_an_overrun_that_lasts_has_its_time() {
    for seed in 0..20 {
        let world = World::new(seed);
        world.borrow_mut().overrun_lasts = true;
        let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let mut readings = Vec::new();
        let stall_ms = 2_000..2_400 + 60 * seed as u32;
        for ms in (0..6_000).step_by(5).filter(|ms| !stall_ms.contains(ms)) {
            world.borrow_mut().advance_to(f64::from(ms) * 1e3);
            let mut out = heapless::Vec::<_, 10>::new();
            let _ = source.read(u64::from(ms) * 1_000, Trigger::Polled, &mut out);
            readings.extend(out);
        }
        let latest = readings.iter().map(|reading| lateness_us(reading).abs()).fold(0.0, f64::max);
        assert!(latest < 1.05 * f64::from(PERIOD_US), "{seed}: {latest} us");
        assert!(readings.len() > 700, "{seed}: {}", readings.len());
    }
}

/// Room for a few readings only: the rest stays in the part and comes with its own time.
#[test]
fn what_has_no_room_stays_in_the_part() {
    let world = World::new(1);
    let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
    let mut readings = Vec::new();
    for ms in 0..20_000_u32 {
        world.borrow_mut().advance_to(f64::from(ms) * 1e3);
        // Every 250 ms there is room for only 8 at a time: 50 frames wait.
        if ms < 10 || ms % 250 < 20 {
            let mut out = heapless::Vec::<_, 10>::new();
            let _ = source.read(u64::from(ms) * 1_000, Trigger::Polled, &mut out);
            readings.extend(out);
        }
    }
    let counters = source.counters();
    assert_eq!((counters.lost_frames, counters.early_frames, counters.overruns), (0, 0, 0));
    assert!(readings.len() > 3_900, "{}", readings.len());
    assert!(readings.iter().all(|reading| lateness_us(reading).abs() < 1.05 * f64::from(PERIOD_US)));
}

/// Without a FIFO, polled more slowly than it measures: of the frames that are over-written most are counted,
/// and none too many.
#[test]
fn without_a_fifo_what_was_overwritten_is_counted() {
    for seed in 0..20 {
        let world = World::new(seed);
        world.borrow_mut().fifo_frames = 1;
        let mut source = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let (mut now_us, mut readings) = (0.0, Vec::new());
        while now_us < 60e6 {
            world.borrow_mut().advance_to(now_us);
            read(&mut source, now_us as u64, Trigger::Polled, &mut readings);
            now_us += f64::from(PERIOD_US) * (0.5 + 2.0 * world.borrow_mut().uniform());
        }
        let gone =
            f64::from(readings.last().unwrap().gyro_rad_s[0] - readings[0].gyro_rad_s[0]) * 10.0 / f64::from(PERIOD_US);
        let lost = gone.round() as usize + 1 - readings.len();
        let counted = source.counters().lost_frames as usize;
        assert!(counted <= lost + 2 && counted * 4 > lost * 3, "seed {seed}: {counted} of {lost}");
        assert!(readings.iter().skip(100).all(|reading| lateness_us(reading).abs() < 1.1 * f64::from(PERIOD_US)));
    }
}
