//! The sensors: register models, played a recording that goes on with the clock whatever the probe does, and the
//! adapters on them, which are served in PendSV.

use super::boot::Hang;
use crate::{
    reset_record,
    sample_clock::{self, COUNTS},
};
use core::{
    cell::Cell,
    mem::MaybeUninit,
    sync::atomic::{AtomicBool, Ordering},
};
use cortex_m_rt::exception;
use critical_section::Mutex;
use meerkat_mwd::{
    Sample, SampleFlags,
    application::{Acquisition, Stage},
    emulation::{Conversions, ModelledParts, Recording, RecordingPlayer},
};
use semihosting::{
    fs::File,
    io::{Read, Seek, SeekFrom},
};

/// Ten f32 (gyro, accelerometer, magnetometer, temperature, in a sample's units) and the flags, little-endian.
const RECORD: usize = 42;

/// Depth of the FIFO that is modelled: the same as on the host.
const WORDS: usize = 16;

/// Models that stand for the hardware, and the adapters on them, in static RAM.
pub struct Modelled {
    parts: MaybeUninit<ModelledParts<WORDS>>,
    player: MaybeUninit<RecordingPlayer<'static, WORDS>>,
}

impl Modelled {
    pub const fn new() -> Self {
        Self { parts: MaybeUninit::uninit(), player: MaybeUninit::uninit() }
    }
}

/// State of the interrupt that reads the sensors.
struct Sensors {
    file: File,
    player: &'static mut RecordingPlayer<'static, WORDS>,
    acquisition: Acquisition<'static>,
    period_us: u32,
    rounds: u64,
    hang: Option<Hang>,
}

// SAFETY: the cells of the parts, to which the player refers, are reached through it alone: it is handed over whole.
#[allow(unsafe_code)]
unsafe impl Send for Sensors {}

static SENSORS: Mutex<Cell<Option<Sensors>>> = Mutex::new(Cell::new(None));
static OVER: AtomicBool = AtomicBool::new(false);

/// Switches the parts on and lets them settle. Call it before the sample clock starts.
#[inline(never)]
pub fn start(
    modelled: &'static mut Modelled,
    acquisition: Acquisition<'static>,
    recording: Recording,
    hang: Option<Hang>,
) -> Result<(), &'static str> {
    let mut file = File::open(c"sensors.bin").map_err(|_| "sensors.bin cannot be opened")?;
    let gone_by = SeekFrom::Start(u64::from(reset_record::powered_rounds()) * RECORD as u64);
    file.seek(gone_by).map_err(|_| "sensors.bin is over")?;
    let period_us = recording.inertial_us;
    let first = Sample { t_us: period_us.into(), ..read(&mut file).unwrap_or_default() };
    file.seek(gone_by).map_err(|_| "sensors.bin is over")?;

    let parts = modelled.parts.write(ModelledParts::new(Conversions::WithEverySample));
    let player = modelled.player.write(RecordingPlayer::new(parts, recording));
    player.settle(&first);
    let sensors = Sensors { file, player, acquisition, period_us, rounds: 0, hang };
    critical_section::with(|cs| SENSORS.borrow(cs).set(Some(sensors)));
    Ok(())
}

/// Returns true if the recording has ended.
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
        self.acquisition.served(u32::try_from(missed).unwrap_or(u32::MAX));
        let at_sample = COUNTS.acquired();
        if self.hang.is_some_and(|hang| hang.stage == Stage::Acquisition && at_sample >= hang.at_sample) {
            loop {
                cortex_m::asm::nop();
            }
        }
        // Readings of missed rounds wait in the part's FIFO.
        while self.rounds < rounds {
            self.rounds += 1;
            let Some(truth) = read(&mut self.file) else { return OVER.store(true, Ordering::Relaxed) };
            // The time of the tick, not of its service: a sensor latches its reading then.
            let tick_us = self.rounds * u64::from(self.period_us);
            self.player.pass_to(&Sample { t_us: tick_us, ..truth });
            self.acquisition.put(serve(self.player), tick_us);
        }
    }
}

/// A function of its own, so that the adapters are counted as firmware and not as models of hardware.
#[inline(never)]
fn serve(player: &mut RecordingPlayer<'static, WORDS>) -> Sample {
    player.service()
}

/// Returns the next truth; `None`: the recording is over.
fn read(file: &mut File) -> Option<Sample> {
    let mut record = [0; RECORD];
    let mut used = 0;
    while used < RECORD {
        match file.read(record.get_mut(used..).unwrap_or_default()) {
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
