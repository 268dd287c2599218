//! Models of a gyro with accelerometer and of a magnetometer, read by the adapters that read the real parts: truth
//! in, samples out.

use super::{
    AtPeriod, BusFault, Conversions, FaultyBus, Ism330dhcx, OnI2c, OnSpi, PartError, Rm3100, Schedule, WireMeter,
    faulty_bus::InjectedError, ism330dhcx, rm3100,
};
use crate::{
    sample::Sample,
    sensors::{
        BURST_FRAMES, Combiner, Condition, Counters, InertialReading, MagneticReading, Mounting, PartData, ReadError,
        Rm3100Settings, Trigger,
        blocking::{I2cRegisters, InertialSource, MagneticSource, Part, SpiRegisters, Supervised},
        blocking::{Ism330dhcx as Ism330dhcxAdapter, Rm3100 as Rm3100Adapter},
    },
};
use core::cell::{Cell, RefCell};
use heapless::{Vec, VecView};
use st_mems_bus::blocking::{i2c::I2cBus, spi::SpiBus};

/// Periods of a part after which it is read even without an interrupt.
const OVERDUE_PERIODS: u64 = 3;

/// Modelled parts of a probe, their wires and the time, in place of a board's sensors. `WORDS` is the depth of the
/// FIFO.
pub struct ModelledParts<const WORDS: usize> {
    /// Gyro and accelerometer.
    pub inertial: RefCell<Ism330dhcx<WORDS>>,
    /// Magnetometer.
    pub magnetic: RefCell<Rm3100>,
    /// Time of the board, microseconds.
    pub now_us: Cell<u64>,
    /// Transactions with gyro and accelerometer, and the fault planned for them.
    pub inertial_wire: Cell<Schedule<BusFault>>,
    /// Transactions with the magnetometer, and the fault planned for them.
    pub magnetic_wire: Cell<Schedule<BusFault>>,
    /// Meter of the ticks that wires and models take; `None` if nobody counts them.
    pub meter: Cell<Option<WireMeter>>,
}

impl<const WORDS: usize> ModelledParts<WORDS> {
    /// Parts after power-up at time 0.
    #[must_use]
    pub fn new(conversions: Conversions) -> Self {
        Self {
            inertial: RefCell::new(Ism330dhcx::new(conversions)),
            magnetic: RefCell::new(Rm3100::new(conversions)),
            now_us: Cell::new(0),
            inertial_wire: Cell::new(Schedule::none()),
            magnetic_wire: Cell::new(Schedule::none()),
            meter: Cell::new(None),
        }
    }

    fn wired<'a, B>(&'a self, bus: B, schedule: &'a Cell<Schedule<BusFault>>) -> FaultyBus<'a, B> {
        FaultyBus::new(bus, &self.now_us, schedule).metered(&self.meter)
    }
}

type Spi<'a, P> = FaultyBus<'a, OnSpi<'a, P>>;
type I2c<'a, P> = FaultyBus<'a, OnI2c<'a, P>>;
/// The adapters on SPI.
type InertialOnSpi<'a, const WORDS: usize> = Ism330dhcxAdapter<SpiBus<Spi<'a, Ism330dhcx<WORDS>>>>;
type MagneticOnSpi<'a> = Rm3100Adapter<SpiRegisters<Spi<'a, Rm3100>>>;
/// The adapters on I2C.
type InertialOnI2c<'a, const WORDS: usize> = Ism330dhcxAdapter<I2cBus<I2c<'a, Ism330dhcx<WORDS>>>>;
type MagneticOnI2c<'a> = Rm3100Adapter<I2cRegisters<I2c<'a, Rm3100>>>;
/// An error of an adapter over a modelled bus.
pub type PairError = ReadError<InjectedError<PartError>>;
type BusError = InjectedError<PartError>;

/// The adapters over [`ModelledParts`].
pub struct ModelledPair<'a, const WORDS: usize, I = InertialOnSpi<'a, WORDS>, M = MagneticOnSpi<'a>> {
    parts: &'a ModelledParts<WORDS>,
    inertial: Supervised<AtPeriod<I>, 2>,
    magnetic: Supervised<AtPeriod<M>, 1>,
    combiner: Combiner,
    trigger: Trigger,
    asked_us: [u64; 2],
    conditions: [Condition; 2],
    last_errors: [Option<PairError>; 2],
}

/// Periods of the parts, in place of those of their data sheets, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Periods {
    /// Period of gyro and accelerometer, microseconds; `None` for the data sheet's.
    pub inertial_us: Option<u32>,
    /// Period of the magnetometer, microseconds; `None` for the data sheet's.
    pub magnetic_us: Option<u32>,
}

impl<'a, const WORDS: usize> ModelledPair<'a, WORDS> {
    /// Creates a pair over SPI; nothing is transferred yet. `trigger`: `Interrupt` if [`play`](Self::play) is called
    /// at the very time of an interrupt.
    #[must_use]
    pub fn new(parts: &'a ModelledParts<WORDS>, periods: Periods, watermark_frames: u8, trigger: Trigger) -> Self {
        let now_us = &parts.now_us;
        let inertial = parts.wired(OnSpi::new(&parts.inertial, now_us), &parts.inertial_wire);
        let magnetic = parts.wired(OnSpi::new(&parts.magnetic, now_us), &parts.magnetic_wire);
        Self::over(
            parts,
            Ism330dhcxAdapter::new_spi(inertial, watermark_frames),
            Rm3100Adapter::new_spi(magnetic, Rm3100Settings::default()),
            periods,
            trigger,
        )
    }
}

impl<'a, const WORDS: usize> ModelledPair<'a, WORDS, InertialOnI2c<'a, WORDS>, MagneticOnI2c<'a>> {
    /// Creates a pair as [`new`](ModelledPair::new) does, but over I2C, each part on a bus of its own.
    #[must_use]
    pub fn new_i2c(parts: &'a ModelledParts<WORDS>, periods: Periods, watermark_frames: u8, trigger: Trigger) -> Self {
        let now_us = &parts.now_us;
        let (inertial_at, magnetic_at) = (ism330dhcx::I2C_ADDRESS, rm3100::I2C_ADDRESS);
        let inertial = parts.wired(OnI2c::new(&parts.inertial, now_us, inertial_at), &parts.inertial_wire);
        let magnetic = parts.wired(OnI2c::new(&parts.magnetic, now_us, magnetic_at), &parts.magnetic_wire);
        Self::over(
            parts,
            Ism330dhcxAdapter::new_i2c(inertial, inertial_at, watermark_frames),
            Rm3100Adapter::new_i2c(magnetic, magnetic_at, Rm3100Settings::default()),
            periods,
            trigger,
        )
    }
}

impl<'a, const WORDS: usize, I: Part<2, Error = BusError>, M: Part<1, Error = BusError>> ModelledPair<'a, WORDS, I, M> {
    fn over(parts: &'a ModelledParts<WORDS>, inertial: I, magnetic: M, periods: Periods, trigger: Trigger) -> Self {
        let period_us = periods.inertial_us.unwrap_or(inertial.data().period_us);
        let magnetic_us = periods.magnetic_us.unwrap_or(magnetic.data().period_us);
        let inertial = Supervised::new(AtPeriod { part: inertial, period_us }, Mounting::ALIGNED);
        let magnetic = Supervised::new(AtPeriod { part: magnetic, period_us: magnetic_us }, Mounting::ALIGNED);
        Self {
            parts,
            inertial,
            magnetic,
            combiner: Combiner::new(period_us),
            trigger,
            asked_us: [0; 2],
            conditions: [Condition::Starting; 2],
            last_errors: [None; 2],
        }
    }

    /// Advances the parts to `truth.t_us`; then the adapters read at most one burst each. Their samples are appended
    /// to `samples` while there is room (8 are enough).
    pub fn play(&mut self, truth: &Sample, samples: &mut VecView<Sample>) {
        self.pass_to(truth);
        self.service(samples);
    }

    /// Advances the parts to `truth.t_us`; no adapter runs.
    pub fn pass_to(&mut self, truth: &Sample) {
        // An adapter that waited for its time-out may have moved the clock past the truth's time; it does not go back.
        self.parts.now_us.set(self.parts.now_us.get().max(truth.t_us));
        if let Ok(mut part) = self.parts.inertial.try_borrow_mut() {
            part.play(truth);
        }
        if let Ok(mut part) = self.parts.magnetic.try_borrow_mut() {
            part.play(truth);
        }
    }

    /// Does the work of a board's main loop when an interrupt comes, or when none has come for long: the sampling
    /// path.
    pub fn service(&mut self, samples: &mut VecView<Sample>) {
        let [inertial_interrupt, magnetic_interrupt] = self.interrupts();
        let trigger = |interrupt| if interrupt { self.trigger } else { Trigger::Polled };
        let (inertial_trigger, magnetic_trigger) = (trigger(inertial_interrupt), trigger(magnetic_interrupt));
        let periods_us = [self.inertial.data().period_us, self.magnetic.data().period_us];
        let now_us = self.parts.now_us.get();
        let due = |interrupt, asked_us: u64, period_us: u32, condition| {
            interrupt
                || matches!(condition, Condition::Starting | Condition::Pausing)
                || now_us.saturating_sub(asked_us) >= OVERDUE_PERIODS * u64::from(period_us)
        };
        let ([inertial_us, magnetic_us], [asked, asked_magnetic]) = (periods_us, self.asked_us);
        let [condition, magnetic_condition] = self.conditions;
        if due(magnetic_interrupt, asked_magnetic, magnetic_us, magnetic_condition) {
            let mut readings: Vec<MagneticReading, BURST_FRAMES> = Vec::new();
            let result = self.magnetic.read(now_us, magnetic_trigger, &mut readings);
            self.note(1, now_us, result);
            readings.into_iter().for_each(|reading| self.combiner.magnetic(reading));
        }
        // A time-out has advanced the time: first the parts have to be played to it.
        if self.parts.now_us.get() != now_us {
            return;
        }
        if due(inertial_interrupt, asked, inertial_us, condition) {
            let mut readings: Vec<InertialReading, BURST_FRAMES> = Vec::new();
            let result = self.inertial.read(now_us, inertial_trigger, &mut readings);
            self.note(0, now_us, result);
            for sample in readings.iter().filter_map(|reading| self.combiner.inertial(reading)) {
                let _ = samples.push(sample);
            }
        }
    }

    /// Levels of the parts' interrupt lines: gyro and accelerometer, magnetometer.
    #[must_use]
    pub fn interrupts(&self) -> [bool; 2] {
        let inertial = self.parts.inertial.try_borrow().is_ok_and(|part| part.interrupt());
        let magnetic = self.parts.magnetic.try_borrow().is_ok_and(|part| part.interrupt());
        [inertial, magnetic]
    }

    fn note(&mut self, source: usize, now_us: u64, result: Result<Condition, PairError>) {
        if let (Some(asked_us), Some(condition), Some(last_error)) =
            (self.asked_us.get_mut(source), self.conditions.get_mut(source), self.last_errors.get_mut(source))
        {
            *asked_us = now_us;
            *last_error = result.err();
            *condition = result.unwrap_or(*condition);
        }
    }

    /// Returns the condition of gyro with accelerometer, and of the magnetometer.
    #[must_use]
    pub const fn conditions(&self) -> [Condition; 2] {
        self.conditions
    }

    /// Returns the errors of each adapter's last call.
    #[must_use]
    pub const fn last_errors(&self) -> [Option<PairError>; 2] {
        self.last_errors
    }

    /// Returns the counters of faults.
    #[must_use]
    pub fn counters(&self) -> [Counters; 2] {
        [*self.inertial.counters(), *self.magnetic.counters()]
    }

    /// Ranges, codes and rates of gyro and accelerometer.
    #[must_use]
    pub fn inertial_data(&self) -> PartData<2> {
        self.inertial.data()
    }

    /// Range, code and rate of the magnetometer.
    #[must_use]
    pub fn magnetic_data(&self) -> PartData<1> {
        self.magnetic.data()
    }
}
