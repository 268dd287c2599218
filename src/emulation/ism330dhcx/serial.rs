//! Serial side of the part: its answers on the bus.

use super::{Ism330dhcx, RESET_NS, Tick, registers::*};
use crate::emulation::{
    conversion::{Conversions, nanoseconds},
    fault::PartFault,
    serial_part::SerialPart,
};

impl<const WORDS: usize> SerialPart for Ism330dhcx<WORDS> {
    fn begin(&mut self, now_us: u64) {
        if self.conversions == Conversions::AtItsRate {
            self.pass_to(nanoseconds(now_us).min(self.played.known_until_ns()));
        }
        self.now_ns = self.now_ns.max(nanoseconds(now_us));
        match self.schedule.begin(self.now_ns / 1_000) {
            Some(PartFault::SilentReset) => self.reset(),
            Some(PartFault::FifoOverrun) => {
                self.fifo.drop_oldest(self.fifo.length().div_ceil(2));
                (self.fifo.overrun, self.fifo.overrun_latched) = (true, true);
            }
            _ => {}
        }
    }

    fn read(&mut self, address: u8) -> u8 {
        match address {
            WHO_AM_I if self.acting() == Some(PartFault::WrongIdentification) => !IDENTIFICATION,
            CTRL3_C if self.now_ns < self.reset_until_ns => self.register(CTRL3_C) | SW_RESET,
            STATUS_REG => self.status(),
            FIFO_STATUS1 => {
                let [low, _] = self.level().to_le_bytes();
                low
            }
            FIFO_STATUS2 => {
                let status = self.fifo_status2();
                // The latch is reset when the register is read.
                self.fifo.overrun_latched = false;
                status
            }
            TIMESTAMP0..=TIMESTAMP3 => {
                let bytes = self.timestamp(self.now_ns).to_le_bytes();
                bytes.get(usize::from(address - TIMESTAMP0)).copied().unwrap_or(0)
            }
            FIFO_DATA_OUT_TAG..=FIFO_DATA_OUT_Z_H => self.fifo.read(usize::from(address - FIFO_DATA_OUT_TAG)),
            _ => {
                // A data-ready flag falls when a high byte of its sensor is read (AN5398, using the status register).
                let flag = match address {
                    OUT_TEMP_H => TDA,
                    OUTX_L_G..=OUTZ_H_G if address % 2 == 1 => GDA,
                    OUTX_L_A..=OUTZ_H_A if address % 2 == 1 => XLDA,
                    _ => 0,
                };
                self.put(STATUS_REG, self.register(STATUS_REG) & !flag);
                self.register(address)
            }
        }
    }

    fn write(&mut self, address: u8, value: u8) {
        if address == TIMESTAMP2 && value == 0xAA {
            // TIMESTAMP2: writing AAh resets the counter.
            self.counting_since_ns = self.now_ns;
        }
        if !is_writable(address) || self.now_ns < self.reset_until_ns {
            return;
        }
        let before = self.register(address);
        match address {
            CTRL3_C => {
                if value & (SW_RESET | BOOT) != 0 {
                    self.reset();
                    self.reset_until_ns = self.now_ns.saturating_add(RESET_NS);
                } else {
                    self.put(address, value);
                }
                return;
            }
            CTRL10_C if value & TIMESTAMP_EN != 0 && before & TIMESTAMP_EN == 0 => self.counting_since_ns = self.now_ns,
            _ => {}
        }
        self.put(address, value);
        match address {
            CTRL1_XL if before >> 4 != value >> 4 => self.restart(Tick::Accel, value >> 4),
            CTRL2_G if before >> 4 != value >> 4 => self.restart(Tick::Gyro, value >> 4),
            // Bypass mode empties the FIFO (DS13012).
            FIFO_CTRL4 if value & 7 == 0 => self.fifo.clear(),
            _ => {}
        }
    }

    fn following(&self, address: u8) -> u8 {
        // Within a transaction the address goes from the FIFO's last data byte back to its tag (AN5398).
        match address {
            FIFO_DATA_OUT_Z_H => FIFO_DATA_OUT_TAG,
            _ if self.register(CTRL3_C) & IF_INC == 0 => address,
            _ => address.wrapping_add(1) & 0x7F,
        }
    }
}
