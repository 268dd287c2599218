//! Model of the PNI RM3100, magnetometer: PNI document 1017252 (r03), "RM3100 & RM2100 Sensor Suite User Manual".
//!
//! Modelled: revision, cycle counts with their gain and time, continuous mode with its update rate and the order of
//! the axes (each axis has the field of the middle of its own time), single measurements, data ready with what clears
//! it, and two traps of section 5.2: reading CMM, or writing TMRC, ends the continuous mode. The lower bits of STATUS
//! are indeterminate (section 5.4.1) and read as a constant.
//!
//! Not modelled: alarms, built-in self-test, the reasons of a refusal (HSHAKE's NACK bits), DRDY after a single axis,
//! the 7 % spread of the update rate. Beyond its range of 800 uT (table 3-1) nothing is documented: the model limits
//! the reading to the range.

mod registers;

use super::{
    conversion::{Conversions, Played, nanoseconds, quantised},
    fault::{Injection, PartFault, Schedule},
    serial_part::SerialPart,
};
use crate::sample::{Sample, SampleFlags};
use registers::*;

/// Lowest 7-bit I2C address (section 4.3.3: 0x20 with both address pins low).
pub const I2C_ADDRESS: u8 = 0x20;
/// Clock limit of the SPI, Hz (section 4.4).
pub const SPI_CLOCK_HZ: u32 = 1_000_000;

/// Range, microtesla (table 3-1).
const RANGE_UT: f32 = 800.0;
/// Value of the lower bits of STATUS.
const INDETERMINATE: u8 = 0x2A;

/// A measurement of one or more axes that is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sequence {
    /// Time at which the axis being measured begins.
    axis_from_ns: u64,
    begun_ns: u64,
    axis: usize,
    axes: [bool; 3],
    continuous: bool,
    /// True if the middle of the axis's time, at which the field is taken, is over.
    seen: bool,
}

/// A model of the part.
#[derive(Clone, Debug)]
pub struct Rm3100 {
    registers: [u8; COUNT],
    conversions: Conversions,
    played: Played,
    now_ns: u64,
    sequence: Option<Sequence>,
    measured: [i32; 3],
    ready: bool,
    schedule: Schedule<PartFault>,
}

impl Rm3100 {
    /// A part after power-up.
    #[must_use]
    pub fn new(conversions: Conversions) -> Self {
        let mut part = Self {
            registers: [0; COUNT],
            conversions,
            played: Played::nothing(),
            now_ns: 0,
            sequence: None,
            measured: [0; 3],
            ready: false,
            schedule: Schedule::none(),
        };
        part.reset();
        part
    }

    /// Plans a fault.
    pub const fn inject(&mut self, injection: Injection<PartFault>) {
        self.schedule = Schedule::of(injection);
    }

    /// The fault that was planned and the transactions so far.
    #[must_use]
    pub const fn schedule(&self) -> &Schedule<PartFault> {
        &self.schedule
    }

    /// Advances the part to `sample.t_us`, at which the truth is `sample`. If its magnetometer is missing, nothing is
    /// converted.
    pub fn play(&mut self, sample: &Sample) {
        self.played.take(sample);
        let now_ns = nanoseconds(sample.t_us);
        match self.conversions {
            Conversions::AtItsRate => self.pass_to(now_ns),
            Conversions::WithEverySample => {
                self.now_ns = self.now_ns.max(now_ns);
                let axes = self.axes(self.register(CMM), CMM_AXES);
                let on = self.register(CMM) & START != 0 && axes.contains(&true);
                if on && !sample.flags.contains(SampleFlags::MAG_MISSING) {
                    for (axis, _) in axes.into_iter().enumerate().filter(|(_, measured)| *measured) {
                        self.measure(axis, sample);
                    }
                    self.finish();
                }
            }
        }
    }

    /// Level of the pin DRDY.
    #[must_use]
    pub fn interrupt(&self) -> bool {
        match self.acting() {
            Some(PartFault::DataReadyStuckHigh) => true,
            Some(PartFault::DataReadyStuckLow) => false,
            _ => self.ready,
        }
    }

    fn register(&self, address: u8) -> u8 {
        self.registers.get(usize::from(address)).copied().unwrap_or(0)
    }

    fn put(&mut self, address: u8, value: u8) {
        if let Some(register) = self.registers.get_mut(usize::from(address)) {
            *register = value;
        }
    }

    fn acting(&self) -> Option<PartFault> {
        self.schedule.acting(self.now_ns / 1_000)
    }

    fn reset(&mut self) {
        for (address, register) in (0..).zip(&mut self.registers) {
            *register = default_of(address);
        }
        (self.sequence, self.measured, self.ready) = (None, [0; 3], false);
    }

    fn axes(&self, register: u8, bits: [u8; 3]) -> [bool; 3] {
        bits.map(|bit| register & bit != 0)
    }

    fn cycles(&self, axis: usize) -> u16 {
        let address = CCX1 + 2 * axis as u8;
        u16::from_be_bytes([self.register(address), self.register(address + 1)])
    }

    fn begin_sequence(&mut self, axes: [bool; 3], continuous: bool, at_ns: u64) {
        let axis = axes.iter().position(|measured| *measured);
        self.sequence =
            axis.map(|axis| Sequence { axis_from_ns: at_ns, begun_ns: at_ns, axis, axes, continuous, seen: false });
    }

    /// Does the measurements that are due by `now_ns`.
    fn pass_to(&mut self, now_ns: u64) {
        while let Some(sequence) = self.sequence {
            let axis_ns = axis_ns(self.cycles(sequence.axis));
            let middle_ns = sequence.axis_from_ns.saturating_add(axis_ns / 2);
            let until_ns = sequence.axis_from_ns.saturating_add(axis_ns);
            if middle_ns > now_ns || (sequence.seen && until_ns > now_ns) {
                break;
            }
            if !sequence.seen {
                if let Some(truth) = self.played.at(middle_ns) {
                    self.measure(sequence.axis, &truth);
                }
                self.sequence = Some(Sequence { seen: true, ..sequence });
                continue;
            }
            self.now_ns = self.now_ns.max(until_ns);
            let next = (sequence.axis + 1..3).find(|axis| sequence.axes.get(*axis) == Some(&true));
            if let Some(axis) = next {
                self.sequence = Some(Sequence { axis_from_ns: until_ns, axis, seen: false, ..sequence });
                continue;
            }
            if !self.played.at(until_ns).is_none_or(|truth| truth.flags.contains(SampleFlags::MAG_MISSING)) {
                self.finish();
            }
            self.sequence = None;
            if sequence.continuous {
                let begin_ns = sequence.begun_ns.saturating_add(period_ns(self.register(TMRC))).max(until_ns);
                self.begin_sequence(sequence.axes, true, begin_ns);
            }
        }
        self.now_ns = self.now_ns.max(now_ns);
    }

    fn measure(&mut self, axis: usize, truth: &Sample) {
        let gain = gain_per_ut(self.cycles(axis));
        let limit = (RANGE_UT * gain) as i32;
        let value = truth.mag_ut.get(axis).copied().unwrap_or(0.0);
        let count = quantised(value, 1.0 / gain, (-limit, limit));
        if let Some(measured) = self.measured.get_mut(axis) {
            *measured = count;
        }
    }

    /// Puts the results of all axes into the registers and sets data ready.
    fn finish(&mut self) {
        let fault = self.acting();
        if fault != Some(PartFault::FrozenOutput) {
            for (axis, count) in (0_u8..).zip(self.measured) {
                let count = if fault == Some(PartFault::DeadAxis(axis)) { 0 } else { count };
                let [_, high, middle, low] = count.to_be_bytes();
                for (offset, byte) in (0..).zip([high, middle, low]) {
                    self.put(MX2 + 3 * axis + offset, byte);
                }
            }
        }
        self.ready = true;
    }
}

impl SerialPart for Rm3100 {
    fn begin(&mut self, now_us: u64) {
        if self.conversions == Conversions::AtItsRate {
            self.pass_to(nanoseconds(now_us).min(self.played.known_until_ns()));
        }
        self.now_ns = self.now_ns.max(nanoseconds(now_us));
        match self.schedule.begin(self.now_ns / 1_000) {
            Some(PartFault::SilentReset) => self.reset(),
            Some(PartFault::FifoOverrun) => self.ready = false,
            _ => {}
        }
    }

    fn read(&mut self, address: u8) -> u8 {
        match address {
            CMM => {
                let value = self.register(CMM);
                // Section 5.2: reading CMM terminates the continuous mode.
                self.put(CMM, value & !START);
                self.sequence = None;
                value
            }
            MX2..=MZ0 => {
                if self.register(HSHAKE) & DRC1 != 0 {
                    self.ready = false;
                }
                self.register(address)
            }
            STATUS => INDETERMINATE | if self.interrupt() { DRDY } else { 0 },
            REVID if self.acting() == Some(PartFault::WrongIdentification) => !REVISION,
            _ => self.register(address),
        }
    }

    fn write(&mut self, address: u8, value: u8) {
        if self.register(HSHAKE) & DRC0 != 0 {
            self.ready = false;
        }
        if !is_writable(address) {
            return;
        }
        self.put(address, value);
        match address {
            CMM if value & START != 0 => self.begin_sequence(self.axes(value, CMM_AXES), true, self.now_ns),
            CMM => self.sequence = None,
            TMRC => {
                // Section 5.2: writing TMRC terminates the continuous mode, too.
                self.put(CMM, self.register(CMM) & !START);
                self.sequence = None;
            }
            // POLL is not accepted while the continuous mode is on (section 5.6.2).
            POLL if self.register(CMM) & START == 0 => {
                self.begin_sequence(self.axes(value, POLL_AXES), false, self.now_ns);
            }
            _ => {}
        }
    }

    fn following(&self, address: u8) -> u8 {
        address.wrapping_add(1) & 0x7F
    }
}
