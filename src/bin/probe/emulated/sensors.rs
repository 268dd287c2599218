//! The sensors: a recording that goes on with the clock, whatever the probe does, and is read in PendSV.

use super::boot::Hang;
use crate::{
    application::{
        acquisition::{Acquisition, COUNTS},
        sample_clock,
        stage::Stage,
    },
    reset_record,
};
use core::{
    cell::RefCell,
    sync::atomic::{AtomicBool, Ordering},
};
use cortex_m_rt::exception;
use critical_section::Mutex;
use meerkat_mwd::{Sample, SampleFlags};
use semihosting::{
    fs::File,
    io::{Read, Seek, SeekFrom},
};

/// Ten f32 (gyro, accelerometer, magnetometer, temperature, in a sample's units) and the flags, little-endian.
const RECORD: usize = 42;

struct Sensors {
    file: File,
    acquisition: Acquisition,
    period_us: u32,
    rounds: u64,
    hang: Option<Hang>,
}

static SENSORS: Mutex<RefCell<Option<Sensors>>> = Mutex::new(RefCell::new(None));
static OVER: AtomicBool = AtomicBool::new(false);

/// Before the clock.
pub fn start(acquisition: Acquisition, period_us: u32, hang: Option<Hang>) -> Result<(), &'static str> {
    let mut file = File::open(c"sensors.bin").map_err(|_| "sensors.bin cannot be opened")?;
    let gone_by = u64::from(reset_record::powered_rounds()) * RECORD as u64;
    file.seek(SeekFrom::Start(gone_by)).map_err(|_| "sensors.bin is over")?;
    let sensors = Sensors { file, acquisition, period_us, rounds: 0, hang };
    critical_section::with(|cs| SENSORS.borrow(cs).replace(Some(sensors)));
    Ok(())
}

/// Whether the recording has come to its end.
pub fn are_over() -> bool {
    OVER.load(Ordering::Relaxed)
}

#[exception]
fn PendSV() {
    static mut MINE: Option<Sensors> = None;
    if MINE.is_none() {
        *MINE = critical_section::with(|cs| SENSORS.borrow(cs).take());
    }
    if let Some(sensors) = MINE {
        sensors.read();
    }
}

impl Sensors {
    fn read(&mut self) {
        let rounds = sample_clock::rounds();
        let missed = rounds.saturating_sub(self.rounds).saturating_sub(1);
        self.rounds = rounds;
        let missed = u32::try_from(missed).unwrap_or(u32::MAX);
        self.acquisition.served(missed);
        if missed > 0 {
            self.acquisition.lost(missed);
            for _ in 0..missed {
                let _ = self.next();
            }
        }
        let at_sample = COUNTS.acquired();
        if self.hang.is_some_and(|hang| hang.stage == Stage::Acquisition && at_sample >= hang.at_sample) {
            loop {
                cortex_m::asm::nop();
            }
        }
        match self.next() {
            Some(sample) => {
                // The moment of the tick, not of its service: that is when a sensor latches its reading.
                self.acquisition.put(Sample { t_us: rounds * u64::from(self.period_us), ..sample });
            }
            None => OVER.store(true, Ordering::Relaxed),
        }
    }

    fn next(&mut self) -> Option<Sample> {
        let mut record = [0; RECORD];
        let mut used = 0;
        while used < RECORD {
            match self.file.read(record.get_mut(used..).unwrap_or_default()) {
                Ok(0) | Err(_) => return None,
                Ok(read) => used += read,
            }
        }
        let (numbers, rest) = record.as_chunks::<4>();
        let number = |index: usize| f32::from_le_bytes(numbers.get(index).copied().unwrap_or_default());
        let vector = |index: usize| [number(index), number(index + 1), number(index + 2)];
        let flags = rest.first_chunk::<2>().map_or(0, |bytes| u16::from_le_bytes(*bytes));
        Some(Sample {
            t_us: 0,
            gyro_rad_s: vector(0),
            accel_m_s2: vector(3),
            mag_ut: vector(6),
            temperature_c: number(9),
            flags: SampleFlags::from_bits_truncate(flags),
        })
    }
}
