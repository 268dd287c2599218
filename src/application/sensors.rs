//! The sensors of a real board, read in PendSV once a round of the sample clock.

use super::Acquisition;
use crate::{
    config::{FullScale, Latency},
    sensors::{
        BURST_FRAMES, Combiner, InertialReading, MagneticReading, Trigger,
        blocking::{InertialSource, MagneticSource},
    },
};
use heapless::Vec;

/// Times of the parts' interrupts since the last reading, microseconds. `None`: there was none, or the part is polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Interrupts {
    /// Interrupt of the gyro and accelerometer.
    pub inertial_us: Option<u64>,
    /// Interrupt of the magnetometer.
    pub magnetic_us: Option<u64>,
}

/// Inertial part and magnetometer, and the queue for their samples.
pub struct Sensors<'a, I, M> {
    inertial: I,
    magnetic: M,
    combiner: Combiner,
    acquisition: Acquisition<'a>,
    tick: u64,
    /// Times at which the inertial part and the magnetometer were read last.
    read_us: [u64; 2],
}

impl<'a, I: InertialSource, M: MagneticSource> Sensors<'a, I, M> {
    /// Creates the pair. Touches no bus.
    pub fn new(inertial: I, magnetic: M, acquisition: Acquisition<'a>) -> Self {
        let combiner = Combiner::new(inertial.data().period_us);
        Self { inertial, magnetic, combiner, acquisition, tick: 0, read_us: [0; 2] }
    }

    /// Reads what the parts have measured since the last tick of the sample clock. Call it at each tick, whether or not
    /// a part has anything to say: this starts a part anew that has failed, and the watchdog is fed only while it is
    /// called. `tick` is one higher each time, also for a tick without a call, which counts as missed. `now_us` is the
    /// time of the call.
    pub fn read(&mut self, tick: u64, now_us: u64, interrupts: Interrupts) {
        let missed = tick.saturating_sub(self.tick).saturating_sub(1);
        self.tick = tick;
        // A missed tick loses no sample: samples wait in the part's FIFO.
        self.acquisition.served(u32::try_from(missed).unwrap_or(u32::MAX));

        let [(inertial_us, inertial_trigger), (magnetic_us, magnetic_trigger)] = self.times(now_us, interrupts);
        let mut readings = Vec::<MagneticReading, BURST_FRAMES>::new();
        let magnetic = self.magnetic.read(magnetic_us, magnetic_trigger, &mut readings);
        for reading in readings {
            self.combiner.magnetic(reading);
        }
        let mut readings = Vec::<InertialReading, BURST_FRAMES>::new();
        let inertial = self.inertial.read(inertial_us, inertial_trigger, &mut readings);
        for sample in readings.iter().filter_map(|reading| self.combiner.inertial(reading)) {
            self.acquisition.put(sample, now_us);
        }
        if magnetic.is_err() || inertial.is_err() {
            self.acquisition.fault();
        }
    }

    /// The two parts, with their counters and settings.
    pub const fn parts(&self) -> (&I, &M) {
        (&self.inertial, &self.magnetic)
    }

    /// Times at which the parts are read: their interrupts', or that of the call.
    fn times(&mut self, now_us: u64, interrupts: Interrupts) -> [(u64, Trigger); 2] {
        let [inertial_us, magnetic_us] = &mut self.read_us;
        [(inertial_us, interrupts.inertial_us), (magnetic_us, interrupts.magnetic_us)].map(|(read_us, interrupt_us)| {
            let since_the_last = |at_us: &u64| *at_us > *read_us && *at_us <= now_us;
            let at = interrupt_us.filter(since_the_last).map(|at_us| (at_us, Trigger::Interrupt));
            let at = at.unwrap_or((now_us, Trigger::Polled));
            *read_us = at.0;
            at
        })
    }
}

/// Returns sample period (microseconds), full scales and latencies of a pair of parts, from their data sheets.
pub fn data_sheet<I: InertialSource, M: MagneticSource>(inertial: &I, magnetic: &M) -> (u32, FullScale, Latency) {
    let (inertial, magnetic) = (inertial.data(), magnetic.data());
    (inertial.period_us, FullScale::of_parts(&inertial, &magnetic), Latency::of_parts(&inertial, &magnetic))
}
