//! Adapter of ST's gyro and accelerometer LSM6DSV320X.

use lsm6dsv320x_rs::blocking::register::main::{
    CounterBdrReg1, Ctrl1, Ctrl1XlHg, Ctrl2, Ctrl3, Ctrl6, Ctrl8, DataRate, FifoBatch, FifoCtrl3, FifoCtrl4, FifoMode,
    FifoStatusReg, GyFullScale, HgXlDataRate, HgXlFullScale, Int1Ctrl, Reg, Tag, XlFullScale,
};

use super::{
    BusOperation, I2c, I2cBus, Part, SpiBus, SpiDevice, bisync,
    st_frames::take_frames,
    st_start::{read_one, reset},
};
use crate::{
    sensors::{
        Burst, InertialData, Lsm6dsv320xRange, PartData, SensorData, StartError, StartStep, TemperatureData,
        st_fifo::StFifo,
    },
    units::STANDARD_GRAVITY_M_S2,
};

// Register names of ST's data sheet of the LSM6DSV320X.
#[bisync]
const IDENTITY: u8 = 0x73; // WHO_AM_I
#[bisync]
const RESET_US: u32 = 1_000;
/// Words in the FIFO's 1.5 kbytes, without compression.
#[bisync]
const FIFO_WORDS: u16 = 256;

/// Adapter of ST's LSM6DSV320X: 2000 dps and 16 or 320 g, through its FIFO, whose watermark is on pin INT1.
#[derive(Clone, Debug)]
#[bisync]
pub struct Lsm6dsv320x<B> {
    bus: B,
    range: Lsm6dsv320xRange,
    watermark_frames: u8,
    fifo: StFifo,
}

#[bisync]
impl<S: SpiDevice> Lsm6dsv320x<SpiBus<S>> {
    /// Creates an adapter on SPI, mode 0 or 3, at most 10 MHz. Touches no bus. The interrupt comes when the
    /// FIFO holds `watermark_frames`, 1 to 127.
    pub fn new_spi(spi: S, range: Lsm6dsv320xRange, watermark_frames: u8) -> Self {
        Self::new(SpiBus::new(spi), range, watermark_frames)
    }
}

#[bisync]
impl<I: I2c> Lsm6dsv320x<I2cBus<I>> {
    /// Creates an adapter on I2C at most 1 MHz, at address 0x6A or 0x6B by its pin SA0; else as
    /// [`new_spi`](Lsm6dsv320x::new_spi).
    pub fn new_i2c(i2c: I, address: u8, range: Lsm6dsv320xRange, watermark_frames: u8) -> Self {
        Self::new(I2cBus::new(i2c, address), range, watermark_frames)
    }
}

#[bisync]
impl<B: BusOperation> Lsm6dsv320x<B> {
    fn new(bus: B, range: Lsm6dsv320xRange, watermark_frames: u8) -> Self {
        let accel = match range {
            Lsm6dsv320xRange::G16 => Tag::XlNc,
            Lsm6dsv320xRange::G320 => Tag::XlHg,
        };
        let fifo = StFifo::new(Tag::GyNc as u8, accel as u8, false);
        Self { bus, range, watermark_frames: watermark_frames.clamp(1, 127), fifo }
    }

    /// Returns the bus.
    pub fn release(self) -> B {
        self.bus
    }

    /// Values of CTRL1, CTRL2 and CTRL3.
    const fn settings(&self) -> [u8; 3] {
        let (accel, gyro) = match self.range {
            Lsm6dsv320xRange::G16 => (DataRate::_240hz, DataRate::_240hz),
            Lsm6dsv320xRange::G320 => (DataRate::Off, DataRate::_480hz),
        };
        [
            Ctrl1::new().with_odr_xl(accel as u8).into_bits(),
            Ctrl2::new().with_odr_g(gyro as u8).into_bits(),
            Ctrl3::new().into_bits(),
        ]
    }
}

#[bisync]
impl<B: BusOperation> Part<2> for Lsm6dsv320x<B> {
    type Error = B::Error;

    fn data(&self) -> InertialData {
        const G: f32 = STANDARD_GRAVITY_M_S2;
        let (rate_hz, period_us, full_scale_g, per_code_g) = match self.range {
            Lsm6dsv320xRange::G16 => (240.0, 4_167, 16.0, 0.488e-3),
            Lsm6dsv320xRange::G320 => (480.0, 2_083, 320.0, 10.417e-3),
        };
        let sensor = |full_scale, per_code, latency_s: f32| SensorData {
            full_scale,
            per_code,
            clip_code: ((full_scale / per_code) as i32).min(i16::MAX.into()),
            latency_s: [latency_s; 3],
            noise_density: None,
        };
        PartData {
            name: "LSM6DSV320X",
            source: "ST data sheet, mechanical characteristics; latency derived from bandwidths of 0.4 (gyro) and 0.5 of the output rate",
            sensors: [
                sensor(2000.0_f32.to_radians(), 0.070_f32.to_radians(), SensorData::low_pass_latency_s(0.4 * rate_hz)),
                sensor(full_scale_g * G, per_code_g * G, SensorData::low_pass_latency_s(0.5 * rate_hz)),
            ],
            temperature: Some(TemperatureData { offset_c: 25.0, per_code_c: 1.0 / 256.0 }),
            period_us,
            period_tolerance: 0.1,
            fifo_frames: FIFO_WORDS / 2,
            watermark_frames: self.watermark_frames.into(),
            // The gyro's turn-on time: 70 ms.
            settling_frames: (0.07 * rate_hz) as u16 + 1,
            frozen_frames: 20,
        }
    }

    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<B::Error>> {
        if step == 0 {
            let sw_reset = Ctrl3::new().with_sw_reset(1).into_bits();
            reset(&mut self.bus, (Reg::WhoAmI as u8, IDENTITY), (Reg::Ctrl3 as u8, sw_reset)).await?;
            return Ok(StartStep::After(RESET_US));
        }
        if Ctrl3::from_bits(read_one(&mut self.bus, Reg::Ctrl3 as u8).await?).sw_reset() != 0 {
            return Err(StartError::Busy);
        }
        self.fifo.clear();
        let high_g = u8::from(self.range == Lsm6dsv320xRange::G320);
        let high_g_rate = HgXlDataRate::_480hz as u8 * high_g;
        let (accel_batch, gyro_batch) = match self.range {
            Lsm6dsv320xRange::G16 => (FifoBatch::_240hz, FifoBatch::_240hz),
            Lsm6dsv320xRange::G320 => (FifoBatch::NotBatched, FifoBatch::_480hz),
        };
        let fifo = [
            2 * self.watermark_frames,
            0,
            FifoCtrl3::new().with_bdr_xl(accel_batch as u8).with_bdr_gy(gyro_batch as u8).into_bits(),
            FifoCtrl4::new().with_fifo_mode(FifoMode::Stream as u8).into_bits(),
            CounterBdrReg1::new().with_xl_hg_batch_en(high_g).into_bits(),
        ];
        let high_g_control = Ctrl1XlHg::new().with_fs_xl_hg(HgXlFullScale::_320g as u8).with_odr_xl_hg(high_g_rate);
        let ranges = [
            (Reg::Ctrl6, Ctrl6::new().with_fs_g(GyFullScale::_2000dps as u8).into_bits()),
            (Reg::Ctrl8, Ctrl8::new().with_fs_xl(XlFullScale::_16g as u8).into_bits()),
            (Reg::Ctrl1XlHg, high_g_control.into_bits()),
        ];
        self.bus.write_to_register(Reg::Int1Ctrl as u8, &[Int1Ctrl::new().with_int1_fifo_th(1).into_bits()]).await?;
        for (register, value) in ranges {
            let register = register as u8;
            self.bus.write_to_register(register, &[value]).await?;
            let mut taken = [0];
            self.bus.read_from_register(register, &mut taken).await?;
            if taken != [value] {
                return Err(StartError::NotTaken { register });
            }
        }
        self.bus.write_to_register(Reg::Ctrl1 as u8, &self.settings()).await?;
        self.bus.write_to_register(Reg::FifoCtrl1 as u8, &fifo).await?;
        let mut taken = [0; 5];
        self.bus.read_from_register(Reg::FifoCtrl1 as u8, &mut taken).await?;
        if taken != fifo {
            return Err(StartError::NotTaken { register: Reg::FifoCtrl1 as u8 });
        }
        if !self.is_configured().await? {
            return Err(StartError::NotTaken { register: Reg::Ctrl1 as u8 });
        }
        Ok(StartStep::Done)
    }

    async fn read(&mut self, burst: &mut Burst<2>) -> Result<(), B::Error> {
        let mut status = [0; 2];
        self.bus.read_from_register(Reg::FifoStatus1 as u8, &mut status).await?;
        let status = FifoStatusReg::from_bits(u16::from_le_bytes(status));
        burst.overrun = status.fifo_ovr_latched() != 0;
        let level = status.diff_fifo();
        let registers = [Reg::OutTempL as u8, Reg::FifoDataOutTag as u8];
        take_frames(&mut self.bus, &mut self.fifo, level, registers, burst).await
    }

    async fn is_configured(&mut self) -> Result<bool, B::Error> {
        let mut settings = [0; 3];
        self.bus.read_from_register(Reg::Ctrl1 as u8, &mut settings).await?;
        Ok(settings == self.settings())
    }
}
