//! A pair of parts with interrupts of their own, read at the ticks of a clock that follows neither.

use super::fake_part::{BusFailed, FakePart, PERIOD_US, World};
use heapless::VecView;
use meerkat_mwd::{
    Sample, SampleFlags,
    application::{Acquisition, AcquisitionCounts, Interrupts, SampleQueue, Sensors},
    sensors::{
        Condition, Counters, MagneticData, MagneticReading, Mounting, PartData, ReadError, SensorData, Trigger,
        blocking::{InertialSource, MagneticSource, Supervised},
    },
};
use std::{cell::RefCell, rc::Rc};

/// A magnetometer that notes when, and by what, it is said to have been read.
struct Noted(Rc<RefCell<Vec<(u64, Trigger)>>>, Counters);

impl MagneticSource for Noted {
    type Error = BusFailed;

    fn data(&self) -> MagneticData {
        let sensor =
            SensorData { full_scale: 1e3, per_code: 1.0, clip_code: 1_000, latency_s: [0.0; 3], noise_density: None };
        PartData {
            name: "noted",
            source: "",
            sensors: [sensor],
            temperature: None,
            period_us: PERIOD_US,
            period_tolerance: 0.1,
            fifo_frames: 1,
            watermark_frames: 1,
            settling_frames: 0,
            frozen_frames: 20,
        }
    }

    fn counters(&self) -> &Counters {
        &self.1
    }

    fn read(
        &mut self,
        now_us: u64,
        trigger: Trigger,
        _: &mut VecView<MagneticReading>,
    ) -> Result<Condition, ReadError<BusFailed>> {
        self.0.borrow_mut().push((now_us, trigger));
        Ok(Condition::Running)
    }
}

/// The latest multiple of a period until `now_us`.
fn latest(now_us: f64, period_us: f64) -> f64 {
    (now_us / period_us).floor() * period_us
}

#[test]
fn each_part_has_the_time_of_its_own_interrupt() {
    fly(1.0);
}

/// An interrupt of which nobody was told costs its own frame little, and those after it nothing.
#[test]
fn an_interrupt_that_is_missed_leaves_the_clock_as_it_was() {
    fly(0.75);
}

/// Flies with a part of the interrupts told.
fn fly(told: f64) {
    for seed in 0..50 {
        let world = World::new(seed);
        let near = |value: f64| value * (0.95 + 0.1 * world.borrow_mut().uniform());
        let (inertial_period_us, magnetic_period_us) = (near(PERIOD_US.into()), near(3.7 * f64::from(PERIOD_US)));
        world.borrow_mut().true_period_us = inertial_period_us;
        let magnetic = Rc::new(RefCell::new(Vec::new()));
        let inertial = Supervised::new(FakePart(world.clone()), Mounting::ALIGNED);
        let counts = AcquisitionCounts::new();
        let mut queue = SampleQueue::new();
        let (producer, mut waiting) = queue.split();
        let noted = Noted(magnetic.clone(), Counters::default());
        let mut sensors = Sensors::new(inertial, noted, Acquisition::new(producer, &counts));
        let mut samples = Vec::new();
        let mut expected = Vec::new();
        for tick in 1..4_000 {
            let now_us = tick * u64::from(PERIOD_US);
            world.borrow_mut().advance_to(now_us as f64);
            let before_us = (now_us - u64::from(PERIOD_US)) as f64;
            let interrupt = |period_us| Some(latest(now_us as f64, period_us)).filter(|at_us| *at_us > before_us);
            let is_told = |_: &f64| world.borrow_mut().uniform() < told;
            let [inertial_us, magnetic_us] = [inertial_period_us, magnetic_period_us]
                .map(|period_us| interrupt(period_us).filter(is_told).map(|at_us| at_us.ceil() as u64));
            expected.push(magnetic_us.map_or((now_us, Trigger::Polled), |at_us| (at_us, Trigger::Interrupt)));
            sensors.read(tick, now_us, Interrupts { inertial_us, magnetic_us });
            while let Some(acquired) = waiting.dequeue() {
                assert_eq!(u64::from(acquired.read_us), now_us, "seed {seed}");
                samples.push(acquired.sample);
            }
        }
        assert_eq!(*magnetic.borrow(), expected, "seed {seed}");
        // The code of the time holds it to ten microseconds; the clock follows a period that is off.
        let believed = |sample: &&Sample| !sample.flags.contains(SampleFlags::GYRO_MISSING);
        let settled = samples[1_000..].iter().filter(believed);
        let worst_us = settled.map(|sample| sample.t_us as f64 - 10.0 * f64::from(sample.gyro_rad_s[0]));
        let worst_us = worst_us.fold(0.0_f64, |worst, late| worst.max(late.abs()));
        assert!(worst_us < 0.05 * inertial_period_us, "seed {seed}: {worst_us} us");
        assert!(sensors.parts().0.counters().readings as usize >= samples.len());
    }
}

/// The time of an interrupt that was told before, or of one to come, is not believed.
#[test]
fn a_part_without_a_new_interrupt_is_read_at_the_time_of_the_call() {
    let times = Rc::new(RefCell::new(Vec::new()));
    let inertial = Supervised::new(FakePart(World::new(1)), Mounting::ALIGNED);
    let counts = AcquisitionCounts::new();
    let mut queue = SampleQueue::new();
    let noted = Noted(times.clone(), Counters::default());
    let mut sensors = Sensors::new(inertial, noted, Acquisition::new(queue.split().0, &counts));
    for (tick, magnetic_us) in (1..).zip([Some(900), Some(900), None, Some(3_400), Some(9_000), Some(4_000)]) {
        sensors.read(tick, 1_000 * tick, Interrupts { magnetic_us, ..Interrupts::default() });
    }
    let [told, not_told] = [true, false].map(|told| {
        let is = |(_, trigger): &&(u64, Trigger)| told == (*trigger == Trigger::Interrupt);
        times.borrow().iter().filter(is).map(|(at_us, _)| *at_us).collect::<Vec<_>>()
    });
    assert_eq!((told, not_told), (vec![900, 3_400], vec![2_000, 3_000, 5_000, 6_000]));
}
