//! A part without a bus: an oscillator, a FIFO, and every possible failure.

use std::{cell::RefCell, collections::VecDeque, rc::Rc};

use meerkat_mwd::sensors::{
    BURST_FRAMES, Burst, Frame, InertialData, InertialReading, PartData, SensorData, StartError, StartStep, Trigger,
    blocking::{InertialSource, Part},
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

pub const PERIOD_US: u32 = 5_000;
pub const SETTLING: u16 = 4;
pub const FROZEN: u16 = 20;
pub const GYRO_CLIP: i32 = 2_000_000_000;
pub const START_US: u32 = 1_000;

/// The part as seen from outside.
pub struct World {
    pub now_us: f64,
    pub true_period_us: f64,
    pub fifo_frames: usize,
    pub identity: bool,
    pub configured: bool,
    pub bus_fails: bool,
    pub silent: bool,
    pub frozen: bool,
    pub dead_axis: Option<usize>,
    /// Sensor without codes in any frame, until a start.
    pub codeless: Option<usize>,
    pub clipped: bool,
    pub is_hit: bool,
    pub ready_is_stuck: bool,
    pub starts: Vec<f64>,
    /// Frames that were put out since the beginning.
    pub put_out: i32,
    next_us: f64,
    fifo: VecDeque<Frame<2>>,
    last: Frame<2>,
    overrun: bool,
    /// True if the overrun is told until the FIFO is empty.
    pub overrun_lasts: bool,
    random: Xoshiro128PlusPlus,
}

impl World {
    pub fn new(seed: u64) -> Rc<RefCell<Self>> {
        Rc::new(RefCell::new(Self {
            now_us: 0.0,
            true_period_us: PERIOD_US.into(),
            fifo_frames: 64,
            identity: true,
            configured: false,
            bus_fails: false,
            silent: false,
            frozen: false,
            dead_axis: None,
            codeless: None,
            clipped: false,
            is_hit: false,
            ready_is_stuck: false,
            starts: Vec::new(),
            put_out: 0,
            next_us: 0.0,
            fifo: VecDeque::new(),
            last: Frame::default(),
            overrun: false,
            overrun_lasts: false,
            random: Xoshiro128PlusPlus::seed_from_u64(seed),
        }))
    }

    pub fn uniform(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / 4_294_967_296.0
    }

    fn noise(&mut self) -> i32 {
        (self.random.next_u32() % 5) as i32 - 2
    }

    /// The gyro's x is the time of the frame, in tenths of a microsecond short of ten periods, so that a
    /// stamp can be compared with it.
    fn measure(&mut self) -> Frame<2> {
        let time = (self.next_us * 0.1) as i32;
        let mut gyro = [time, self.noise(), self.noise()];
        let mut accel = [self.noise(), self.noise(), self.noise()];
        if self.is_hit {
            accel[2] = -GYRO_CLIP;
        }
        if let Some(axis) = self.dead_axis {
            gyro[axis] = 7;
        }
        if self.clipped {
            gyro[2] = -GYRO_CLIP;
        }
        let mut codes = [Some(gyro), Some(accel)];
        if let Some(sensor) = self.codeless {
            codes[sensor] = None;
        }
        Frame { codes, temperature: None }
    }

    pub fn advance_to(&mut self, now_us: f64) {
        self.now_us = now_us;
        while self.next_us <= now_us {
            if self.configured && !self.silent {
                if !self.frozen {
                    self.last = self.measure();
                }
                self.put_out += 1;
                self.fifo.push_back(self.last);
                if self.fifo.len() > self.fifo_frames {
                    self.fifo.pop_front();
                    self.overrun = self.fifo_frames > 1;
                }
            }
            self.next_us += self.true_period_us;
        }
    }

    /// The part goes back to its default settings by itself.
    pub fn reset(&mut self) {
        self.configured = false;
        self.codeless = None;
        self.fifo.clear();
    }
}

pub struct FakePart(pub Rc<RefCell<World>>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFailed;

impl Part<2> for FakePart {
    type Error = BusFailed;

    fn data(&self) -> InertialData {
        let sensor = SensorData {
            full_scale: 2e9,
            per_code: 1.0,
            clip_code: GYRO_CLIP,
            latency_s: [0.0; 3],
            noise_density: None,
        };
        PartData {
            name: "fake",
            source: "",
            sensors: [sensor; 2],
            temperature: None,
            period_us: PERIOD_US,
            period_tolerance: 0.1,
            fifo_frames: self.0.borrow().fifo_frames as u16,
            watermark_frames: 1,
            settling_frames: SETTLING,
            frozen_frames: FROZEN,
        }
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<BusFailed>> {
        let mut world = self.0.borrow_mut();
        if step == 0 {
            let now_us = world.now_us;
            world.starts.push(now_us);
            world.reset();
        }
        if world.bus_fails {
            return Err(StartError::Bus(BusFailed));
        }
        if !world.identity {
            return Err(StartError::WrongIdentity { expected: 1, found: 2 });
        }
        if step == 0 {
            return Ok(StartStep::After(START_US));
        }
        world.configured = true;
        Ok(StartStep::Done)
    }

    fn read(&mut self, burst: &mut Burst<2>) -> Result<(), BusFailed> {
        let mut world = self.0.borrow_mut();
        if world.bus_fails {
            return Err(BusFailed);
        }
        burst.overrun = world.overrun;
        if world.ready_is_stuck {
            burst.push(world.last);
            world.fifo.clear();
            world.overrun = false;
            return Ok(());
        }
        for _ in 0..BURST_FRAMES {
            let Some(frame) = world.fifo.pop_front() else { break };
            burst.push(frame);
        }
        burst.left = world.fifo.len() as u16;
        world.overrun &= world.overrun_lasts && burst.left > 0;
        Ok(())
    }

    fn is_configured(&mut self) -> Result<bool, BusFailed> {
        let world = self.0.borrow();
        if world.bus_fails { Err(BusFailed) } else { Ok(world.configured) }
    }
}

/// Reads once, with room for many.
pub fn read(source: &mut impl InertialSource, now_us: u64, trigger: Trigger, into: &mut Vec<InertialReading>) -> bool {
    let mut out = heapless::Vec::<InertialReading, 128>::new();
    let done = source.read(now_us, trigger, &mut out).is_ok();
    into.extend(out);
    done
}

/// Time by which the stamp is later than the truth, microseconds; the code holds it to ten.
pub fn lateness_us(reading: &InertialReading) -> f64 {
    reading.t_us as f64 - f64::from(reading.gyro_rad_s[0]) * 10.0
}
