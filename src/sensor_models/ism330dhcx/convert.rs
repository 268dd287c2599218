//! Conversions, their words in the output registers, and their batches in the FIFO.

use super::{Ism330dhcx, STANDARD_GRAVITY_M_S2, TEMPERATURE_PERIOD_NS, WORD, fifo::Tag, registers::*};
use crate::{
    sample::{Sample, SampleFlags},
    sensor_models::{conversion::quantised, fault::PartFault},
};

impl<const WORDS: usize> Ism330dhcx<WORDS> {
    /// Does the conversions that are due by `now_ns`, in order of time.
    pub(super) fn pass_to(&mut self, now_ns: u64) {
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

    pub(super) fn convert_gyro(&mut self, truth: &Sample) {
        let code = self.register(CTRL2_G) >> 4;
        if period_ns(code).is_none() || truth.flags.contains(SampleFlags::GYRO_MISSING) {
            return;
        }
        let unit = gyro_mdps_lsb(self.register(CTRL2_G)) * 1e-3 * core::f32::consts::PI / 180.0;
        self.put_axes(OUTX_L_G, truth.gyro_rad_s, unit, 0);
        self.put(STATUS_REG, self.register(STATUS_REG) | GDA);
        self.batch(0, Tag::Gyro, OUTX_L_G, code, self.register(FIFO_CTRL3) >> 4);
    }

    pub(super) fn convert_accel(&mut self, truth: &Sample) {
        let code = self.register(CTRL1_XL) >> 4;
        if period_ns(code).is_none() || truth.flags.contains(SampleFlags::ACCEL_MISSING) {
            return;
        }
        let unit = accel_mg_lsb(self.register(CTRL1_XL)) * 1e-3 * STANDARD_GRAVITY_M_S2;
        self.put_axes(OUTX_L_A, truth.accel_m_s2, unit, 3);
        self.put(STATUS_REG, self.register(STATUS_REG) | XLDA);
        self.batch(1, Tag::Accelerometer, OUTX_L_A, code, self.register(FIFO_CTRL3) & 0xF);
    }

    pub(super) fn convert_temperature(&mut self, truth: &Sample) {
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
    pub(super) fn fifo_slot(&mut self, t_ns: u64) {
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
}
