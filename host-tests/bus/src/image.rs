//! What runs after reset.

use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use heapless::Vec;
use meerkat_mwd::{
    Sample,
    sensor_models::{Conversions, ModelledPair, ModelledParts, Periods, WireMeter},
    sensors::Trigger,
};
use semihosting::{
    eprintln,
    fs::File,
    io::{Read, Write},
    println, process,
};

/// Depth of the FIFO that is modelled: the same as on the host.
const WORDS: usize = 16;
/// Bytes that are read and written at once; nothing that is encoded takes more than 64.
const CHUNK: usize = 1024;
const LONGEST: usize = 64;
const COUNTER: u32 = (1 << 24) - 1;

/// Why the run ended early.
#[derive(Debug)]
enum Fault {
    NoPeripherals,
    Truth,
    Malformed,
    Samples,
}

#[entry]
fn main() -> ! {
    match run() {
        Ok(()) => process::exit(0),
        Err(fault) => {
            eprintln!("sensor-bus: {fault:?}");
            process::exit(1)
        }
    }
}

/// SysTick counts down.
fn count() -> u32 {
    COUNTER - SYST::get_current()
}

fn run() -> Result<(), Fault> {
    let mut timer = cortex_m::Peripherals::take().ok_or(Fault::NoPeripherals)?.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(COUNTER);
    timer.clear_current();
    timer.enable_counter();

    let mut truths = File::open(c"truth.bin").map_err(|_| Fault::Truth)?;
    let mut samples = File::create(c"samples.bin").map_err(|_| Fault::Samples)?;
    let mut input = Input { bytes: [0; CHUNK + LONGEST], start: 0, end: 0, at_end: false };
    let periods: (u32, u32) = input.next(&mut truths)?.ok_or(Fault::Malformed)?;
    let periods = Periods { inertial_us: Some(periods.0), magnetic_us: Some(periods.1) };

    let parts = ModelledParts::<WORDS>::new(Conversions::WithEverySample);
    parts.meter.set(Some(WireMeter { count, spent: 0 }));
    let mut pair = ModelledPair::new(&parts, periods, 1, Trigger::Interrupt);
    let mut out = Vec::<Sample, 16>::new();
    let mut encoded = Vec::<u8, CHUNK>::new();
    let (mut calls, mut ticks, mut most) = (0_u32, 0_u64, 0_u32);
    while let Some(truth) = input.next::<Sample>(&mut truths)? {
        pair.pass_to(&truth);
        out.clear();
        let began = count();
        service(&mut pair, &mut out);
        let took = count().wrapping_sub(began) & COUNTER;
        (calls, ticks) = (calls + 1, ticks + u64::from(took));
        most = if took > most { took } else { most };
        for sample in &out {
            if encoded.len() + LONGEST > CHUNK {
                samples.write_all(&encoded).map_err(|_| Fault::Samples)?;
                encoded.clear();
            }
            let mut bytes = [0; LONGEST];
            let bytes = postcard::to_slice(sample, &mut bytes).map_err(|_| Fault::Samples)?;
            encoded.extend_from_slice(bytes).map_err(|_| Fault::Samples)?;
        }
    }
    samples.write_all(&encoded).map_err(|_| Fault::Samples)?;
    let wires = parts.meter.get().map_or(0, |meter| meter.spent);
    println!("truths {calls} ticks {ticks} most {most} wires {wires}");
    Ok(())
}

/// A function of its own, so that what is measured is the call.
#[inline(never)]
fn service(pair: &mut ModelledPair<'_, WORDS>, out: &mut Vec<Sample, 16>) {
    pair.service(out);
}

struct Input {
    bytes: [u8; CHUNK + LONGEST],
    start: usize,
    end: usize,
    at_end: bool,
}

impl Input {
    fn next<T: serde::de::DeserializeOwned>(&mut self, file: &mut File) -> Result<Option<T>, Fault> {
        while self.end - self.start < LONGEST && !self.at_end {
            self.bytes.copy_within(self.start..self.end, 0);
            (self.end, self.start) = (self.end - self.start, 0);
            let room = self.bytes.get_mut(self.end..self.end + CHUNK).unwrap_or_default();
            let read = file.read(room).map_err(|_| Fault::Truth)?;
            self.at_end = read == 0;
            self.end += read;
        }
        let bytes = self.bytes.get(self.start..self.end).unwrap_or_default();
        if bytes.is_empty() {
            return Ok(None);
        }
        let (item, rest) = postcard::take_from_bytes(bytes).map_err(|_| Fault::Malformed)?;
        self.start = self.end - rest.len();
        Ok(Some(item))
    }
}
