//! A bus that counts what is moved over it, with a part that answers what its driver asks for.

use std::{cell::RefCell, convert::Infallible, rc::Rc};

use embedded_hal::{
    i2c::{self, I2c},
    spi::{self, SpiDevice},
};

/// Answer of a part to a read from a register on, if it differs from what was written there. Returns whether
/// it answered.
pub type Respond = fn(&mut Part, first: u8, into: &mut [u8]) -> bool;

pub struct Part {
    values: [u8; 256],
    respond: Respond,
    /// Measurements not read yet, up to the FIFO's depth.
    waiting: u16,
    noise: u8,
    slot: u8,
    bits: u64,
    bytes: u64,
    transactions: u64,
}

/// A device on the bus.
#[derive(Clone)]
pub struct Wire(Rc<RefCell<Part>>);

impl Wire {
    pub fn new(identity_register: u8, identity: u8, respond: Respond) -> Self {
        let mut values = [0; 256];
        values[usize::from(identity_register)] = identity;
        let part = Part { values, respond, waiting: 0, noise: 0, slot: 0, bits: 0, bytes: 0, transactions: 0 };
        Self(Rc::new(RefCell::new(part)))
    }

    pub fn measure(&self) {
        self.0.borrow_mut().waiting += 1;
    }

    pub fn bits(&self) -> u64 {
        self.0.borrow().bits
    }

    pub fn bytes(&self) -> u64 {
        self.0.borrow().bytes
    }

    pub fn transactions(&self) -> u64 {
        self.0.borrow().transactions
    }
}

impl Part {
    fn write(&mut self, bytes: &[u8]) {
        if let Some((first, values)) = bytes.split_first() {
            for (register, value) in (usize::from(*first)..256).zip(values) {
                self.values[register] = *value;
            }
        }
    }

    fn read(&mut self, first: u8, into: &mut [u8]) {
        let first = first & 0x7F;
        if !(self.respond)(self, first, into) {
            for (register, byte) in (usize::from(first)..256).zip(into) {
                *byte = self.values[register];
            }
        }
    }

    /// Axes of two bytes that never repeat, low byte first.
    fn noise(&mut self, into: &mut [u8], low: usize) {
        for axis in into.chunks_mut(2) {
            self.noise = self.noise.wrapping_mul(5).wrapping_add(7);
            axis.fill(0);
            if let Some(byte) = axis.get_mut(low) {
                *byte = self.noise & 0x7F;
            }
        }
    }

    fn moved(&mut self, bytes: usize, bits: usize) {
        self.bytes += bytes as u64;
        self.bits += bits as u64;
    }

    fn st_words(&mut self, into: &mut [u8], accel: u8, parity: bool) {
        for (k, word) in into.chunks_mut(7).enumerate() {
            let tag = if k % 2 == 0 { 1 } else { accel } << 3 | (self.slot & 3) << 1;
            word[0] = tag | u8::from(parity && tag.count_ones() % 2 == 1);
            self.noise(&mut word[1..], 0);
            self.slot = self.slot.wrapping_add((k % 2) as u8);
            self.waiting = self.waiting.saturating_sub((k % 2) as u16);
        }
    }
}

pub fn rm3100(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    match first {
        0x34 => into[0] = if part.waiting > 0 { 0x80 } else { 0 },
        0x24 => {
            part.waiting = 0;
            part.noise(into, 1);
        }
        _ => return false,
    }
    true
}

pub fn iis2mdc(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    if first == 0x67 {
        part.noise(&mut into[1..], 0);
        into[0] = if part.waiting > 0 { 0x0F } else { 0 };
        part.waiting = 0;
    }
    first == 0x67
}

pub fn ism330dhcx(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    match first {
        0x12 => into[0] = part.values[0x12] & !1,
        0x3A => into.copy_from_slice(&(2 * part.waiting).to_le_bytes()),
        0x78 => part.st_words(into, 2, true),
        _ => return false,
    }
    true
}

pub fn lsm6dsv320x(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    lsm6(part, first, into, 2)
}

pub fn lsm6dsv320x_high_g(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    lsm6(part, first, into, 0x1D)
}

fn lsm6(part: &mut Part, first: u8, into: &mut [u8], accel: u8) -> bool {
    match first {
        0x12 => into[0] = part.values[0x12] & !1,
        0x1B => into.copy_from_slice(&(2 * part.waiting).to_le_bytes()),
        0x78 => part.st_words(into, accel, false),
        _ => return false,
    }
    true
}

pub fn icm42688(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    if first == 0x2D {
        let (head, packets) = into.split_at_mut(3);
        head[0] = 0;
        head[1..].copy_from_slice(&part.waiting.to_be_bytes());
        for packet in packets.chunks_mut(20) {
            packet[0] = 0x78;
            part.noise(&mut packet[1..], 1);
            part.waiting = part.waiting.saturating_sub(1);
        }
    }
    first == 0x2D
}

pub fn bmi088_accel(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    // A dummy byte comes first.
    let into = &mut into[1..];
    match first {
        0x03 => into[0] = if part.waiting > 0 { 0x80 } else { 0 },
        0x12 => {
            part.waiting = 0;
            part.noise(into, 0);
        }
        _ => into[0] = part.values[usize::from(first)],
    }
    true
}

pub fn bmi088_gyro(part: &mut Part, first: u8, into: &mut [u8]) -> bool {
    match first {
        0x0E => into[0] = part.waiting.min(100) as u8,
        0x3F => {
            part.waiting = part.waiting.saturating_sub(1);
            part.noise(into, 0);
        }
        _ => return false,
    }
    true
}

impl spi::ErrorType for Wire {
    type Error = Infallible;
}

impl SpiDevice for Wire {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut part = self.0.borrow_mut();
        part.transactions += 1;
        let mut written = Vec::new();
        for operation in operations {
            match operation {
                spi::Operation::Write(bytes) => {
                    part.moved(bytes.len(), 8 * bytes.len());
                    written.extend_from_slice(bytes);
                }
                spi::Operation::Read(into) => {
                    part.moved(into.len(), 8 * into.len());
                    let first = written.first().copied().unwrap_or(0);
                    part.read(first, into);
                    written.clear();
                }
                spi::Operation::TransferInPlace(bytes) => {
                    part.moved(bytes.len(), 8 * bytes.len());
                    match bytes.split_first_mut() {
                        Some((first, into)) if *first & 0x80 != 0 => part.read(*first, into),
                        _ => part.write(bytes),
                    }
                }
                _ => {}
            }
        }
        part.write(&written);
        Ok(())
    }
}

impl i2c::ErrorType for Wire {
    type Error = Infallible;
}

impl I2c for Wire {
    fn transaction(&mut self, _: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), Infallible> {
        let mut part = self.0.borrow_mut();
        part.transactions += 1;
        let mut written: Vec<u8> = Vec::new();
        // Start, address with acknowledgement, stop.
        part.moved(1, 1 + 9 + 1);
        for operation in operations {
            match operation {
                i2c::Operation::Write(bytes) => {
                    part.moved(bytes.len(), 9 * bytes.len());
                    written.extend_from_slice(bytes);
                }
                i2c::Operation::Read(into) => {
                    // Start and address again for the read.
                    part.moved(1 + into.len(), 1 + 9 + 9 * into.len());
                    let first = written.first().copied().unwrap_or(0);
                    part.read(first, into);
                    written.clear();
                }
            }
        }
        part.write(&written);
        Ok(())
    }
}
