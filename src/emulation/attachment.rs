//! SPI and I2C buses of `embedded_hal` with a model on them. The model is shared: the program that plays it keeps it,
//! and the driver owns the bus.

use super::serial_part::{Cursor, SerialPart};
use core::cell::{Cell, RefCell};
use embedded_hal::{i2c, spi};

/// Error of a modelled bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PartError {
    /// No part has this I2C address.
    NoSuchAddress,
    /// The model is being played at this moment: a defect of the program.
    InUse,
}

impl spi::Error for PartError {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl i2c::Error for PartError {
    fn kind(&self) -> i2c::ErrorKind {
        match self {
            Self::NoSuchAddress => i2c::ErrorKind::NoAcknowledge(i2c::NoAcknowledgeSource::Address),
            Self::InUse => i2c::ErrorKind::Other,
        }
    }
}

/// SPI device that is a model.
pub struct OnSpi<'a, P> {
    part: &'a RefCell<P>,
    now_us: &'a Cell<u64>,
}

impl<'a, P> OnSpi<'a, P> {
    /// Creates the SPI device of `part`; `now_us` is the time of the program that plays the model.
    #[must_use]
    pub const fn new(part: &'a RefCell<P>, now_us: &'a Cell<u64>) -> Self {
        Self { part, now_us }
    }
}

impl<P> spi::ErrorType for OnSpi<'_, P> {
    type Error = PartError;
}

impl<P: SerialPart> spi::SpiDevice for OnSpi<'_, P> {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), PartError> {
        let mut part = self.part.try_borrow_mut().map_err(|_| PartError::InUse)?;
        let part = &mut *part;
        part.begin(self.now_us.get());
        let mut cursor = Cursor::new();
        for operation in operations {
            match operation {
                spi::Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = cursor.shift(part, 0)),
                spi::Operation::Write(bytes) => bytes.iter().for_each(|byte| {
                    cursor.shift(part, *byte);
                }),
                spi::Operation::Transfer(read, write) => {
                    let longer = read.len().max(write.len());
                    for index in 0..longer {
                        let byte = cursor.shift(part, write.get(index).copied().unwrap_or(0));
                        if let Some(place) = read.get_mut(index) {
                            *place = byte;
                        }
                    }
                }
                spi::Operation::TransferInPlace(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = cursor.shift(part, *byte));
                }
                spi::Operation::DelayNs(_) => {}
            }
        }
        Ok(())
    }
}

/// I2C bus with one model on it.
pub struct OnI2c<'a, P> {
    part: &'a RefCell<P>,
    now_us: &'a Cell<u64>,
    address: u8,
    cursor: Cursor,
}

impl<'a, P> OnI2c<'a, P> {
    /// Puts `part` at a 7-bit address; `now_us` is the time of the program that plays the model.
    #[must_use]
    pub const fn new(part: &'a RefCell<P>, now_us: &'a Cell<u64>, address: u8) -> Self {
        Self { part, now_us, address, cursor: Cursor::new() }
    }
}

impl<P> i2c::ErrorType for OnI2c<'_, P> {
    type Error = PartError;
}

impl<P: SerialPart> i2c::I2c for OnI2c<'_, P> {
    fn transaction(&mut self, address: u8, operations: &mut [i2c::Operation<'_>]) -> Result<(), PartError> {
        if address != self.address {
            return Err(PartError::NoSuchAddress);
        }
        let mut part = self.part.try_borrow_mut().map_err(|_| PartError::InUse)?;
        let part = &mut *part;
        part.begin(self.now_us.get());
        let mut writing = false;
        for operation in operations {
            match operation {
                i2c::Operation::Write(bytes) => {
                    // Operations of one kind in a row go without a repeated start.
                    if !writing {
                        self.cursor = Cursor::new();
                    }
                    writing = true;
                    bytes.iter().for_each(|byte| self.cursor.receive(part, *byte));
                }
                i2c::Operation::Read(bytes) => {
                    writing = false;
                    bytes.iter_mut().for_each(|byte| *byte = self.cursor.send(part));
                }
            }
        }
        Ok(())
    }
}
