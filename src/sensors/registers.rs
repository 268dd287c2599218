//! Registers of a part over SPI or I2C.

use super::{I2c, I2cOperation, SpiDevice, SpiOperation, bisync};

/// Registers of a part: eight-bit addresses that count up within a transaction.
#[bisync]
#[allow(async_fn_in_trait)] // As in embedded-hal-async: the bus decides if a future is `Send`.
pub trait Registers {
    /// Error of the bus.
    type Error;

    /// Reads the registers from `first` on.
    ///
    /// # Errors
    /// The bus failed.
    async fn read(&mut self, first: u8, values: &mut [u8]) -> Result<(), Self::Error>;

    /// Writes the registers from `first` on.
    ///
    /// # Errors
    /// The bus failed.
    async fn write(&mut self, first: u8, values: &[u8]) -> Result<(), Self::Error>;
}

/// Registers over SPI: the address's highest bit marks a read.
#[derive(Clone, Debug)]
#[bisync]
pub struct SpiRegisters<S>(pub S);

#[bisync]
impl<S: SpiDevice> Registers for SpiRegisters<S> {
    type Error = S::Error;

    async fn read(&mut self, first: u8, values: &mut [u8]) -> Result<(), S::Error> {
        const READ: u8 = 0x80;
        self.0.transaction(&mut [SpiOperation::Write(&[first | READ]), SpiOperation::Read(values)]).await
    }

    async fn write(&mut self, first: u8, values: &[u8]) -> Result<(), S::Error> {
        self.0.transaction(&mut [SpiOperation::Write(&[first]), SpiOperation::Write(values)]).await
    }
}

/// Registers over I2C.
#[derive(Clone, Debug)]
#[bisync]
pub struct I2cRegisters<I> {
    /// Bus.
    pub bus: I,
    /// Address of the part, seven bits.
    pub address: u8,
}

#[bisync]
impl<I: I2c> Registers for I2cRegisters<I> {
    type Error = I::Error;

    async fn read(&mut self, first: u8, values: &mut [u8]) -> Result<(), I::Error> {
        self.bus.write_read(self.address, &[first], values).await
    }

    async fn write(&mut self, first: u8, values: &[u8]) -> Result<(), I::Error> {
        // Operations of one kind are one message, without a second start between them.
        self.bus.transaction(self.address, &mut [I2cOperation::Write(&[first]), I2cOperation::Write(values)]).await
    }
}
