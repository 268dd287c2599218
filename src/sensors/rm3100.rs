//! Driver of PNI's magnetometer RM3100.

use super::{I2c, I2cRegisters, Part, Registers, SpiDevice, SpiRegisters, bisync};
use crate::sensors::{Burst, Frame, MagneticData, Rm3100Settings, StartError, StartStep};

// Register map: PNI RM3100 & RM2100 sensor suite user manual, 1017252, section 5.
#[bisync]
mod register {
    /// Continuous measurement mode. Reading it ends that mode (5.2), so it is never read back.
    pub const CMM: u8 = 0x01;
    /// Cycle counts of x, y and z, two bytes each, high byte first.
    pub const CCX: u8 = 0x04;
    /// Rate in continuous mode; 0x96 after a reset. Writing it ends that mode.
    pub const TMRC: u8 = 0x0B;
    /// Results of x, y and z, three bytes each, high byte first.
    pub const MX: u8 = 0x24;
    /// Status. Bit 7: a result is ready; reading the results clears it.
    pub const STATUS: u8 = 0x34;
    /// Revision, 0x22.
    pub const REVID: u8 = 0x36;
}
#[bisync]
const REVISION: u8 = 0x22;
#[bisync]
const DATA_READY: u8 = 1 << 7;
/// Command that starts all three axes, data-ready after the third (table 5-3: DRDM1 set, DRDM0 clear). Later
/// manuals have one such bit, bit 2, clear for the same.
#[bisync]
const MEASURE_ALL_AXES: u8 = 0b0111_1001;

/// Driver of PNI's magnetometer RM3100: three magneto-inductive axes, 24 bits.
#[derive(Clone, Debug)]
#[bisync]
pub struct Rm3100<R> {
    registers: R,
    settings: Rm3100Settings,
}

#[bisync]
impl<S: SpiDevice> Rm3100<SpiRegisters<S>> {
    /// Creates a driver on SPI, mode 0 or 3, at most 1 MHz (4.4). Touches no bus.
    pub fn new_spi(spi: S, settings: Rm3100Settings) -> Self {
        Self { registers: SpiRegisters(spi), settings }
    }
}

#[bisync]
impl<I: I2c> Rm3100<I2cRegisters<I>> {
    /// Creates a driver on I2C at most 400 kHz, at address 0x20 to 0x23 by its pins SA0 and SA1 (4.5).
    /// Touches no bus.
    pub fn new_i2c(i2c: I, address: u8, settings: Rm3100Settings) -> Self {
        Self { registers: I2cRegisters { bus: i2c, address }, settings }
    }
}

#[bisync]
impl<R> Rm3100<R> {
    /// Returns the registers, and with them the bus.
    pub fn release(self) -> R {
        self.registers
    }
}

#[bisync]
impl<R: Registers> Part<1> for Rm3100<R> {
    type Error = R::Error;

    fn data(&self) -> MagneticData {
        self.settings.data()
    }

    async fn start(&mut self, _step: u8) -> Result<StartStep, StartError<R::Error>> {
        let mut revision = [0];
        self.registers.read(register::REVID, &mut revision).await?;
        if revision != [REVISION] {
            let [found] = revision;
            return Err(StartError::WrongIdentity { expected: REVISION, found });
        }
        self.registers.write(register::CMM, &[0]).await?;
        let [high, low] = self.settings.cycle_count().to_be_bytes();
        let cycle_counts = [high, low, high, low, high, low];
        self.registers.write(register::CCX, &cycle_counts).await?;
        let mut taken = [0; 6];
        self.registers.read(register::CCX, &mut taken).await?;
        if taken != cycle_counts {
            return Err(StartError::NotTaken { register: register::CCX });
        }
        self.registers.write(register::TMRC, &[self.settings.rate() as u8]).await?;
        if !self.is_configured().await? {
            return Err(StartError::NotTaken { register: register::TMRC });
        }
        self.registers.write(register::CMM, &[MEASURE_ALL_AXES]).await?;
        Ok(StartStep::Done)
    }

    async fn read(&mut self, burst: &mut Burst<1>) -> Result<(), R::Error> {
        let mut status = [0];
        self.registers.read(register::STATUS, &mut status).await?;
        let [before] = status;
        if before & DATA_READY == 0 {
            return Ok(());
        }
        let mut results = [0; 9];
        self.registers.read(register::MX, &mut results).await?;
        self.registers.read(register::STATUS, &mut status).await?;
        let [after] = status;
        if after & DATA_READY != 0 {
            // A new result came while the old was read, and they may be mixed; or the bit is stuck.
            burst.corrupt = burst.corrupt.saturating_add(1);
            return Ok(());
        }
        let [x2, x1, x0, y2, y1, y0, z2, z1, z0] = results;
        let signed = |high, middle, low| i32::from_be_bytes([high, middle, low, 0]) >> 8;
        let codes = [signed(x2, x1, x0), signed(y2, y1, y0), signed(z2, z1, z0)];
        burst.push(Frame { codes: [Some(codes)], temperature: None });
        Ok(())
    }

    async fn is_configured(&mut self) -> Result<bool, R::Error> {
        let mut rate = [0];
        self.registers.read(register::TMRC, &mut rate).await?;
        Ok(rate == [self.settings.rate() as u8])
    }
}
