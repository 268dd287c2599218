//! I2C by hand over the Arm Versatile serial bus interface "SBCon" (Arm DDI 0224, section 4.11): two
//! open-drain lines.

use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

/// The shield's interface of MPS2 (Arm DAI 0386, memory map).
const BASE: *mut u32 = 0x4002_A000 as *mut u32;
const SCL: u32 = 1;
const SDA: u32 = 1 << 1;

/// No part acknowledged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum I2cError {
    NoAcknowledge(NoAcknowledgeSource),
}

impl Error for I2cError {
    fn kind(&self) -> ErrorKind {
        let Self::NoAcknowledge(source) = self;
        ErrorKind::NoAcknowledge(*source)
    }
}

pub struct BitBangedI2c {
    _private: (),
}

impl BitBangedI2c {
    /// The interface. There is one, and this program is its only user.
    pub const fn take() -> Self {
        Self { _private: () }
    }

    // SAFETY: the three registers are at these addresses on this machine, and have no effect but on the
    // lines.
    #[allow(unsafe_code)]
    fn set(&mut self, line: u32, high: bool) {
        let register = if high { BASE } else { BASE.wrapping_add(1) };
        unsafe { register.write_volatile(line) };
    }

    // SAFETY: as above.
    #[allow(unsafe_code)]
    fn sda(&self) -> bool {
        unsafe { BASE.read_volatile() & SDA != 0 }
    }

    fn start(&mut self) {
        self.set(SDA, true);
        self.set(SCL, true);
        self.set(SDA, false);
        self.set(SCL, false);
    }

    fn stop(&mut self) {
        self.set(SDA, false);
        self.set(SCL, true);
        self.set(SDA, true);
    }

    fn clock(&mut self, out: bool) -> bool {
        self.set(SDA, out);
        self.set(SCL, true);
        let level = self.sda();
        self.set(SCL, false);
        level
    }

    /// Sends a byte, most significant bit first. Returns whether it was acknowledged.
    fn send(&mut self, byte: u8) -> bool {
        for bit in (0..8).rev() {
            self.clock(byte >> bit & 1 != 0);
        }
        !self.clock(true)
    }

    fn receive(&mut self, last: bool) -> u8 {
        let byte = (0..8).fold(0, |byte, _| byte << 1 | u8::from(self.clock(true)));
        self.clock(last);
        byte
    }

    fn operations(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), I2cError> {
        let mut reading = None;
        let count = operations.len();
        for (index, operation) in operations.iter_mut().enumerate() {
            let read = matches!(operation, Operation::Read(_));
            // Operations of one kind in a row go on without a repeated start.
            if reading.replace(read) != Some(read) {
                self.start();
                if !self.send(address << 1 | u8::from(read)) {
                    return Err(I2cError::NoAcknowledge(NoAcknowledgeSource::Address));
                }
            }
            match operation {
                Operation::Write(bytes) => {
                    if !bytes.iter().all(|byte| self.send(*byte)) {
                        return Err(I2cError::NoAcknowledge(NoAcknowledgeSource::Data));
                    }
                }
                Operation::Read(bytes) => {
                    let length = bytes.len();
                    for (place, byte) in bytes.iter_mut().enumerate() {
                        *byte = self.receive(index + 1 == count && place + 1 == length);
                    }
                }
            }
        }
        Ok(())
    }
}

impl ErrorType for BitBangedI2c {
    type Error = I2cError;
}

impl I2c for BitBangedI2c {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), I2cError> {
        let result = self.operations(address, operations);
        self.stop();
        result
    }
}
