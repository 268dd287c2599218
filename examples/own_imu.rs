//! A gyro with an accelerometer of one's own: an adapter for TDK's ICM-20948 on SPI, whose registers lie in banks,
//! written from its data sheet and docs/sensors.md.
//!
//! `cargo run --example own_imu --features bus`

use core::f32::consts::PI;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use meerkat_mwd::{
    Sample,
    heapless::Vec as Readings,
    sensors::{
        Axis, BURST_FRAMES, Burst, Combiner, Frame, InertialData, InertialReading, Mounting, MountingError, PartData,
        SensorData, StartError, StartStep, TemperatureData, Trigger,
        blocking::{InertialSource, Part, Registers, SpiRegisters, Supervised},
    },
};

/// REG_BANK_SEL, in every bank; the settings are in bank 2, all else in bank 0.
const BANK: u8 = 0x7F;
/// GYRO_SMPLRT_DIV: 1,125 Hz / 5. GYRO_CONFIG_1: 2,000 deg/s, low-pass of 119.5 Hz.
const GYRO: [u8; 2] = [4, 0x17];
/// ACCEL_SMPLRT_DIV_1 and 2: the same rate.
const ACCEL_DIVIDER: [u8; 2] = [0, 4];
/// ACCEL_CONFIG: 16 g, low-pass of 111.4 Hz.
const ACCEL: [u8; 1] = [0x17];
/// PWR_MGMT_1: awake, with the best clock. After a reset it is 0x41, asleep.
const AWAKE: u8 = 0x01;
const DEGREE: f32 = PI / 180.0;
const G: f32 = 9.806_65;
const DATA: InertialData = PartData {
    name: "ICM-20948",
    source: "TDK DS-000189, tables 1 to 3 and 16 to 18",
    // The gyro, then the accelerometer, whatever the order of the registers.
    sensors: [
        SensorData {
            full_scale: 2_000.0 * DEGREE,
            per_code: DEGREE / 16.4,
            clip_code: 32_767,
            latency_s: [0.225 / 119.5; 3],
            noise_density: Some(0.015 * DEGREE),
        },
        SensorData {
            full_scale: 16.0 * G,
            per_code: G / 2_048.0,
            clip_code: 32_767,
            latency_s: [0.225 / 111.4; 3],
            noise_density: Some(230e-6 * G),
        },
    ],
    temperature: Some(TemperatureData { offset_c: 21.0, per_code_c: 1.0 / 333.87 }),
    period_us: 4_444,
    period_tolerance: 0.05,
    fifo_frames: 1,
    watermark_frames: 1,
    settling_frames: 8,
    frozen_frames: 20,
};

/// The adapter, over the part's registers.
struct Icm20948<R>(R);

impl<R: Registers> Part<2> for Icm20948<R> {
    type Error = R::Error;

    fn data(&self) -> InertialData {
        DATA
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<R::Error>> {
        match step {
            0 => {
                // A part that kept its power may be in any bank.
                self.0.write(BANK, &[0x00])?;
                let mut found = [0];
                self.0.read(0x00, &mut found)?; // WHO_AM_I
                if found != [0xEA] {
                    return Err(StartError::WrongIdentity { expected: 0xEA, found: found[0] });
                }
                self.0.write(0x06, &[0x80])?; // PWR_MGMT_1: reset
                Ok(StartStep::After(100_000))
            }
            1 => {
                self.0.write(0x06, &[AWAKE])?;
                self.0.write(0x03, &[0x10])?; // USER_CTRL: SPI alone
                Ok(StartStep::After(35_000))
            }
            _ => {
                let mut taken = [0; 2];
                self.0.write(BANK, &[0x20])?;
                self.0.write(0x00, &GYRO)?;
                self.0.write(0x10, &ACCEL_DIVIDER)?;
                self.0.write(0x14, &ACCEL)?;
                self.0.read(0x00, &mut taken)?;
                self.0.write(BANK, &[0x00])?;
                if taken == GYRO { Ok(StartStep::Done) } else { Err(StartError::NotTaken { register: 0x00 }) }
            }
        }
    }

    fn read(&mut self, burst: &mut Burst<2>) -> Result<(), R::Error> {
        // INT_STATUS_1 to TEMP_OUT_L, with what lies between: one transaction.
        let mut bytes = [0; 33];
        self.0.read(0x1A, &mut bytes)?;
        let word = |register: usize| {
            let at = register - 0x1A;
            i32::from(i16::from_be_bytes([bytes[at], bytes[at + 1]]))
        };
        let three = |first: usize| Some([word(first), word(first + 2), word(first + 4)]);
        if bytes[0] & 0x01 != 0 {
            burst.push(Frame { codes: [three(0x33), three(0x2D)], temperature: Some(word(0x39)) });
        }
        Ok(())
    }

    fn is_configured(&mut self) -> Result<bool, R::Error> {
        let mut power = [0];
        self.0.read(0x06, &mut power)?;
        Ok(power == [AWAKE])
    }
}

/// An ICM-20948 in memory that lies still on its back and turns about its x axis. On a chip this is the bus.
struct Memory {
    banks: [[u8; 128]; 4],
    bank: usize,
    readings: u8,
}

impl Memory {
    /// As after a reset.
    fn new() -> Self {
        let mut banks = [[0; 128]; 4];
        (banks[0][0x00], banks[0][0x06]) = (0xEA, 0x41);
        Self { banks, bank: 0, readings: 0 }
    }

    /// Its noise never stands still.
    fn measure(&mut self) {
        self.readings = self.readings.wrapping_add(1);
        let noise = i16::from(self.readings.wrapping_mul(7) % 5);
        self.banks[0][0x1A] = u8::from(self.banks[0][0x06] == AWAKE);
        let codes = [(0x2D, 3), (0x2F, -5), (0x31, 2_048), (0x33, 164), (0x35, 1), (0x37, -2), (0x39, 3_000)];
        for (register, code) in codes {
            let value: i16 = code + noise;
            self.banks[0][register..register + 2].copy_from_slice(&value.to_be_bytes());
        }
    }
}

impl ErrorType for Memory {
    type Error = core::convert::Infallible;
}

impl SpiDevice for Memory {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        match operations {
            [Operation::Write([BANK]), Operation::Write([bank])] => self.bank = usize::from(*bank >> 4),
            [Operation::Write([0x06]), Operation::Write([0x80])] if self.bank == 0 => *self = Self::new(),
            [Operation::Write([address]), Operation::Write(values)] => {
                let first = usize::from(*address & 0x7F);
                self.banks[self.bank][first..first + values.len()].copy_from_slice(values);
            }
            [Operation::Write([address]), Operation::Read(values)] => {
                let first = usize::from(*address & 0x7F);
                if (self.bank, first) == (0, 0x1A) {
                    self.measure();
                }
                values.copy_from_slice(&self.banks[self.bank][first..first + values.len()]);
            }
            _ => {}
        }
        Ok(())
    }
}

/// Reads for a second, at the part's rate.
pub(crate) fn samples() -> Result<Vec<Sample>, MountingError> {
    // Its z axis points down the tool, its x to the highside.
    let mounting = Mounting::from_axes([Axis::PlusX, Axis::PlusY, Axis::PlusZ])?;
    let mut source = Supervised::new(Icm20948(SpiRegisters(Memory::new())), mounting);
    let mut combiner = Combiner::new(DATA.period_us);
    let mut samples = Vec::new();
    for now_us in (0..1_000_000).step_by(4_444) {
        let mut readings = Readings::<InertialReading, BURST_FRAMES>::new();
        // An error is counted and survived: the next calls start the part anew.
        let _ = source.read(now_us, Trigger::Polled, &mut readings);
        // Each reading makes a sample, for `Probe::push`; here without a magnetometer.
        samples.extend(readings.iter().filter_map(|reading| combiner.inertial(reading)));
    }
    Ok(samples)
}

pub(crate) fn main() -> Result<(), MountingError> {
    let samples = samples()?;
    let last = samples.last().map(|last| (last.gyro_rad_s, last.accel_m_s2, last.temperature_c));
    println!("{} samples; the last: {last:.2?}", samples.len());
    Ok(())
}
