//! Adapter of ST's magnetometer IIS2MDC.

use iis2mdc_rs::blocking::register::main::{CfgRegA, CfgRegB, CfgRegC, Md, Odr, Reg, SetRst, StatusReg};

use super::{BusOperation, I2c, I2cBus, Part, SpiBus, SpiDevice, bisync, st_start::reset};
use crate::sensors::{Burst, Frame, MagneticData, PartData, SensorData, StartError, StartStep, TemperatureData};

// Register names of ST DS12305, data sheet of the IIS2MDC.
#[bisync]
const IDENTITY: u8 = 0x40; // WHO_AM_I
/// Reset time: SOFT_RST takes 5 us, the part's turn-on 9.4 ms.
#[bisync]
const RESET_US: u32 = 10_000;

/// Adapter of ST's magnetometer IIS2MDC: 100 Hz, 4.9 mT, high resolution, offset cancelled from reading to
/// reading, data-ready on its pin.
#[derive(Clone, Debug)]
#[bisync]
pub struct Iis2mdc<B> {
    bus: B,
    /// True on SPI, where the part's I2C side is switched off.
    spi: bool,
}

#[bisync]
impl<S: SpiDevice> Iis2mdc<SpiBus<S>> {
    /// Creates an adapter on SPI of three wires, the part's start-up mode: mode 3, at most 10 MHz. Touches no
    /// bus.
    pub fn new_spi(spi: S) -> Self {
        Self { bus: SpiBus::new(spi), spi: true }
    }
}

#[bisync]
impl<I: I2c> Iis2mdc<I2cBus<I>> {
    /// Creates an adapter on I2C, at most 3.4 MHz, at address 0x1E. Touches no bus.
    pub fn new_i2c(i2c: I) -> Self {
        Self { bus: I2cBus::new(i2c, 0x1E), spi: false }
    }
}

#[bisync]
impl<B: BusOperation> Iis2mdc<B> {
    /// Returns the bus.
    pub fn release(self) -> B {
        self.bus
    }

    /// Values of CFG_REG_A, B and C.
    const fn settings(&self) -> [u8; 3] {
        [
            CfgRegA::new()
                .with_md(Md::ContinuousMode as u8)
                .with_odr(Odr::_100hz as u8)
                .with_comp_temp_en(1)
                .into_bits(),
            CfgRegB::new().with_set_rst(SetRst::SensOffCancEveryOdr as u8).into_bits(),
            CfgRegC::new().with_bdu(1).with_drdy_on_pin(1).with_i2c_dis(self.spi as u8).into_bits(),
        ]
    }
}

#[bisync]
impl<B: BusOperation> Part<1> for Iis2mdc<B> {
    type Error = B::Error;

    fn data(&self) -> MagneticData {
        const PERIOD_S: f32 = 0.01;
        const NOISE_UT: f32 = 0.3;
        PartData {
            name: "IIS2MDC",
            source: "ST DS12305, magnetic and temperature characteristics; AN5069, offset cancellation: each output is the mean of \
                     two conversions, so that its latency is the output period",
            sensors: [SensorData {
                full_scale: 4_915.2,
                per_code: 0.15,
                clip_code: i16::MAX.into(),
                latency_s: [PERIOD_S; 3],
                // 3 mG rms over half the output rate.
                noise_density: Some(NOISE_UT * libm::sqrtf(2.0 * PERIOD_S)),
            }],
            temperature: Some(TemperatureData { offset_c: 25.0, per_code_c: 0.125 }),
            period_us: 10_000,
            period_tolerance: 0.1,
            fifo_frames: 1,
            watermark_frames: 1,
            settling_frames: 2,
            frozen_frames: 20,
        }
    }

    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<B::Error>> {
        if step == 0 {
            let soft_rst = CfgRegA::new().with_soft_rst(1).into_bits();
            reset(&mut self.bus, (Reg::WhoAmI as u8, IDENTITY), (Reg::CfgRegA as u8, soft_rst)).await?;
            return Ok(StartStep::After(RESET_US));
        }
        let settings = self.settings();
        self.bus.write_to_register(Reg::CfgRegA as u8, &settings).await?;
        if !self.is_configured().await? {
            return Err(StartError::NotTaken { register: Reg::CfgRegA as u8 });
        }
        Ok(StartStep::Done)
    }

    async fn read(&mut self, burst: &mut Burst<1>) -> Result<(), B::Error> {
        // STATUS_REG, the three axes and the temperature in one go; block data update keeps the two bytes of
        // an axis together.
        let mut values = [0; 9];
        self.bus.read_from_register(Reg::StatusReg as u8, &mut values).await?;
        let [status, x0, x1, y0, y1, z0, z1, t0, t1] = values;
        if StatusReg::from_bits(status).zyxda() != 0 {
            let codes = [[x0, x1], [y0, y1], [z0, z1]].map(|axis| i32::from(i16::from_le_bytes(axis)));
            let temperature = i32::from(i16::from_le_bytes([t0, t1]));
            burst.push(Frame { codes: [Some(codes)], temperature: Some(temperature) });
        }
        Ok(())
    }

    async fn is_configured(&mut self) -> Result<bool, B::Error> {
        let mut settings = [0; 3];
        self.bus.read_from_register(Reg::CfgRegA as u8, &mut settings).await?;
        Ok(settings == self.settings())
    }
}
