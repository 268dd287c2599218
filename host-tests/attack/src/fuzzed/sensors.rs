//! Drivers on a bus on which a part says any bytes as its status, its FIFO and its results; the settings that were
//! written to it are there, so that it starts.

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use heapless::VecView;
use meerkat_mwd::sensors::{
    Burst, Condition, InertialReading, MagneticReading, Mounting, ReadError, Rm3100Settings, Trigger,
    blocking::{InertialSource, Ism330dhcx, MagneticSource, Part, Rm3100, Supervised},
};
use std::cell::{Cell, RefCell};

/// Bytes of a word of the FIFO, and of the magnetometer's results.
const WORD: usize = 7;
const RESULTS: usize = 9;
/// Registers of the ISM330DHCX (ST DS13012): identity, reset, FIFO's status, thermometer, FIFO's output.
const WHO_AM_I: (u8, u8) = (0x0F, 0x6B);
const CTRL3_C: u8 = 0x12;
const FIFO_STATUS: u8 = 0x3A;
const OUT_TEMP: u8 = 0x20;
const FIFO_TAG: u8 = 0x78;
/// Registers of the RM3100 (PNI 1017252): identity, status, results.
const REVID: (u8, u8) = (0x36, 0x22);
const STATUS: u8 = 0x34;
const MX: u8 = 0x24;
/// Byte between two readings at which the bus fails once.
const BUS_FAILS: u8 = 0xEE;
/// Readings in which a part has started.
const STARTING: usize = 100;
/// Longest pause between two readings, microseconds, in steps of a byte.
const PAUSE_US: u64 = 250;

/// Answers of a part, and what it was told.
struct Said<'b> {
    bytes: Cell<&'b [u8]>,
    /// First addresses of what is said from the bytes.
    spoken: &'static [u8],
    settings: RefCell<[u8; 256]>,
    /// Pieces that were read from the last of `spoken` but the status: words, or results.
    read: RefCell<Vec<Vec<u8>>>,
    logged: u8,
    fails: Cell<bool>,
}

impl<'b> Said<'b> {
    fn new(bytes: &'b [u8], (identity, value): (u8, u8), spoken: &'static [u8], logged: u8) -> Self {
        let mut settings = [0; 256];
        settings[usize::from(identity)] = value;
        let (settings, read) = (RefCell::new(settings), RefCell::default());
        Self { bytes: Cell::new(bytes), spoken, settings, read, logged, fails: Cell::new(false) }
    }

    /// The next byte; 0 behind the last.
    fn byte(&self) -> u8 {
        let Some((first, rest)) = self.bytes.get().split_first() else { return 0 };
        self.bytes.set(rest);
        *first
    }

    fn is_over(&self) -> bool {
        self.bytes.get().is_empty()
    }

    /// Microseconds to the next reading; the bus may fail in it.
    fn pause_us(&self) -> u64 {
        let byte = self.byte();
        self.fails.set(byte == BUS_FAILS);
        1 + u64::from(byte) * PAUSE_US
    }
}

/// The wire to it.
struct Wire<'s, 'b>(&'s Said<'b>);

impl ErrorType for Wire<'_, '_> {
    type Error = ErrorKind;
}

impl SpiDevice for Wire<'_, '_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let said = self.0;
        if said.fails.take() {
            return Err(ErrorKind::Other);
        }
        let mut written = Vec::new();
        for operation in operations {
            match operation {
                Operation::Write(bytes) => written.extend_from_slice(bytes),
                Operation::Read(values) => {
                    let first = written.first().map_or(0, |address| address & 0x7F);
                    if said.spoken.contains(&first) {
                        values.fill_with(|| said.byte());
                        if first == said.logged {
                            said.read.borrow_mut().push(values.to_vec());
                        }
                    } else {
                        let settings = said.settings.borrow();
                        let from = settings.iter().skip(first.into());
                        values.iter_mut().zip(from).for_each(|(value, setting)| *value = *setting);
                    }
                }
                _ => return Err(ErrorKind::Other),
            }
        }
        if let Some((address, values)) = written.split_first().filter(|(address, _)| **address < 0x80) {
            let mut settings = said.settings.borrow_mut();
            let places = settings.iter_mut().skip((*address).into());
            places.zip(values).for_each(|(setting, value)| *setting = *value);
            // A reset is over before it is asked for.
            settings[usize::from(CTRL3_C)] &= !1;
        }
        Ok(())
    }
}

/// The FIFO of an ISM330DHCX: what its driver takes for a reading was in it, once, and in this order; supervised, times
/// rise, and what is read is within its range.
///
/// # Panics
/// It is not.
pub fn ism330dhcx(bytes: &[u8]) {
    const SPOKEN: [u8; 3] = [FIFO_STATUS, OUT_TEMP, FIFO_TAG];
    let said = Said::new(bytes, WHO_AM_I, &SPOKEN, FIFO_TAG);
    let mut part = Ism330dhcx::new_spi(Wire(&said), 4);
    let mut taken = [Vec::new(), Vec::new()];
    while !said.is_over() {
        let mut burst = Burst::default();
        if part.read(&mut burst).is_ok() {
            for frame in burst.frames() {
                for (taken, codes) in taken.iter_mut().zip(frame.codes) {
                    taken.extend(codes);
                }
            }
        }
        said.pause_us();
    }
    let words = said.read.borrow();
    let words = words.iter().flat_map(|burst| burst.as_chunks::<WORD>().0);
    let sound: Vec<_> = words.filter(|word| word[0].count_ones() % 2 == 0).map(codes_of_word).collect();
    for (sensor, taken) in (1..).zip(&taken) {
        let mut there = sound.iter().filter(|(tag, _)| *tag == sensor).map(|(_, codes)| codes);
        assert!(taken.iter().all(|codes| there.any(|other| other == codes)), "sensor {sensor}: {taken:?} of {sound:?}");
    }

    let said = Said::new(bytes, WHO_AM_I, &SPOKEN, FIFO_TAG);
    let mut source = Supervised::new(Ism330dhcx::new_spi(Wire(&said), 4), Mounting::ALIGNED);
    let [gyro, accel] = InertialSource::data(&source).sensors;
    supervised(
        &said,
        |now_us, out: &mut VecView<InertialReading>| InertialSource::read(&mut source, now_us, Trigger::Polled, out),
        |it| {
            let most = |of: f32| of * 32_768.0;
            let within = |values: [f32; 3], most: f32| values.iter().all(|x| x.abs() <= most * 1.000_01);
            assert!(
                within(it.gyro_rad_s, most(gyro.per_code)) && within(it.accel_m_s2, most(accel.per_code)),
                "{it:?}"
            );
            assert!(it.temperature_c.is_finite(), "{it:?}");
            it.t_us
        },
    );
}

fn codes_of_word(word: &[u8; WORD]) -> (u8, [i32; 3]) {
    let [tag, x0, x1, y0, y1, z0, z1] = *word;
    (tag >> 3, [[x0, x1], [y0, y1], [z0, z1]].map(|bytes| i16::from_le_bytes(bytes).into()))
}

/// The results of an RM3100: what its driver takes for a reading was read, once, and in this order; supervised, times
/// rise, and what is read is within 24 bits.
///
/// # Panics
/// It is not.
pub fn rm3100(bytes: &[u8]) {
    const SPOKEN: [u8; 2] = [STATUS, MX];
    let said = Said::new(bytes, REVID, &SPOKEN, MX);
    let mut part = Rm3100::new_spi(Wire(&said), Rm3100Settings::default());
    let mut taken = Vec::new();
    while !said.is_over() {
        let mut burst = Burst::default();
        if part.read(&mut burst).is_ok() {
            taken.extend(burst.frames().iter().filter_map(|frame| frame.codes[0]));
        }
        said.pause_us();
    }
    let read = said.read.borrow();
    let mut there = read.iter().flat_map(|results| results.as_chunks::<RESULTS>().0).map(|results| {
        let mut axes = results.as_chunks::<3>().0.iter();
        std::array::from_fn(|_| axes.next().map_or(0, |[a, b, c]| i32::from_be_bytes([*a, *b, *c, 0]) >> 8))
    });
    assert!(taken.iter().all(|codes: &[i32; 3]| there.any(|other| other == *codes)), "{taken:?}");

    let said = Said::new(bytes, REVID, &SPOKEN, MX);
    let mut source = Supervised::new(Rm3100::new_spi(Wire(&said), Rm3100Settings::default()), Mounting::ALIGNED);
    let [mag] = MagneticSource::data(&source).sensors;
    supervised(
        &said,
        |now_us, out: &mut VecView<MagneticReading>| MagneticSource::read(&mut source, now_us, Trigger::Polled, out),
        |it| {
            let most = mag.per_code * 8_388_608.0 * 1.000_01;
            assert!(it.mag_ut.iter().all(|x| x.abs() <= most) && it.temperature_c.is_finite(), "{it:?}");
            it.t_us
        },
    );
}

/// Reads until nothing more is said. `judge` looks at a reading and gives its time.
fn supervised<T: Clone>(
    said: &Said<'_>,
    mut read: impl FnMut(u64, &mut VecView<T>) -> Result<Condition, ReadError<ErrorKind>>,
    judge: impl Fn(&T) -> u64,
) {
    let (mut now_us, mut last_us) = (1_000_000, None);
    let mut out = heapless::Vec::<T, 32>::new();
    let mut is_started = false;
    // Before the start nothing is taken, and a byte at least with each reading after it.
    for _ in 0..STARTING + said.bytes.get().len() {
        if said.is_over() {
            return;
        }
        out.clear();
        let result = read(now_us, &mut out);
        for reading in &out {
            let t_us = judge(reading);
            assert!(last_us.is_none_or(|last| t_us > last), "{t_us} us after {last_us:?}");
            last_us = Some(t_us);
        }
        is_started |= result != Ok(Condition::Starting);
        now_us += if is_started { said.pause_us() } else { 1_000 };
    }
    assert!(is_started, "it never started");
}
