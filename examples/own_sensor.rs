//! A sensor of one's own: an adapter for ST's magnetometer LIS3MDL on SPI, written from its data sheet, and the
//! supervision and the combiner of the library on it.
//!
//! `cargo run --example own_sensor --features bus`

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use meerkat_mwd::{
    SampleFlags,
    sensors::{
        Axis, Burst, Combiner, Frame, InertialReading, MagneticData, MagneticReading, Mounting, MountingError,
        PartData, SensorData, StartError, StartStep, TemperatureData, Trigger,
        blocking::{MagneticSource, Part, Registers, SpiRegisters, Supervised},
    },
};

/// Bit of an address with which it counts up.
const MANY: u8 = 0x40;
/// CTRL_REG1 to 5: thermometer, 80 Hz, 400 uT, continuous, best on all axes, whole readings.
const SETTINGS: [u8; 5] = [0xFC, 0x00, 0x00, 0x0C, 0x40];
/// Half of the time between readings; noise of 0.32 uT rms at 80 readings a second.
const SENSOR: SensorData = SensorData {
    full_scale: 400.0,
    per_code: 100.0 / 6842.0,
    clip_code: 27_368,
    latency_s: [0.006; 3],
    noise_density: Some(0.05),
};
const DATA: MagneticData = PartData {
    name: "LIS3MDL",
    source: "ST DocID024204, tables 3 and 21",
    sensors: [SENSOR], // two for Part<2>: the gyro, then the accelerometer
    temperature: Some(TemperatureData { offset_c: 25.0, per_code_c: 0.125 }),
    period_us: 12_500,
    period_tolerance: 0.1,
    fifo_frames: 1,
    watermark_frames: 1,
    settling_frames: 2,
    frozen_frames: 20,
};

/// The adapter, over the part's registers.
struct Lis3mdl<R>(R);

impl<R: Registers> Part<1> for Lis3mdl<R> {
    type Error = R::Error;

    fn data(&self) -> MagneticData {
        DATA
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<R::Error>> {
        if step == 0 {
            let mut found = [0];
            self.0.read(0x0F, &mut found)?; // WHO_AM_I
            if found != [0x3D] {
                return Err(StartError::WrongIdentity { expected: 0x3D, found: found[0] });
            }
            self.0.write(0x21, &[0x04])?; // CTRL_REG2: reset
            return Ok(StartStep::After(10_000));
        }
        self.0.write(0x20 | MANY, &SETTINGS)?;
        if self.is_configured()? { Ok(StartStep::Done) } else { Err(StartError::NotTaken { register: 0x20 }) }
    }

    fn read(&mut self, burst: &mut Burst<1>) -> Result<(), R::Error> {
        let mut bytes = [0; 9];
        self.0.read(0x27 | MANY, &mut bytes)?; // STATUS_REG, three axes, temperature: one transaction
        let [status, x0, x1, y0, y1, z0, z1, t0, t1] = bytes;
        let code = |low, high| i32::from(i16::from_le_bytes([low, high]));
        if status & 0x08 != 0 {
            let codes = [Some([code(x0, x1), code(y0, y1), code(z0, z1)])];
            burst.push(Frame { codes, temperature: Some(code(t0, t1)) });
        }
        Ok(())
    }

    fn is_configured(&mut self) -> Result<bool, R::Error> {
        let mut settings = [0; 5];
        self.0.read(0x20 | MANY, &mut settings)?;
        Ok(settings == SETTINGS)
    }
}

/// A LIS3MDL in memory that reads 20 uT on its x axis. On a chip this is the bus.
struct Memory([u8; 64]);

impl Memory {
    fn new() -> Self {
        let mut memory = [0; 64];
        memory[0x0F] = 0x3D;
        memory[0x28..0x2A].copy_from_slice(&1_368_i16.to_le_bytes());
        Self(memory)
    }

    /// Polled at 200 Hz, it measures at 80; its noise never stands still.
    fn measure(&mut self) {
        self.0[0x3F] = (self.0[0x3F] + 2) % 5;
        self.0[0x27] = if self.0[0x3F] < 2 { 0x08 } else { 0 };
        for low in [0x28, 0x2A, 0x2C] {
            self.0[low] = self.0[low].wrapping_add(1);
        }
    }
}

impl ErrorType for Memory {
    type Error = core::convert::Infallible;
}

impl SpiDevice for Memory {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        match operations {
            [Operation::Write([address]), Operation::Write(values)] => {
                let first = usize::from(*address & 0x3F);
                self.0[first..first + values.len()].copy_from_slice(values);
            }
            [Operation::Write([address]), Operation::Read(values)] => {
                let first = usize::from(*address & 0x3F);
                values.copy_from_slice(&self.0[first..first + values.len()]);
                if first == 0x27 {
                    self.measure();
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Reads for a second at 200 Hz. Returns the fields of the samples that have one, microtesla.
pub(crate) fn fields() -> Result<Vec<[f32; 3]>, MountingError> {
    // Its x axis points down the tool, its z to the highside.
    let mounting = Mounting::from_axes([Axis::PlusZ, Axis::PlusY, Axis::MinusX])?;
    let mut source = Supervised::new(Lis3mdl(SpiRegisters(Memory::new())), mounting);
    let mut combiner = Combiner::new(5_000);
    let mut fields = Vec::new();
    for now_us in (0..1_000_000).step_by(5_000) {
        let mut readings = heapless::Vec::<MagneticReading, 16>::new();
        // An error is counted and survived: the next calls start the part anew.
        let _ = source.read(now_us, Trigger::Polled, &mut readings);
        readings.into_iter().for_each(|reading| combiner.magnetic(reading));
        // Here a gyro that reads nothing. Each reading of the gyro's source makes a sample, for `Probe::push`.
        let reading = InertialReading { t_us: now_us, ..InertialReading::default() };
        let sample = combiner.inertial(&reading);
        fields.extend(sample.filter(|s| !s.flags.contains(SampleFlags::MAG_MISSING)).map(|s| s.mag_ut));
    }
    Ok(fields)
}

pub(crate) fn main() -> Result<(), MountingError> {
    let fields = fields()?;
    println!("{} samples with a field; the last: {:.1?} uT", fields.len(), fields.last());
    Ok(())
}
