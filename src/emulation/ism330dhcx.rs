//! Model of the ST ISM330DHCX, gyro and accelerometer: data sheet DS13012 and application note AN5398.
//!
//! Modelled: identification, control registers with defaults, software reset, output data rates and ranges, output
//! and status registers, temperature (256 LSB per degree, 0 at 25), timestamp (25 us), and the FIFO with tagged
//! words, batch rates, watermark, bypass, FIFO and continuous mode, and overrun. A word saturates at its 16 bits,
//! which is some 15 % beyond the named range of the gyro. FIFO modes that change at an interrupt behave as before
//! that interrupt.
//!
//! Not modelled: block data update (a transaction sees one instant, so a burst is never torn; reading low and high
//! byte in two transactions can be), compression, filters, the pages of FUNC_CFG_ACCESS, and power modes (all rates
//! are exact).

pub mod fifo;
mod registers;
mod serial;

use super::{
    conversion::{Conversions, Played, Ticks, nanoseconds, quantised},
    fault::{Injection, PartFault, Schedule},
};
use crate::sample::{Sample, SampleFlags};
use fifo::{Fifo, Tag};
use registers::*;

/// 7-bit I2C address with SA0 low (DS13012, I2C interface).
pub const I2C_ADDRESS: u8 = 0x6A;
/// Clock limit of the SPI, Hz (DS13012, table of the SPI's timing, fc(SPC)).
pub const SPI_CLOCK_HZ: u32 = 10_000_000;

const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;
const WORD: (i32, i32) = (i16::MIN as i32, i16::MAX as i32);
/// The temperature is updated at 52 Hz (DS13012, temperature sensor characteristics, TODR).
const TEMPERATURE_PERIOD_NS: u64 = 19_230_769;
/// Time that a software reset takes (AN5398: 50 us).
const RESET_NS: u64 = 50_000;
const TIMESTAMP_LSB_NS: u64 = 25_000;

/// A model of the part. `WORDS` is the depth of its FIFO, [`fifo::DEPTH`] in the real one.
#[derive(Clone, Debug)]
pub struct Ism330dhcx<const WORDS: usize = { fifo::DEPTH }> {
    registers: [u8; COUNT],
    fifo: Fifo<WORDS>,
    conversions: Conversions,
    played: Played,
    now_ns: u64,
    gyro: Ticks,
    accel: Ticks,
    temperature: Ticks,
    /// Conversions so far of gyro and accelerometer, for batch rates below the output rate.
    converted: [u32; 2],
    reset_until_ns: u64,
    counting_since_ns: u64,
    schedule: Schedule<PartFault>,
}

impl<const WORDS: usize> Ism330dhcx<WORDS> {
    /// A part after power-up.
    #[must_use]
    pub fn new(conversions: Conversions) -> Self {
        let mut part = Self {
            registers: [0; COUNT],
            fifo: Fifo::empty(),
            conversions,
            played: Played::nothing(),
            now_ns: 0,
            gyro: Ticks::stopped(),
            accel: Ticks::stopped(),
            temperature: Ticks::stopped(),
            converted: [0; 2],
            reset_until_ns: 0,
            counting_since_ns: 0,
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

    /// Advances the part to `sample.t_us`, at which the truth is `sample`. A sensor that is missing from it converts
    /// nothing.
    pub fn play(&mut self, sample: &Sample) {
        self.played.take(sample);
        let now_ns = nanoseconds(sample.t_us);
        match self.conversions {
            Conversions::AtItsRate => self.pass_to(now_ns),
            Conversions::WithEverySample => {
                self.now_ns = self.now_ns.max(now_ns);
                self.fifo_slot(now_ns);
                self.convert_gyro(sample);
                self.convert_accel(sample);
                self.convert_temperature(sample);
            }
        }
    }

    /// Does the conversions that are due by `now_ns`, in order of time.
    fn pass_to(&mut self, now_ns: u64) {
        loop {
            let due = [self.gyro, self.accel, self.temperature].map(|ticks| ticks.next_until(now_ns));
            let Some(next) = due.into_iter().flatten().min() else { break };
            let Some(truth) = self.played.at(next) else { break };
            self.now_ns = self.now_ns.max(next);
            let [gyro, accel, temperature] = due.map(|tick| tick == Some(next));
            if gyro || accel {
                self.fifo_slot(next);
            }
            if gyro {
                self.gyro.done(period_ns(self.register(CTRL2_G) >> 4).unwrap_or(u64::MAX));
                self.convert_gyro(&truth);
            }
            if accel {
                self.accel.done(period_ns(self.register(CTRL1_XL) >> 4).unwrap_or(u64::MAX));
                self.convert_accel(&truth);
            }
            if temperature {
                self.temperature.done(TEMPERATURE_PERIOD_NS);
                self.convert_temperature(&truth);
            }
        }
        self.now_ns = self.now_ns.max(now_ns);
    }

    fn convert_gyro(&mut self, truth: &Sample) {
        let code = self.register(CTRL2_G) >> 4;
        if period_ns(code).is_none() || truth.flags.contains(SampleFlags::GYRO_MISSING) {
            return;
        }
        let unit = gyro_mdps_lsb(self.register(CTRL2_G)) * 1e-3 * core::f32::consts::PI / 180.0;
        self.put_axes(OUTX_L_G, truth.gyro_rad_s, unit, 0);
        self.put(STATUS_REG, self.register(STATUS_REG) | GDA);
        self.batch(0, Tag::Gyro, OUTX_L_G, code, self.register(FIFO_CTRL3) >> 4);
    }

    fn convert_accel(&mut self, truth: &Sample) {
        let code = self.register(CTRL1_XL) >> 4;
        if period_ns(code).is_none() || truth.flags.contains(SampleFlags::ACCEL_MISSING) {
            return;
        }
        let unit = accel_mg_lsb(self.register(CTRL1_XL)) * 1e-3 * STANDARD_GRAVITY_M_S2;
        self.put_axes(OUTX_L_A, truth.accel_m_s2, unit, 3);
        self.put(STATUS_REG, self.register(STATUS_REG) | XLDA);
        self.batch(1, Tag::Accelerometer, OUTX_L_A, code, self.register(FIFO_CTRL3) & 0xF);
    }

    fn convert_temperature(&mut self, truth: &Sample) {
        let powered = [CTRL1_XL, CTRL2_G].into_iter().any(|control| period_ns(self.register(control) >> 4).is_some());
        if !powered || truth.flags.contains(SampleFlags::TEMPERATURE_MISSING) {
            return;
        }
        if self.acting() != Some(PartFault::FrozenOutput) {
            let [low, high] = (quantised(truth.temperature_c - 25.0, 1.0 / 256.0, WORD) as i16).to_le_bytes();
            self.put(OUT_TEMP_L, low);
            self.put(OUT_TEMP_H, high);
        }
        self.put(STATUS_REG, self.register(STATUS_REG) | TDA);
        if self.register(FIFO_CTRL4) >> 4 & 3 != 0 {
            let data = [self.register(OUT_TEMP_L), self.register(OUT_TEMP_H), 0, 0, 0, 0];
            self.push(Tag::Temperature, data);
        }
    }

    /// Writes the words of three axes; `first_axis` is the first one's number in [`PartFault::DeadAxis`].
    fn put_axes(&mut self, address: u8, truth: [f32; 3], unit: f32, first_axis: u8) {
        let fault = self.acting();
        if fault == Some(PartFault::FrozenOutput) {
            return;
        }
        for (axis, value) in (0..).zip(truth) {
            let dead = fault == Some(PartFault::DeadAxis(first_axis + axis));
            let word = if dead { 0 } else { quantised(value, unit, WORD) as i16 };
            let [low, high] = word.to_le_bytes();
            self.put(address + 2 * axis, low);
            self.put(address + 2 * axis + 1, high);
        }
    }

    /// Batches a conversion into the FIFO if its turn has come: batch rates are the output rate or a power of two
    /// below it.
    fn batch(&mut self, sensor: usize, tag: Tag, address: u8, output_code: u8, batch_code: u8) {
        let Some(converted) = self.converted.get_mut(sensor) else { return };
        *converted = converted.wrapping_add(1);
        let halvings = u32::from(output_code.saturating_sub(batch_code));
        if batch_code == 0 || *converted & ((1 << halvings) - 1) != 0 {
            return;
        }
        let byte = |offset| self.register(address + offset);
        self.push(tag, [byte(0), byte(1), byte(2), byte(3), byte(4), byte(5)]);
    }

    /// Begins a time slot in the FIFO, with a timestamp if one is batched for every slot (FIFO_CTRL4, DEC_TS_BATCH
    /// 1).
    fn fifo_slot(&mut self, t_ns: u64) {
        self.fifo.next_slot();
        if self.register(FIFO_CTRL4) >> 6 == 1 && self.register(CTRL10_C) & TIMESTAMP_EN != 0 {
            let [a, b, c, d] = self.timestamp(t_ns).to_le_bytes();
            self.push(Tag::Timestamp, [a, b, c, d, 0, 0]);
        }
    }

    fn push(&mut self, tag: Tag, data: [u8; 6]) {
        // FIFO_CTRL4, FIFO_MODE: FIFO mode stops when full; continuous mode, and continuous-to-FIFO before its
        // interrupt, drops the oldest word.
        let mode = self.register(FIFO_CTRL4) & 7;
        if !matches!(mode, 1 | 3 | 6) {
            return;
        }
        let watermark = usize::from(self.watermark());
        let limited = self.register(FIFO_CTRL2) & STOP_ON_WTM != 0 && watermark > 0;
        self.fifo.push(tag, data, if limited { watermark } else { WORDS }, mode == 1 || limited);
    }

    /// Level of the pin INT1 as INT1_CTRL routes it (active high).
    #[must_use]
    pub fn interrupt(&self) -> bool {
        let enabled = self.register(INT1_CTRL);
        let status = self.status();
        let fifo = self.fifo_status2();
        (enabled & INT1_DRDY_XL != 0 && status & XLDA != 0)
            || (enabled & INT1_DRDY_G != 0 && status & GDA != 0)
            || (enabled & INT1_FIFO_TH != 0 && fifo & FIFO_WTM_IA != 0)
            || (enabled & INT1_FIFO_OVR != 0 && fifo & FIFO_OVR_IA != 0)
            || (enabled & INT1_FIFO_FULL != 0 && fifo & FIFO_FULL_IA != 0)
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
        self.fifo.clear();
        (self.gyro, self.accel, self.temperature) = (Ticks::stopped(), Ticks::stopped(), Ticks::stopped());
    }

    fn timestamp(&self, t_ns: u64) -> u32 {
        if self.register(CTRL10_C) & TIMESTAMP_EN == 0 {
            return 0;
        }
        // The counter wraps after 29 hours.
        (t_ns.saturating_sub(self.counting_since_ns) / TIMESTAMP_LSB_NS) as u32
    }

    fn watermark(&self) -> u16 {
        u16::from(self.register(FIFO_CTRL2) & 1) << 8 | u16::from(self.register(FIFO_CTRL1))
    }

    fn status(&self) -> u8 {
        match self.acting() {
            Some(PartFault::DataReadyStuckHigh) => TDA | GDA | XLDA,
            Some(PartFault::DataReadyStuckLow) => 0,
            _ => self.register(STATUS_REG),
        }
    }

    /// Words in the FIFO by its status registers, which a stuck data-ready makes wrong.
    fn level(&self) -> u16 {
        match self.acting() {
            Some(PartFault::DataReadyStuckLow) => 0,
            Some(PartFault::DataReadyStuckHigh) => (self.fifo.length() as u16).max(self.watermark()).max(1),
            _ => self.fifo.length() as u16,
        }
    }

    fn fifo_status2(&self) -> u8 {
        let flag = |on: bool, bit| if on { bit } else { 0 };
        let [_, high] = self.level().to_le_bytes();
        high & 3
            | flag(self.watermark() > 0 && self.level() >= self.watermark(), FIFO_WTM_IA)
            | flag(self.fifo.overrun, FIFO_OVR_IA)
            | flag(self.fifo.is_full(), FIFO_FULL_IA)
            | flag(self.fifo.overrun_latched, FIFO_OVR_LATCHED)
    }

    fn restart(&mut self, ticks: Tick, code: u8) {
        let now = self.now_ns;
        match ticks {
            Tick::Gyro => self.gyro.set(period_ns(code), now),
            Tick::Accel => self.accel.set(period_ns(code), now),
        }
        if self.temperature == Ticks::stopped() && period_ns(code).is_some() {
            self.temperature.set(Some(TEMPERATURE_PERIOD_NS), now);
        }
    }
}

enum Tick {
    Gyro,
    Accel,
}
