//! Adapter of Bosch's gyro and accelerometer BMI088.

use bmi088::{Error, SensorInterface, SpiInterface};

use super::{Part, SpiDevice};
use crate::{
    sensors::{BURST_FRAMES, Burst, Frame, InertialData, PartData, SensorData, StartError, StartStep, TemperatureData},
    units::STANDARD_GRAVITY_M_S2,
};

// Registers of accelerometer and gyro: Bosch BST-BMI088-DS001, section 5. The crate bmi088 transfers the bytes, with
// the dummy byte that the accelerometer needs (6.1.2); its own set-up is not used: it waits, and leaves range and
// rate unchanged.
mod accel {
    pub const CHIP_ID: u8 = 0x00;
    pub const STATUS: u8 = 0x03;
    pub const DATA: u8 = 0x12;
    pub const TEMPERATURE: u8 = 0x22;
    pub const CONF: u8 = 0x40;
    pub const RANGE: u8 = 0x41;
    pub const PWR_CONF: u8 = 0x7C;
    pub const PWR_CTRL: u8 = 0x7D;
    pub const SOFT_RESET: u8 = 0x7E;
    pub const IDENTITY: u8 = 0x1E;
    /// Normal filter, 200 Hz; 0xA8 after a reset.
    pub const NORMAL_200_HZ: u8 = 0xA9;
    pub const TO_24_G: u8 = 0x03;
    /// Not suspended; 0x03 after a reset.
    pub const ACTIVE: u8 = 0x00;
    pub const ON: u8 = 0x04;
    pub const DATA_READY: u8 = 1 << 7;
}
mod gyro {
    pub const CHIP_ID: u8 = 0x00;
    pub const FIFO_STATUS: u8 = 0x0E;
    pub const RANGE: u8 = 0x0F;
    pub const BANDWIDTH: u8 = 0x10;
    pub const SOFT_RESET: u8 = 0x14;
    pub const INT_CTRL: u8 = 0x15;
    pub const INT3_INT4_IO_CONF: u8 = 0x16;
    pub const INT3_INT4_IO_MAP: u8 = 0x18;
    pub const FIFO_WM_EN: u8 = 0x1E;
    pub const FIFO_CONFIG_0: u8 = 0x3D;
    pub const FIFO_CONFIG_1: u8 = 0x3E;
    pub const FIFO_DATA: u8 = 0x3F;
    pub const IDENTITY: u8 = 0x0F;
    /// Range 2000 dps; 200 Hz behind a filter of 64 Hz; FIFO interrupt on INT3, push-pull, active high, at
    /// one frame.
    pub const SETTINGS: [(u8, u8); 8] = [
        (RANGE, 0x00),
        (BANDWIDTH, 0x06),
        (INT3_INT4_IO_CONF, 0x01),
        (INT3_INT4_IO_MAP, 0x04),
        (FIFO_WM_EN, 0x88),
        (FIFO_CONFIG_0, 1),
        (INT_CTRL, 0x40),
        (FIFO_CONFIG_1, STREAM),
    ];
    /// Range and bandwidth, which nothing else shows: register, bits, value. Bit 7 of the bandwidth reads as one.
    pub const READ_BACK: [(u8, u8, u8); 2] = [(RANGE, 0xFF, 0x00), (BANDWIDTH, 0x7F, 0x06)];
    /// Stream mode, in which new frames replace the oldest; 0 after a reset.
    pub const STREAM: u8 = 0x80;
    pub const OVERRUN: u8 = 1 << 7;
}
/// Reset command of gyro and accelerometer.
const RESET: u8 = 0xB6;
/// Reset time of the gyro; the accelerometer takes 1 ms.
const RESET_US: u32 = 30_000;
/// Time until the accelerometer takes the next write, from one in suspend mode: Bosch's BMI08x API waits as long.
const RESUMED_US: u32 = 450;
const POWERED_US: u32 = 5_000;
const PERIOD_US: u32 = 5_000;
/// Bursts between readings of the thermometer, which updates every 1.28 s.
const BURSTS_PER_TEMPERATURE: u8 = 64;

/// Adapter of Bosch's BMI088: 200 Hz, 2000 dps, 24 g; blocking, on SPI, mode 0 or 3, at most 10 MHz.
///
/// The gyro's FIFO paces the frames. The accelerometer has its own oscillator: its newest reading goes to the newest
/// frame if it has not been read before. So now and then a frame has no accelerometer reading, and a reading goes
/// into no frame.
pub struct Bmi088<A, G> {
    accel: SpiInterface<A>,
    gyro: SpiInterface<G>,
    temperature: Option<i32>,
    bursts: u8,
    /// True if the part still shows an overrun that a burst has told.
    overrun_told: bool,
}

impl<E, A: SpiDevice<Error = E>, G: SpiDevice<Error = E>> Bmi088<A, G> {
    /// Creates an adapter from its accelerometer's and its gyro's device on the bus. Touches no bus.
    pub fn new(accel: A, gyro: G) -> Self {
        Self {
            accel: SpiInterface::new(accel, true),
            gyro: SpiInterface::new(gyro, false),
            temperature: None,
            bursts: 0,
            overrun_told: false,
        }
    }
}

impl<E, A: SpiDevice<Error = E>, G: SpiDevice<Error = E>> Part<2> for Bmi088<A, G> {
    type Error = Error<E, E>;

    fn data(&self) -> InertialData {
        const G: f32 = STANDARD_GRAVITY_M_S2;
        // A reading of the accelerometer waits for the frame whose time the gyro's interrupt sets: half a period in the
        // mean, as the two oscillators are independent. Polled, both are as old, and the wait is not there.
        const WAIT_S: f32 = 0.5e-6 * PERIOD_US as f32;
        PartData {
            name: "BMI088",
            source: "Bosch BST-BMI088-DS001, section 1.2; latency derived from the bandwidths of 64 and 80 Hz and a wait",
            sensors: [
                SensorData {
                    full_scale: 2000.0_f32.to_radians(),
                    per_code: (2000.0_f32 / 32_768.0).to_radians(),
                    clip_code: i16::MAX.into(),
                    latency_s: [SensorData::low_pass_latency_s(64.0); 3],
                    noise_density: Some(0.014_f32.to_radians()),
                },
                SensorData {
                    full_scale: 24.0 * G,
                    per_code: 24.0 / 32_768.0 * G,
                    clip_code: i16::MAX.into(),
                    latency_s: [SensorData::low_pass_latency_s(80.0) + WAIT_S; 3],
                    noise_density: Some(175e-6 * G),
                },
            ],
            temperature: Some(TemperatureData { offset_c: 23.0, per_code_c: 0.125 }),
            period_us: PERIOD_US,
            period_tolerance: 0.05,
            fifo_frames: 100,
            watermark_frames: 1,
            settling_frames: 10,
            frozen_frames: 20,
        }
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<Self::Error>> {
        match step {
            0 => {
                // The first reading only switches the accelerometer to SPI (3).
                self.accel.register_read(accel::CHIP_ID)?;
                identify(&mut self.accel, accel::CHIP_ID, accel::IDENTITY)?;
                identify(&mut self.gyro, gyro::CHIP_ID, gyro::IDENTITY)?;
                self.accel.register_write(accel::SOFT_RESET, RESET)?;
                self.gyro.register_write(gyro::SOFT_RESET, RESET)?;
                Ok(StartStep::After(RESET_US))
            }
            1 => {
                self.accel.register_read(accel::CHIP_ID)?;
                self.accel.register_write(accel::PWR_CONF, accel::ACTIVE)?;
                Ok(StartStep::After(RESUMED_US))
            }
            2 => {
                self.accel.register_write(accel::PWR_CTRL, accel::ON)?;
                Ok(StartStep::After(POWERED_US))
            }
            _ => {
                self.temperature = None;
                self.bursts = 0;
                self.overrun_told = false;
                self.accel.register_write(accel::CONF, accel::NORMAL_200_HZ)?;
                self.accel.register_write(accel::RANGE, accel::TO_24_G)?;
                for (register, value) in gyro::SETTINGS {
                    self.gyro.register_write(register, value)?;
                }
                if self.accel.register_read(accel::RANGE)? != accel::TO_24_G {
                    return Err(StartError::NotTaken { register: accel::RANGE });
                }
                for (register, bits, value) in gyro::READ_BACK {
                    if self.gyro.register_read(register)? & bits != value {
                        return Err(StartError::NotTaken { register });
                    }
                }
                if !self.is_configured()? {
                    return Err(StartError::NotTaken { register: gyro::FIFO_CONFIG_1 });
                }
                Ok(StartStep::Done)
            }
        }
    }

    fn read(&mut self, burst: &mut Burst<2>) -> Result<(), Self::Error> {
        let status = self.gyro.register_read(gyro::FIFO_STATUS)?;
        let overrun = status & gyro::OVERRUN != 0;
        burst.overrun = overrun && !self.overrun_told;
        let level = status & !gyro::OVERRUN;
        let taken = level.min(BURST_FRAMES as u8);
        burst.left = (level - taken).into();
        if taken > 0 && self.bursts == 0 {
            let [first, ..] = self.accel.read_vec3_i16(accel::TEMPERATURE)?;
            // Eleven bits, the upper eight first (5.3.7).
            self.temperature = Some(i32::from(first.swap_bytes() >> 5));
        }
        if taken > 0 {
            self.bursts = (self.bursts + 1) % BURSTS_PER_TEMPERATURE;
        }
        for k in 1..=taken {
            // One frame is six bytes, which the crate reads in one transaction.
            let rate = self.gyro.read_vec3_i16(gyro::FIFO_DATA)?.map(i32::from);
            let newest = k == taken && burst.left == 0;
            let accel = if newest && self.accel.register_read(accel::STATUS)? & accel::DATA_READY != 0 {
                Some(self.accel.read_vec3_i16(accel::DATA)?.map(i32::from))
            } else {
                None
            };
            burst.push(Frame { codes: [Some(rate), accel], temperature: self.temperature });
        }
        if overrun && burst.left == 0 {
            // Only this takes the flag back (5.5.4); it empties the FIFO, too, in which nothing is left.
            self.gyro.register_write(gyro::FIFO_CONFIG_1, gyro::STREAM)?;
        }
        self.overrun_told = overrun && burst.left > 0;
        Ok(())
    }

    fn is_configured(&mut self) -> Result<bool, Self::Error> {
        Ok(self.accel.register_read(accel::CONF)? == accel::NORMAL_200_HZ
            && self.accel.register_read(accel::PWR_CONF)? == accel::ACTIVE
            && self.accel.register_read(accel::PWR_CTRL)? == accel::ON
            && self.gyro.register_read(gyro::FIFO_CONFIG_1)? == gyro::STREAM)
    }
}

fn identify<S: SensorInterface>(
    interface: &mut S,
    register: u8,
    expected: u8,
) -> Result<(), StartError<S::InterfaceError>> {
    let found = interface.register_read(register)?;
    if found == expected { Ok(()) } else { Err(StartError::WrongIdentity { expected, found }) }
}
