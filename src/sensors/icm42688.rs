//! Adapter of TDK's gyro and accelerometer ICM-42688-P.

use icm426xx::{
    fifo::FifoPacket4,
    register_bank::{
        Register,
        bank0::{
            ACCEL_CONFIG0, DEVICE_CONFIG, FIFO_CONFIG, FIFO_CONFIG1, GYRO_CONFIG0, INT_CONFIG, INT_CONFIG1, INT_STATUS,
            INTF_CONFIG0, INTF_CONFIG1, PWR_MGMT0, REG_BANK_SEL, SIGNAL_PATH_RESET, WHO_AM_I,
        },
    },
};

use super::{Part, Registers, SpiDevice, SpiRegisters, bisync};
use crate::{
    sensors::{BURST_FRAMES, Burst, Frame, InertialData, PartData, SensorData, StartError, StartStep, TemperatureData},
    units::STANDARD_GRAVITY_M_S2,
};

// Register names of TDK DS-000347, data sheet of the ICM-42688-P, section 14. The crate icm426xx gives them and the
// FIFO's packet; its own start is not used: it keeps the bus when it fails, waits, and is either blocking or
// asynchronous.
#[bisync]
const IDENTITY: u8 = 0x47;
#[bisync]
const SOFT_RESET: u8 = 1;
#[bisync]
const RESET_US: u32 = 1_000;
/// Low-noise mode of gyro and accelerometer; no register may be written for 200 us after it is set.
#[bisync]
const LOW_NOISE: u8 = 0b1111;
#[bisync]
const POWERED_US: u32 = 200;
/// One value for the configuration register of either sensor: its widest range, 2000 dps of the gyro and 16 g of the
/// accelerometer (0 in bits 7 to 5), and 200 Hz (7 in bits 3 to 0).
#[bisync]
const WIDEST_200_HZ: u8 = 0b0000_0111;
#[bisync]
const STREAM: u8 = 0b0100_0000;
/// Bits FIFO_RESUME_PARTIAL_RD, FIFO_WM_GT_TH, FIFO_HIRES_EN, and temperature, gyro and accelerometer in each
/// packet.
#[bisync]
const PACKETS_OF_20_BITS: u8 = 0b0111_0111;
/// Registers FIFO_CONFIG1 to FIFO_CONFIG3: settings and watermark of the FIFO; the watermark is one packet.
#[bisync]
const FIFO_SETTINGS: [u8; 3] = [PACKETS_OF_20_BITS, 1, 0];
/// Count in packets (FIFO_COUNT), high byte first as in the data, SPI only.
#[bisync]
const COUNT_PACKETS: u8 = 0b0111_0011;
/// Clock from the PLL, adaptive full scale off.
#[bisync]
const CLOCK_PLL: u8 = 0b0101_0001;
/// Interrupt INT1: pulsed, push-pull, active high.
#[bisync]
const INT1_PULSED_HIGH: u8 = 0b0000_0011;
/// Registers INT_CONFIG1 with INT_ASYNC_RESET clear, as required, and INT_SOURCE0 with FIFO_THS_INT1_EN.
#[bisync]
const INT1_WATERMARK: [u8; 2] = [0, 0b0000_0100];
#[bisync]
const FLUSH_FIFO: u8 = 0b0000_0010;
#[bisync]
const FIFO_FULL: u8 = 0b0000_0010;
#[bisync]
const PACKET: usize = size_of::<FifoPacket4>();
/// Bytes before the data: INT_STATUS, FIFO_COUNTH and FIFO_COUNTL, at successive addresses.
#[bisync]
const HEAD: usize = 3;
/// Packets in the FIFO's 2 kbytes.
#[bisync]
const FIFO_PACKETS: u16 = 2_048 / PACKET as u16;
/// Code of an axis without a valid reading: -32768 in the upper 16 bits; the low four bits may be any.
#[bisync]
const INVALID: i32 = -524_288;

/// Adapter of TDK's ICM-42688-P: 200 Hz, 2000 dps, 16 g, 20 bits, through its FIFO, on SPI, mode 0 or 3, at
/// most 24 MHz.
#[derive(Clone, Debug)]
#[bisync]
pub struct Icm42688<S> {
    registers: SpiRegisters<S>,
    /// Packets expected in the next burst: their true number is known only after they have been read.
    expected: usize,
    /// True if the next packet may not begin where the FIFO is read: after a spoilt packet or a burst that failed.
    adrift: bool,
}

#[bisync]
impl<S: SpiDevice> Icm42688<S> {
    /// Creates an adapter. Touches no bus.
    pub fn new(spi: S) -> Self {
        Self { registers: SpiRegisters(spi), expected: 1, adrift: false }
    }

    /// Returns the bus.
    pub fn release(self) -> S {
        self.registers.0
    }

    /// Empties the FIFO, which then begins with a whole packet.
    async fn flush(&mut self) -> Result<(), S::Error> {
        self.registers.write(SIGNAL_PATH_RESET::ID, &[FLUSH_FIFO]).await?;
        self.expected = 1;
        self.adrift = false;
        Ok(())
    }

    fn frame(packet: &[u8; PACKET]) -> Option<Frame<2>> {
        let packet: FifoPacket4 = bytemuck::cast(*packet);
        let header = packet.fifo_header;
        // HEADER_MSG clear; accelerometer, gyro and 20 bits set.
        if header & 0b1111_0000 != 0b0111_0000 {
            return None;
        }
        let valid = |codes: [i32; 3]| codes.iter().all(|code| *code > INVALID + 15).then_some(codes);
        let gyro = [packet.gyro_data_x(), packet.gyro_data_y(), packet.gyro_data_z()];
        let accel = [packet.accel_data_x(), packet.accel_data_y(), packet.accel_data_z()];
        let temperature = i32::from(packet.temperature_raw().cast_signed());
        Some(Frame { codes: [valid(gyro), valid(accel)], temperature: Some(temperature) })
    }
}

#[bisync]
impl<S: SpiDevice> Part<2> for Icm42688<S> {
    type Error = S::Error;

    fn data(&self) -> InertialData {
        // The part puts 19 bits of the gyro and 18 of the accelerometer into 20: 131 codes per degree per second and
        // 8192 per g, times 2 and 4 for the unused low bits.
        const CODES_PER_DPS: f32 = 262.144;
        const CODES_PER_G: f32 = 32_768.0;
        const G: f32 = STANDARD_GRAVITY_M_S2;
        // Bandwidth of UI_FILT_BW 1, the default: a quarter of 400 Hz, the lowest rate at which this filter runs.
        const BANDWIDTH_HZ: f32 = 100.0;
        let latency_s = [SensorData::low_pass_latency_s(BANDWIDTH_HZ); 3];
        let clip_code = 524_256;
        PartData {
            name: "ICM-42688-P",
            source: "TDK DS-000347, tables 1 and 2; latency derived from the bandwidth of the UI filter",
            sensors: [
                SensorData {
                    full_scale: 2000.0_f32.to_radians(),
                    per_code: (1.0 / CODES_PER_DPS).to_radians(),
                    clip_code,
                    latency_s,
                    noise_density: Some(0.0028_f32.to_radians()),
                },
                SensorData {
                    full_scale: 16.0 * G,
                    per_code: G / CODES_PER_G,
                    clip_code,
                    latency_s,
                    noise_density: Some(70e-6 * G),
                },
            ],
            temperature: Some(TemperatureData { offset_c: 25.0, per_code_c: 1.0 / 132.48 }),
            period_us: 5_000,
            period_tolerance: 0.05,
            fifo_frames: FIFO_PACKETS,
            watermark_frames: 1,
            // The gyro's start-up time: 45 ms at most.
            settling_frames: 10,
            frozen_frames: 20,
        }
    }

    async fn start(&mut self, step: u8) -> Result<StartStep, StartError<S::Error>> {
        match step {
            0 => {
                self.registers.write(REG_BANK_SEL::ID, &[0]).await?;
                let mut identity = [0];
                self.registers.read(WHO_AM_I::ID, &mut identity).await?;
                if identity != [IDENTITY] {
                    let [found] = identity;
                    return Err(StartError::WrongIdentity { expected: IDENTITY, found });
                }
                self.registers.write(DEVICE_CONFIG::ID, &[SOFT_RESET]).await?;
                Ok(StartStep::After(RESET_US))
            }
            1 => {
                let writes: [(u8, &[u8]); 7] = [
                    (INT_CONFIG::ID, &[INT1_PULSED_HIGH]),
                    (INT_CONFIG1::ID, &INT1_WATERMARK),
                    (INTF_CONFIG0::ID, &[COUNT_PACKETS]),
                    (INTF_CONFIG1::ID, &[CLOCK_PLL]),
                    (GYRO_CONFIG0::ID, &[WIDEST_200_HZ]),
                    (ACCEL_CONFIG0::ID, &[WIDEST_200_HZ]),
                    (FIFO_CONFIG1::ID, &FIFO_SETTINGS),
                ];
                for (register, values) in writes {
                    self.registers.write(register, values).await?;
                }
                // INTF_CONFIG0 and INTF_CONFIG1, then the FIFO: with these wrong every packet or time is misread.
                let mut interface = [0; 2];
                self.registers.read(INTF_CONFIG0::ID, &mut interface).await?;
                if interface != [COUNT_PACKETS, CLOCK_PLL] {
                    return Err(StartError::NotTaken { register: INTF_CONFIG0::ID });
                }
                let mut fifo = [0; 3];
                self.registers.read(FIFO_CONFIG1::ID, &mut fifo).await?;
                if fifo != FIFO_SETTINGS {
                    return Err(StartError::NotTaken { register: FIFO_CONFIG1::ID });
                }
                self.registers.write(PWR_MGMT0::ID, &[LOW_NOISE]).await?;
                Ok(StartStep::After(POWERED_US))
            }
            _ => {
                self.registers.write(FIFO_CONFIG::ID, &[STREAM]).await?;
                self.flush().await?;
                if !self.is_configured().await? {
                    return Err(StartError::NotTaken { register: PWR_MGMT0::ID });
                }
                Ok(StartStep::Done)
            }
        }
    }

    async fn read(&mut self, burst: &mut Burst<2>) -> Result<(), S::Error> {
        let flushed = self.adrift;
        if flushed {
            self.flush().await?;
        }
        let mut bytes = [0; HEAD + BURST_FRAMES * PACKET];
        let expected = self.expected;
        let Some(bytes) = bytes.get_mut(..HEAD + expected * PACKET) else { return Ok(()) };
        // The address stays at FIFO_DATA: status, count and packets are one transaction.
        self.adrift = true;
        self.registers.read(INT_STATUS::ID, bytes).await?;
        let Some(([status, high, low], packets)) = bytes.split_first_chunk::<HEAD>() else { return Ok(()) };
        burst.overrun = flushed || status & FIFO_FULL != 0;
        let count = usize::from(u16::from_be_bytes([*high, *low]));
        for packet in packets.as_chunks::<PACKET>().0.iter().take(count) {
            match Self::frame(packet) {
                Some(frame) => burst.push(frame),
                None => {
                    burst.corrupt = burst.corrupt.saturating_add(1);
                    burst.push(Frame::default());
                }
            }
        }
        self.adrift = burst.corrupt > 0;
        let left = count.saturating_sub(expected);
        burst.left = left.min(FIFO_PACKETS.into()) as u16;
        // Packets come at a steady rate: expect as many as now, or the rest that was left.
        self.expected = (if left > 0 { left } else { count }).clamp(1, BURST_FRAMES);
        Ok(())
    }

    async fn is_configured(&mut self) -> Result<bool, S::Error> {
        // PWR_MGMT0, GYRO_CONFIG0 and ACCEL_CONFIG0; 0, 6 and 6 after a reset.
        let mut settings = [0; 3];
        self.registers.read(PWR_MGMT0::ID, &mut settings).await?;
        Ok(settings == [LOW_NOISE, WIDEST_200_HZ, WIDEST_200_HZ])
    }
}
