//! The emulated STM32F405 without a clock: `trace.bin` of the emulator's working directory in, `flight.bin` out, both
//! through semihosting, as fast as it goes and every call's instructions counted.
//!
//! In: postcard's encoding of a `Config`, of an `Option<u64>` (the instant from which nothing new takes effect), of an
//! `Option<Recording>`, then of one `Sample` after another to the end of the file. Out: `Record`s. With a `Recording`
//! the samples are the truth of register models of the sensors, and what flies is what the adapters read from these.

mod fault;
mod instruction_counter;
mod record_writer;
mod sensors;
mod trace_reader;

use crate::stack;
use core::mem::MaybeUninit;
use cortex_m_rt::entry;
use fault::Fault;
use instruction_counter::{InstructionCounter, Tally};
use meerkat_mwd::{
    Config, Probe, Sample,
    emulation::{Record, Summary},
    identification::WindowReport,
    magnet::HardIronInterval,
    probe::Output,
};
use record_writer::RecordWriter;
use semihosting::process;
use sensors::Sensors;
use trace_reader::TraceReader;

#[entry]
fn main() -> ! {
    // `entry` hands these out as `&'static mut`, once: it lets nobody call `main`.
    static mut PROBE: Probe = Probe::new();
    static mut INPUT: [u8; trace_reader::CAPACITY] = [0; trace_reader::CAPACITY];
    static mut OUTPUT: [u8; record_writer::CAPACITY] = [0; record_writer::CAPACITY];
    static mut PARTS: sensors::Parts = MaybeUninit::uninit();
    static mut PLAYER: sensors::Player = MaybeUninit::uninit();

    match fly(PROBE, INPUT, OUTPUT, (PARTS, PLAYER)) {
        Ok(()) => process::exit(0),
        Err(fault) => {
            fault.complain();
            process::exit(1)
        }
    }
}

fn fly(
    probe: &mut Probe,
    input: &'static mut [u8; trace_reader::CAPACITY],
    output: &'static mut [u8; record_writer::CAPACITY],
    (parts, player): (&'static mut sensors::Parts, &'static mut sensors::Player),
) -> Result<(), Fault> {
    let peripherals = cortex_m::Peripherals::take().ok_or(Fault::InstructionCounter)?;
    stack::guard(&peripherals.MPU);
    let counter = InstructionCounter::start(peripherals.SYST)?;
    let mut trace = TraceReader::open(c"trace.bin", input)?;
    let mut flight = RecordWriter::create(c"flight.bin", output)?;

    configure(probe, &mut trace)?;
    let recording = trace.next()?.ok_or(Fault::TraceMalformed)?;
    let mut sensors = Sensors::new(recording, parts, player);

    let mut push = Tally::default();
    let mut poll = Tally::default();
    let mut poll_before_window = Tally::default();
    while let Some(sample) = sensors.next(&mut trace, &counter)? {
        let (output, ticks) = counter.measure(|| push_sample(probe, &sample));
        push.add(ticks);
        if let Some(output) = output {
            write_output(&mut flight, output)?;
        }
        let (report, ticks) = counter.measure(|| poll_probe(probe));
        poll.add(ticks);
        if let Some(report) = report {
            let poll_instructions = counter.instructions(poll.since(&poll_before_window));
            poll_before_window = poll;
            write_window(&mut flight, &report, poll_instructions)?;
        }
        write_diagnosis(probe, &mut flight)?;
    }
    // Reports that came faster than one a sample.
    while let Some(report) = probe.poll(0) {
        write_window(&mut flight, &report, 0)?;
    }

    write_diagnosis(probe, &mut flight)?;

    for interval in probe.hard_iron_intervals() {
        write_hard_iron(&mut flight, interval)?;
    }
    write_end(probe, &mut flight, &counter, (&push, &poll))?;
    sensors.print(&counter);
    flight.close()
}

// Functions of their own, so that a record stands on the stack only while it is written.

#[inline(never)]
fn configure(probe: &mut Probe, trace: &mut TraceReader) -> Result<(), Fault> {
    let config: Config = trace.next()?.ok_or(Fault::TraceMalformed)?;
    probe.configure(&config).map_err(Fault::Config)?;
    if let Some(at_us) = trace.next::<Option<u64>>()?.ok_or(Fault::TraceMalformed)? {
        probe.freeze(at_us);
    }
    Ok(())
}

#[inline(never)]
fn write_end(
    probe: &Probe,
    flight: &mut RecordWriter,
    counter: &InstructionCounter,
    (push, poll): (&Tally, &Tally),
) -> Result<(), Fault> {
    let [stack_used_bytes, stack_size_bytes] = stack::high_water_mark();
    if stack_used_bytes >= stack_size_bytes {
        return Err(Fault::StackOverflow);
    }
    flight.write(&Record::End(Summary {
        counters: probe.counters(),
        push: counter.cost(push),
        poll: counter.cost(poll),
        ticks_per_1000_instructions: counter.ticks_per_1000_instructions(),
        stack_used_bytes,
        stack_size_bytes,
    }))
}

#[inline(never)]
fn write_hard_iron(flight: &mut RecordWriter, interval: &HardIronInterval) -> Result<(), Fault> {
    flight.write(&Record::HardIron(*interval))
}

#[inline(never)]
fn write_output(flight: &mut RecordWriter, output: Output) -> Result<(), Fault> {
    flight.write(&Record::Output(output))
}

#[inline(never)]
fn write_window(flight: &mut RecordWriter, report: &WindowReport, poll_instructions: u64) -> Result<(), Fault> {
    flight.write(&Record::Window { report: *report, poll_instructions })
}

#[inline(never)]
fn write_diagnosis(probe: &mut Probe, flight: &mut RecordWriter) -> Result<(), Fault> {
    match probe.take_diagnosis() {
        Some(report) => flight.write(&Record::Diagnosis(report)),
        None => Ok(()),
    }
}

// Functions of their own, so that what is measured is the call that a program makes and not a part merged into the
// loop.

#[inline(never)]
fn push_sample(probe: &mut Probe, sample: &Sample) -> Option<Output> {
    probe.push(sample)
}

#[inline(never)]
fn poll_probe(probe: &mut Probe) -> Option<WindowReport> {
    probe.poll(probe.poll_budget())
}
