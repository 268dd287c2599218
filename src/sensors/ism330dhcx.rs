//! Adapter of ST's gyro and accelerometer ISM330DHCX.

use ism330dhcx_rs::blocking::register::main::{
    BdrXl, Ctrl1Xl, Ctrl2G, Ctrl3C, Ctrl9Xl, FifoCtrl3, FifoCtrl4, FifoMode, FifoStatus2, FsGy, FsXl, Int1Ctrl, OdrGy,
    OdrXl, Reg,
};

use super::{
    BusOperation, I2c, I2cBus, Part, SpiBus, SpiDevice, bisync,
    st_frames::take_frames,
    st_start::{read_one, reset},
};
use crate::{
    sensors::{Burst, InertialData, PartData, SensorData, StartError, StartStep, TemperatureData, st_fifo::StFifo},
    units::STANDARD_GRAVITY_M_S2,
};

// Register names of ST DS13012, data sheet of the ISM330DHCX; AN5398 is its application note.
#[bisync]
const IDENTITY: u8 = 0x6B; // WHO_AM_I
/// Wait after a reset; SW_RESET clears itself within 50 us.
#[bisync]
const RESET_US: u32 = 1_000;
/// Words in the FIFO's 3 kbytes, without compression.
#[bisync]
const FIFO_WORDS: u16 = 512;

/// Adapter of ST's ISM330DHCX: 208 Hz, 2000 dps, 16 g, through its FIFO, whose watermark is on pin INT1.
#[derive(Clone, Debug)]
#[bisync]
pub struct Ism330dhcx<B> {
    bus: B,
    watermark_frames: u8,
    fifo: StFifo,
}

#[bisync]
impl<S: SpiDevice> Ism330dhcx<SpiBus<S>> {
    /// Creates an adapter on SPI, mode 0 or 3, at most 10 MHz. Touches no bus. The interrupt comes when the
    /// FIFO holds `watermark_frames`, 1 to 127.
    pub fn new_spi(spi: S, watermark_frames: u8) -> Self {
        Self::new(SpiBus::new(spi), watermark_frames)
    }
}

#[bisync]
impl<I: I2c> Ism330dhcx<I2cBus<I>> {
    /// Creates an adapter on I2C at most 400 kHz (1 MHz in fast mode plus), at address 0x6A or 0x6B by its
    /// pin SA0; else as [`new_spi`](Ism330dhcx::new_spi).
    pub fn new_i2c(i2c: I, address: u8, watermark_frames: u8) -> Self {
        Self::new(I2cBus::new(i2c, address), watermark_frames)
    }
}

#[bisync]
impl<B: BusOperation> Ism330dhcx<B> {
    fn new(bus: B, watermark_frames: u8) -> Self {
        // FIFO_DATA_OUT_TAG: gyro 1, accelerometer 2; bit 0 makes the parity even.
        Self { bus, watermark_frames: watermark_frames.clamp(1, 127), fifo: StFifo::new(1, 2, true) }
    }

    /// Returns the bus.
    pub fn release(self) -> B {
        self.bus
    }

    /// Values of CTRL1_XL, CTRL2_G and CTRL3_C.
    const fn settings() -> [u8; 3] {
        [
            Ctrl1Xl::new().with_odr_xl(OdrXl::_208hz as u8).with_fs_xl(FsXl::_16g as u8).into_bits(),
            Ctrl2G::new().with_odr_g(OdrGy::_208hz as u8).with_fs_g(FsGy::_2000dps as u8).into_bits(),
            Ctrl3C::new().with_bdu(1).into_bits(),
        ]
    }
}

#[bisync]
impl<B: BusOperation> Part<2> for Ism330dhcx<B> {
    type Error = B::Error;

    fn data(&self) -> InertialData {
        PartData {
            name: "ISM330DHCX",
            source: "ST DS13012, mechanical characteristics; AN5398, filter bandwidths; latency derived from the bandwidth",
            sensors: [
                SensorData {
                    full_scale: 2000.0_f32.to_radians(),
                    per_code: 0.070_f32.to_radians(),
                    clip_code: 28_571,
                    latency_s: [SensorData::low_pass_latency_s(67.0); 3],
                    noise_density: Some(0.005_f32.to_radians()),
                },
                SensorData {
                    full_scale: 16.0 * STANDARD_GRAVITY_M_S2,
                    per_code: 0.488e-3 * STANDARD_GRAVITY_M_S2,
                    clip_code: 32_767,
                    latency_s: [SensorData::low_pass_latency_s(104.0); 3],
                    // Noise at the lowest ranges.
                    noise_density: Some(60e-6 * STANDARD_GRAVITY_M_S2),
                },
            ],
            temperature: Some(TemperatureData { offset_c: 25.0, per_code_c: 1.0 / 256.0 }),
            period_us: 4_808,
            period_tolerance: 0.1,
            fifo_frames: FIFO_WORDS / 2,
            watermark_frames: self.watermark_frames.into(),
            // The gyro's turn-on time: 70 ms.
            settling_frames: 15,
            frozen_frames: 20,
        }
    }

    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<B::Error>> {
        if step == 0 {
            let sw_reset = Ctrl3C::new().with_sw_reset(1).into_bits();
            reset(&mut self.bus, (Reg::WhoAmI as u8, IDENTITY), (Reg::Ctrl3C as u8, sw_reset)).await?;
            return Ok(StartStep::After(RESET_US));
        }
        if Ctrl3C::from_bits(read_one(&mut self.bus, Reg::Ctrl3C as u8).await?).sw_reset() != 0 {
            return Err(StartError::Busy);
        }
        self.fifo.clear();
        self.bus.write_to_register(Reg::Ctrl9Xl as u8, &[Ctrl9Xl::new().with_device_conf(1).into_bits()]).await?;
        self.bus.write_to_register(Reg::Int1Ctrl as u8, &[Int1Ctrl::new().with_int1_fifo_th(1).into_bits()]).await?;
        self.bus.write_to_register(Reg::Ctrl1Xl as u8, &Self::settings()).await?;
        let fifo = [
            2 * self.watermark_frames,
            0,
            FifoCtrl3::new().with_bdr_xl(BdrXl::_208hz as u8).with_bdr_gy(OdrGy::_208hz as u8).into_bits(),
            FifoCtrl4::new().with_fifo_mode(FifoMode::StreamMode as u8).into_bits(),
        ];
        self.bus.write_to_register(Reg::FifoCtrl1 as u8, &fifo).await?;
        let mut taken = [0; 4];
        self.bus.read_from_register(Reg::FifoCtrl1 as u8, &mut taken).await?;
        if taken != fifo {
            return Err(StartError::NotTaken { register: Reg::FifoCtrl1 as u8 });
        }
        if !self.is_configured().await? {
            return Err(StartError::NotTaken { register: Reg::Ctrl1Xl as u8 });
        }
        Ok(StartStep::Done)
    }

    async fn read(&mut self, burst: &mut Burst<2>) -> Result<(), B::Error> {
        let mut status = [0; 2];
        self.bus.read_from_register(Reg::FifoStatus1 as u8, &mut status).await?;
        let [low, high] = status;
        let high = FifoStatus2::from_bits(high);
        burst.overrun = high.over_run_latched() != 0;
        let level = u16::from_le_bytes([low, high.diff_fifo()]);
        let registers = [Reg::OutTempL as u8, Reg::FifoDataOutTag as u8];
        take_frames(&mut self.bus, &mut self.fifo, level, registers, burst).await
    }

    async fn is_configured(&mut self) -> Result<bool, B::Error> {
        let mut settings = [0; 3];
        self.bus.read_from_register(Reg::Ctrl1Xl as u8, &mut settings).await?;
        Ok(settings == Self::settings())
    }
}
