//! A part with a checksum over each frame: Murata's accelerometer SCA3300-D01, through the same traits. No
//! bit that the wire flips gets through, however small, on the way there or back; without the checksum the
//! small ones do.

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use meerkat_mwd::SampleFlags;
use meerkat_mwd::sensors::{
    Burst, Condition, Frame, MagneticData, MagneticReading, Mounting, PartData, SensorData, StartError, StartStep,
    Trigger,
    blocking::{MagneticSource, Part, Supervised},
};
use std::{
    cell::{Cell, RefCell},
    convert::Infallible,
};

// Murata document 3165: sections "SPI frame", "Checksum (CRC)" and "Operations". A frame is bit 7 to write,
// an address of five bits, two bits of return status, sixteen of data, and the checksum of those 24 bits:
// x^8 + x^4 + x^3 + x^2 + 1, begun with ones, inverted. What a frame asks for comes in the next.
const WRITE: u8 = 1 << 5;
const AXES: [u8; 3] = [1, 2, 3];
const STATUS: u8 = 6;
const MODE: u8 = 0xD;
const IDENTITY_AT: u8 = 0x10;
const IDENTITY: u8 = 0x51;
const RESET: u16 = 0x20;
const PER_CODE_M_S2: f32 = 9.806_65 / 2_700.0;
const NORMAL: u8 = 1;
const PERIOD_US: u64 = 5_000;

fn crc8(bytes: &[u8]) -> u8 {
    let bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
    !bits.fold(0xFF_u8, |crc, bit| if crc >> 7 ^ bit != 0 { crc << 1 ^ 0x1D } else { crc << 1 })
}

fn framed(head: u8, data: u16) -> [u8; 4] {
    let [high, low] = data.to_be_bytes();
    [head, high, low, crc8(&[head, high, low])]
}

#[test]
fn the_checksum_gives_the_frames_that_the_data_sheet_prints() {
    assert_eq!(framed(1 << 2, 0), [0x04, 0x00, 0x00, 0xF7]);
    assert_eq!(framed(2 << 2, 0), [0x08, 0x00, 0x00, 0xFD]);
    assert_eq!(framed(STATUS << 2, 0), [0x18, 0x00, 0x00, 0xE5]);
    assert_eq!(framed(IDENTITY_AT << 2, 0), [0x40, 0x00, 0x00, 0x91]);
    assert_eq!(framed((WRITE | MODE) << 2, RESET), [0xB4, 0x00, 0x20, 0x98]);
}

/// The adapter; `checks` tells whether it verifies the checksum.
struct Sca3300<S> {
    spi: S,
    checks: bool,
}

impl<S: SpiDevice> Sca3300<S> {
    /// Asks for a register, and returns what the frame before asked for if the answer is sound and belongs to
    /// `expected`.
    fn ask(&mut self, register: u8, data: u16, expected: u8) -> Result<Option<u16>, S::Error> {
        let mut answer = [0; 4];
        self.spi.transaction(&mut [Operation::Transfer(&mut answer, &framed(register << 2, data))])?;
        let [head, high, low, crc] = answer;
        let sound = !self.checks || crc8(&[head, high, low]) == crc;
        Ok((sound && head == expected << 2 | NORMAL).then_some(u16::from_be_bytes([high, low])))
    }

    fn register(&mut self, register: u8) -> Result<Option<u16>, S::Error> {
        self.ask(register, 0, register)?;
        self.ask(register, 0, register)
    }
}

impl<S: SpiDevice> Part<1> for Sca3300<S> {
    type Error = S::Error;

    fn data(&self) -> MagneticData {
        PartData {
            name: "SCA3300-D01",
            source: "Murata document 3165",
            sensors: [SensorData {
                full_scale: 3.0 * 9.806_65,
                per_code: PER_CODE_M_S2,
                clip_code: 8_100,
                latency_s: [0.003; 3],
                noise_density: Some(37e-6 * 9.806_65),
            }],
            temperature: None,
            period_us: PERIOD_US as u32,
            period_tolerance: 0.1,
            fifo_frames: 1,
            watermark_frames: 1,
            settling_frames: 5,
            frozen_frames: 20,
        }
    }

    fn start(&mut self, step: u8) -> Result<StartStep, StartError<S::Error>> {
        if step == 0 {
            self.ask(WRITE | MODE, RESET, MODE)?;
            return Ok(StartStep::After(1_000));
        }
        if step == 1 {
            self.ask(WRITE | MODE, 0, MODE)?;
            return Ok(StartStep::After(15_000));
        }
        // The status of the start is cleared by reading it.
        self.register(STATUS)?;
        self.register(STATUS)?;
        let found = self.register(IDENTITY_AT)?.map_or(0, |found| found as u8);
        if found != IDENTITY {
            return Err(StartError::WrongIdentity { expected: IDENTITY, found });
        }
        if self.is_configured()? { Ok(StartStep::Done) } else { Err(StartError::NotTaken { register: MODE }) }
    }

    fn read(&mut self, burst: &mut Burst<1>) -> Result<(), S::Error> {
        let [x, y, z] = AXES;
        self.ask(x, 0, MODE)?;
        let axes = [self.ask(y, 0, x)?, self.ask(z, 0, y)?, self.ask(STATUS, 0, z)?];
        let codes = match axes {
            [Some(x), Some(y), Some(z)] => Some([x, y, z].map(|code| i32::from(code.cast_signed()))),
            _ => {
                burst.corrupt += 1;
                None
            }
        };
        burst.push(Frame { codes: [codes], temperature: None });
        Ok(())
    }

    fn is_configured(&mut self) -> Result<bool, S::Error> {
        Ok(self.register(MODE)? == Some(0))
    }
}

/// The part, and a wire that flips one bit: 0 to 31 of an answer, 32 to 63 of a question.
struct Model {
    codes: [i16; 3],
    mode: u16,
    answer: [u8; 4],
    transactions: u32,
    flip: Option<(u32, u8)>,
}

struct Wire<'a>(&'a RefCell<Model>);

impl ErrorType for Wire<'_> {
    type Error = Infallible;
}

impl SpiDevice for Wire<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let [Operation::Transfer(answer, question)] = operations else { panic!("not a frame") };
        let mut model = self.0.borrow_mut();
        let bit = model.flip.filter(|(at, _)| *at == model.transactions).map(|(_, bit)| usize::from(bit));
        model.transactions += 1;
        let flipped = |frame: [u8; 4], from: usize| -> [u8; 4] {
            let mut frame = frame;
            if let Some(bit) = bit.and_then(|bit| bit.checked_sub(from)).filter(|bit| *bit < 32) {
                frame[bit / 8] ^= 0x80 >> (bit % 8);
            }
            frame
        };
        answer.copy_from_slice(&flipped(model.answer, 0));
        let [head, high, low, crc] = flipped((*question).try_into().unwrap(), 32);
        let (register, data) = (head >> 2 & 0x1F, u16::from_be_bytes([high, low]));
        const ERROR: u8 = 3;
        if crc8(&[head, high, low]) != crc {
            model.answer = framed(head & !3 | ERROR, 0);
            return Ok(());
        }
        if head >> 7 != 0 && register == MODE {
            model.mode = data & !RESET;
        }
        let value = match register {
            1..=3 => model.codes[usize::from(register) - 1].cast_unsigned(),
            MODE => model.mode,
            IDENTITY_AT => IDENTITY.into(),
            _ => 0,
        };
        model.answer = framed(register << 2 | NORMAL, value);
        Ok(())
    }
}

/// Swings by more than a g about each axis, with some codes of noise.
fn truth(k: u64) -> [i16; 3] {
    let t = k as f32 * 0.07;
    let noise = |axis: u64| (k.wrapping_mul(7_919 + 104 * axis) % 13) as f32 - 6.0;
    [0, 1, 2].map(|axis| (3_000.0 * libm::sinf(t + 2.0 * axis as f32) + noise(axis)) as i16)
}

#[derive(Debug, Default, PartialEq)]
struct Outcome {
    transactions: u32,
    readings: usize,
    withheld: usize,
    wrong: usize,
    largest_m_s2: f32,
    recovered: bool,
}

fn run(checks: bool, flip: Option<(u32, u8)>) -> Outcome {
    let model = RefCell::new(Model { codes: [0; 3], mode: 0, answer: [0; 4], transactions: 0, flip });
    let part = Sca3300 { spi: Wire(&model), checks };
    let mut source = Supervised::new(part, Mounting::ALIGNED);
    let mut outcome = Outcome::default();
    let last = Cell::new(None);
    for k in 0..60 {
        model.borrow_mut().codes = truth(k);
        let mut out = heapless::Vec::<MagneticReading, 8>::new();
        last.set(source.read(k * PERIOD_US, Trigger::Interrupt, &mut out).ok());
        for reading in out {
            outcome.readings += 1;
            if reading.flags.contains(SampleFlags::MAG_MISSING) {
                outcome.withheld += 1;
                continue;
            }
            let right = truth(k).map(|code| f32::from(code) * PER_CODE_M_S2);
            let errors = reading.mag_ut.into_iter().zip(right).map(|(x, right)| (x - right).abs());
            let largest = errors.fold(0.0, |most, x| if x > most { x } else { most });
            outcome.wrong += usize::from(largest > 0.0);
            outcome.largest_m_s2 = if largest > outcome.largest_m_s2 { largest } else { outcome.largest_m_s2 };
        }
    }
    outcome.transactions = model.borrow().transactions;
    outcome.recovered = last.get() == Some(Condition::Running);
    outcome
}

#[test]
fn no_flipped_bit_of_a_checked_frame_is_believed() {
    let clean = run(true, None);
    assert!(clean.recovered && clean.wrong == 0 && clean.withheld == 0 && clean.readings > 45, "{clean:?}");
    let all = |checks| {
        let flips = (0..clean.transactions).flat_map(|at| (0..64).map(move |bit| (at, bit)));
        flips.map(move |flip| run(checks, Some(flip))).collect::<Vec<_>>()
    };
    let checked = all(true);
    assert!(checked.len() > 12_000);
    assert!(checked.iter().all(|outcome| outcome.wrong == 0 && outcome.recovered));
    // Three of a reading's six frames carry data, each with its question: what is flipped there must be
    // withheld.
    let seen = checked.iter().filter(|outcome| outcome.withheld > 0 || outcome.readings < clean.readings).count();
    assert!(seen * 20 > checked.len() * 9, "{seen} of {}", checked.len());
    let unchecked = all(false);
    let wrong = unchecked.iter().filter(|outcome| outcome.wrong > 0).count();
    let largest = unchecked.iter().fold(0.0, |most, o| if o.largest_m_s2 > most { o.largest_m_s2 } else { most });
    println!("{} flips: none believed with the checksum, {wrong} without, up to {largest:.2} m/s^2", checked.len());
    assert!(wrong > 500, "a checksum that nothing depends on shows nothing: {wrong}");
}
