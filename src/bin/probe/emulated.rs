//! The emulated STM32F405 in real time. SysTick is the sample clock: with each tick the register models of the
//! sensors are played a recording's next sample and the adapters read the models; frames go out and commands come in
//! through USART1. The emulator's clock advances with executed instructions and jumps ahead while the chip sleeps, so
//! a run is the same every time and an hour of it takes about as long as its work.
//!
//! With the feature `board-updatable` it is the MPS2 that is emulated: a loader starts one of two images of the
//! program.
//!
//! Files, in the emulator's working directory: `boot.bin` and `sensors.bin` in; `flash.bin` and `factory.bin` are the
//! flash. When the sensors' file is over the program prints what it has counted, a `key = value` a line, and ends.

#[cfg(feature = "board-updatable")]
mod apb_watchdog;
mod boot;
mod flash;
#[cfg(feature = "board-updatable")]
mod images;
mod log;
mod sensors;
mod serial;
mod watchdog;

use crate::{
    console::{
        self,
        Word::{Number, Text},
        complain,
    },
    reset_record,
    sample_clock::{self, COUNTS, systick},
    stack,
};
use boot::{Boot, Hang};
use core::mem::MaybeUninit;
use cortex_m::{Peripherals, peripheral::SCB};
use cortex_m_rt::{entry, exception};
use flash::{FACTORY, FileFlash, MODELS};
#[cfg(feature = "board-updatable")]
use images::Images;
use meerkat_mwd::{
    Probe,
    application::{
        Acquired, Acquisition, AcquisitionCounts, Application, Board, Burst, Commands, Line, Memory, SampleConsumer,
        SampleQueue, Stage, Statics, factory_records, provision,
    },
    emulation::Recording,
    storage::FactoryRecord,
    survey::Surveyor,
    telemetry::{CommandRefusal, ProbeId, ResetReason},
};
#[cfg(feature = "board-updatable")]
use meerkat_mwd::{
    application::{ProgramUpdate, Updater},
    storage::ImageSlots,
};
use semihosting::process;
use sensors::Modelled;
use serial::Serial;

// In the core-coupled memory, below the stack. Uninitialised: a value that is not all zero would stand in flash, too.
#[allow(unsafe_code)]
#[unsafe(link_section = ".ccm.surveyor")]
static mut SURVEYOR: MaybeUninit<Surveyor> = MaybeUninit::uninit();
#[allow(unsafe_code)]
#[unsafe(link_section = ".ccm.memory")]
static mut MEMORY: MaybeUninit<Memory<FileFlash>> = MaybeUninit::uninit();

#[entry]
fn main() -> ! {
    // `entry` hands these out as `&'static mut`, once: it lets nobody call `main`.
    static mut PROBE: Probe = Probe::new();
    static mut BURST: Burst = Burst::new();
    static mut LINE: Line = Line::new();
    static mut COMMANDS: Commands = Commands::new();
    static mut QUEUE: SampleQueue = SampleQueue::new();
    static mut MODELLED: Modelled = Modelled::new();
    // SAFETY: nothing else names them, and `entry` lets nobody call `main` again.
    #[allow(unsafe_code, clippy::deref_addrof)] // A reference to a `static mut` goes by way of its address.
    let (surveyor, memory) = unsafe { (&mut *&raw mut SURVEYOR, &mut *&raw mut MEMORY) };

    let statics = Statics {
        probe: PROBE,
        surveyor: surveyor.write(Surveyor::new()),
        burst: BURST,
        line: LINE,
        commands: COMMANDS,
        memory: None,
    };
    match run(statics, memory, (QUEUE, MODELLED)) {
        Ok(()) => process::exit(0),
        Err(message) => {
            complain(&[Text(message)]);
            process::exit(1)
        }
    }
}

fn run(
    statics: Statics<'static, FileFlash>,
    memory: &'static mut MaybeUninit<Memory<FileFlash>>,
    (queue, modelled): (&'static mut SampleQueue, &'static mut Modelled),
) -> Result<(), &'static str> {
    let peripherals = Peripherals::take().ok_or("started twice")?;
    stack::guard(&peripherals.MPU);
    let reset_reason = match (reset_record::start(false), reset_record::resets()) {
        (Some(cause), _) => cause,
        (None, 0) => ResetReason::PowerOn,
        (None, _) => ResetReason::Software,
    };
    let (producer, consumer) = queue.split();
    let (mut application, recording) = start(statics, memory, consumer, reset_reason)?;
    sensors::start(modelled, Acquisition::new(producer, &COUNTS), recording, application.board().hang)?;
    watchdog::start(recording.inertial_us);
    systick::start(peripherals.SYST, peripherals.SCB, recording.inertial_us);
    while !(sensors::are_over() && application.board().samples.is_empty()) {
        application.turn();
    }
    print(&mut application);
    Ok(())
}

/// A function of its own, so that the configuration stands on the stack only while it is read.
#[inline(never)]
fn start(
    mut statics: Statics<'static, FileFlash>,
    memory: &'static mut MaybeUninit<Memory<FileFlash>>,
    samples: SampleConsumer<'static>,
    reset_reason: ResetReason,
) -> Result<(Application<'static, Emulated>, Recording), &'static str> {
    let mut boot = Boot::read()?;
    let mut factory = FileFlash::open(FACTORY, boot.power_cut_after);
    if let Some(region) = &mut factory {
        boot.provisioned(&factory_records(region));
    }
    let serial = Serial::start(boot.settings.stream.bytes_per_s);
    // A hang is simulated once, after power-up.
    let hang = if reset_reason == ResetReason::PowerOn { boot.hang } else { None };
    let board = Emulated {
        samples,
        serial,
        reset_reason,
        hang,
        acquired: 0,
        factory,
        #[cfg(feature = "board-updatable")]
        updater: updater(),
    };
    if let Some(flash) = FileFlash::open(MODELS, boot.power_cut_after) {
        statics.memory = Memory::start(memory, flash, &boot.settings.config, watchdog::feed).ok();
    }
    let application = Application::start(board, statics, &boot.settings).map_err(|error| {
        complain(&[Text(error.field), Text(" must be "), Text(error.must_be)]);
        "the configuration cannot be used"
    })?;
    Ok((application, boot.sensors))
}

/// Receiver of another image; `None`: nobody has loaded this one.
#[cfg(feature = "board-updatable")]
#[inline(never)]
fn updater() -> Option<Updater<Images>> {
    let running = images::running()?;
    Some(Updater::new(ImageSlots::new(Images::open()?).ok()?, running))
}

struct Emulated {
    samples: SampleConsumer<'static>,
    serial: Serial,
    reset_reason: ResetReason,
    hang: Option<Hang>,
    acquired: u32,
    /// Factory's region; `None`: there is none, and the probe starts with the settings of `boot.bin`.
    factory: Option<FileFlash>,
    #[cfg(feature = "board-updatable")]
    updater: Option<Updater<Images>>,
}

impl Board for Emulated {
    type Flash = FileFlash;

    fn now_us(&self) -> u64 {
        systick::now_us()
    }

    fn sample(&mut self) -> Option<Acquired> {
        self.samples.dequeue()
    }

    fn acquisition(&self) -> &AcquisitionCounts {
        &COUNTS
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        self.serial.send(bytes, systick::now_us())
    }

    fn receive(&mut self) -> Option<u8> {
        self.serial.receive()
    }

    fn feed_watchdog(&mut self) {
        watchdog::feed();
    }

    fn idle(&mut self) {
        if self.serial.take_activity() {
            return;
        }
        // With interrupts masked, one that comes between the check and the sleep still wakes the core.
        cortex_m::interrupt::free(|_| {
            if self.samples.is_empty() && !sensors::are_over() {
                cortex_m::asm::wfi();
            }
        });
    }

    fn reset_reason(&self) -> ResetReason {
        self.reset_reason
    }

    fn watchdog_resets(&self) -> u32 {
        reset_record::watchdog_resets()
    }

    fn identity(&self) -> ProbeId {
        // The emulated chip has no unique number; a host that tests it knows this one.
        ProbeId(*b"emulated 405")
    }

    fn stack_bytes(&self) -> [u32; 2] {
        stack::high_water_mark()
    }

    fn provision(&mut self, record: &FactoryRecord, only_check: bool) -> Result<(), CommandRefusal> {
        provision(self.factory.as_mut().ok_or(CommandRefusal::NotSupported)?, record, only_check)
    }

    #[cfg(feature = "board-updatable")]
    fn program_update(&mut self) -> Option<&mut dyn ProgramUpdate> {
        self.updater.as_mut().map(|updater| updater as &mut dyn ProgramUpdate)
    }

    #[cfg(feature = "board-updatable")]
    fn restart(&mut self) {
        SCB::sys_reset()
    }

    fn enter(&mut self, stage: Stage) {
        self.acquired = COUNTS.acquired();
        if self.hang.is_some_and(|hang| hang.stage == stage && self.acquired >= hang.at_sample) {
            loop {
                cortex_m::asm::nop();
            }
        }
    }
}

#[inline(never)]
fn print(application: &mut Application<'_, Emulated>) {
    let counts = application.counts();
    let line = application.statics().line.counters();
    let counters = application.statics().probe.counters();
    let [stack_used_bytes, stack_size_bytes] = stack::high_water_mark();
    let mut values = [
        ("watchdog_resets", reset_record::watchdog_resets()),
        ("results_lost", application.statics().line.results_lost()),
        ("frames", line.frames),
        ("attitude_dropped", line.attitude_dropped),
        ("samples_dropped", line.samples_dropped),
        ("results_refused", line.results_refused),
        ("acquired", COUNTS.acquired()),
        ("queue_full", COUNTS.queue_full()),
        ("missed_ticks", COUNTS.missed_ticks()),
        ("processed", counts.processed),
        ("sequence_breaks", counts.sequence_breaks),
        ("windows", counts.windows),
        ("diagnoses", counts.diagnoses),
        ("watchdog_fed", counts.watchdog_fed),
        ("delay_worst_us", counts.delays.worst_us),
        ("late", counts.delays.late),
        ("samples", u32::try_from(counters.samples).unwrap_or(u32::MAX)),
        ("out_of_order", counters.out_of_order),
        ("gaps", counters.gaps),
        ("overruns", counters.overruns),
        ("reports_lost", counters.reports_lost),
        ("diagnoses_lost", counters.diagnoses_lost),
        ("stack_used_bytes", stack_used_bytes),
        ("stack_size_bytes", stack_size_bytes),
        ("models_stored", 0),
        ("storage_failures", 0),
    ];
    if let (Some(memory), [.., stored, failures]) = (&application.statics().memory, &mut values) {
        [stored.1, failures.1] = memory.stored_and_failed();
    }
    for (name, value) in values {
        console::print(&[Text(name), Text(" = "), Number(value.into())]);
    }
}

#[exception]
fn SysTick() {
    sample_clock::round();
    reset_record::count_powered_round();
    watchdog::count_down();
    SCB::set_pendsv();
}
