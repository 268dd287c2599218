//! One run of the models and adapters, with a fault or without.

use super::{
    kinds::{Case, Part},
    motion::Motion,
};
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, InjectedError, ModelledPair, ModelledParts, PartError, Periods, Schedule},
    sensors::{Condition, Counters, Trigger, blocking},
};

/// Depth of the FIFO in words: somewhat more than a burst.
pub const WORDS: usize = 64;

/// Bus that connects the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Bus {
    /// SPI.
    #[default]
    Spi,
    /// I2C.
    I2c,
}

/// Result of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Bus that connected the parts.
    pub bus: Bus,
    /// The samples, and the times at which they came out, microseconds.
    pub samples: Vec<(u64, Sample)>,
    /// Counters at the end, gyro and magnetometer.
    pub counters: [Counters; 2],
    /// Number of transactions with each.
    pub transactions: [u32; 2],
    /// Bytes moved with each.
    pub bytes: [u64; 2],
    /// Time at which the fault struck, microseconds.
    pub struck_us: Option<u64>,
    /// Time of an adapter's first error, count or condition after that, microseconds.
    pub noticed_us: Option<u64>,
    /// Conditions of both parts at the end.
    pub conditions: [Condition; 2],
}

/// Plays a motion through the models, with a fault or none.
#[must_use]
pub fn run(motion: &Motion, bus: Bus, case: Option<&Case>) -> Run {
    let parts = ModelledParts::<WORDS>::new(Conversions::AtItsRate);
    if let Some(case) = case {
        if let Some(injection) = case.part_injection() {
            match case.part {
                Part::Ism330dhcx => parts.inertial.borrow_mut().inject(injection),
                Part::Rm3100 => parts.magnetic.borrow_mut().inject(injection),
            }
        }
        if let Some(injection) = case.wire_injection() {
            let wire = if case.part == Part::Ism330dhcx { &parts.inertial_wire } else { &parts.magnetic_wire };
            wire.set(Schedule::of(injection));
        }
    }
    let (periods, trigger) = (Periods::default(), Trigger::Polled);
    let run = match bus {
        Bus::Spi => run_pair(motion, case, &parts, ModelledPair::new(&parts, periods, 1, trigger)),
        Bus::I2c => run_pair(motion, case, &parts, ModelledPair::new_i2c(&parts, periods, 1, trigger)),
    };
    Run { bus, ..run }
}

type BusError = InjectedError<PartError>;

fn run_pair<I: blocking::Part<2, Error = BusError>, M: blocking::Part<1, Error = BusError>>(
    motion: &Motion,
    case: Option<&Case>,
    parts: &ModelledParts<WORDS>,
    mut pair: ModelledPair<'_, WORDS, I, M>,
) -> Run {
    let mut run = Run::default();
    let mut before = pair.counters();
    for truth in &motion.seen {
        // A time-out has let time pass without the loop: skip the steps it missed.
        if truth.t_us < parts.now_us.get() {
            pair.pass_to(truth);
            continue;
        }
        let mut samples = heapless::Vec::<Sample, 16>::new();
        pair.play(truth, &mut samples);
        let now_us = parts.now_us.get();
        run.samples.extend(samples.into_iter().map(|sample| (now_us, sample)));
        run.struck_us = run.struck_us.or_else(|| {
            let [part, wire] = match case?.part {
                Part::Ism330dhcx => {
                    [parts.inertial.borrow().schedule().struck_at_us(), parts.inertial_wire.get().struck_at_us()]
                }
                Part::Rm3100 => {
                    [parts.magnetic.borrow().schedule().struck_at_us(), parts.magnetic_wire.get().struck_at_us()]
                }
            };
            part.or(wire)
        });
        let counters = pair.counters();
        if run.struck_us.is_some() && run.noticed_us.is_none() {
            let source = usize::from(case.is_some_and(|case| case.part == Part::Rm3100));
            let quiet = |mut counters: Counters| {
                counters.readings = 0;
                counters
            };
            let said = pair.last_errors()[source].is_some() || quiet(counters[source]) != quiet(before[source]);
            run.noticed_us = said.then_some(now_us);
        }
        before = counters;
    }
    run.counters = before;
    run.conditions = pair.conditions();
    let wires = [parts.inertial_wire.get(), parts.magnetic_wire.get()];
    run.transactions = wires.map(|wire| wire.transactions());
    run.bytes = wires.map(|wire| wire.bytes());
    run
}
