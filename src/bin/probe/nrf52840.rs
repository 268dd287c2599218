//! A board with an nRF52840 and a 32 MHz crystal: an ISM330DHCX on SPIM2 (P0.13 to P0.15, select P0.16), an RM3100 on
//! SPIM1 (P0.19 to P0.21, select P0.22), the line on UART0 (P0.06, P0.08) at 921,600 baud, logs by RTT.

mod acquisition;
pub mod chip;
mod flash;
mod port;
mod timer;

use crate::{
    fault, reset_record,
    sample_clock::COUNTS,
    sensor_board::{BoardSensors, SensorBoard, start_sensors},
    serial_queues::{Incoming, Outgoing, SerialQueues},
    stack,
};
use core::mem::MaybeUninit;
use cortex_m::{Peripherals as Core, peripheral::scb::SystemHandler};
use cortex_m_rt::entry;
use flash::ModelFlash;
use meerkat_mwd::{
    Config, Probe,
    application::{
        Acquisition, Application, Board, Burst, Commands, Line, Memory, SampleQueue, Settings, Statics,
        apply_factory_records, data_sheet, factory_records,
    },
    survey::Surveyor,
    telemetry::{ProbeId, ResetReason, StreamConfig},
};
use nrf52840_hal::{
    clocks::Clocks,
    gpio::{Level, p0},
    pac::{FICR, POWER, Peripherals, WDT},
    wdt::{Watchdog, WatchdogHandle, count::One, handles::Hdl0},
};

const BYTES_PER_S: u32 = 92_160;
/// Time of the watchdog, ticks of 32,768 Hz: one second.
const WATCHDOG_TICKS: u32 = 32_768;

#[entry]
#[allow(clippy::too_many_arguments)] // `entry` turns its statics into arguments.
fn main() -> ! {
    // `entry` hands these out as `&'static mut`, once: it lets nobody call `main`.
    static mut PROBE: Probe = Probe::new();
    // Uninitialised: a surveyor is not all zero, so that a value here would stand in flash, too.
    static mut SURVEYOR: MaybeUninit<Surveyor> = MaybeUninit::uninit();
    static mut BURST: Burst = Burst::new();
    static mut LINE: Line = Line::new();
    static mut COMMANDS: Commands = Commands::new();
    static mut MEMORY: MaybeUninit<Memory<ModelFlash>> = MaybeUninit::uninit();
    static mut SAMPLES: SampleQueue = SampleQueue::new();
    static mut SENSORS: MaybeUninit<BoardSensors> = MaybeUninit::uninit();
    static mut OUTGOING: Outgoing = Outgoing::new();
    static mut INCOMING: Incoming = Incoming::new();

    let (Some(chip), Some(mut core)) = (Peripherals::take(), Core::take()) else { fault::stop("started twice") };
    stack::guard(&core.MPU);
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    // Start the watchdog before anything that may hang, such as a crystal that does not start.
    let watchdog = watchdog(chip.WDT);
    let reset_reason = reset_reason(&chip.POWER);
    // The crystal paces the sample clock.
    let _clocks = Clocks::new(chip.CLOCK).enable_ext_hfosc();

    let pins = p0::Parts::new(chip.P0);
    let wires = (
        pins.p0_13.into_push_pull_output(Level::High).degrade(),
        pins.p0_14.into_floating_input().degrade(),
        pins.p0_15.into_push_pull_output(Level::High).degrade(),
    );
    let inertial = acquisition::inertial(chip.SPIM2, wires, pins.p0_16.into_push_pull_output(Level::High).degrade());
    let wires = (
        pins.p0_19.into_push_pull_output(Level::High).degrade(),
        pins.p0_20.into_floating_input().degrade(),
        pins.p0_21.into_push_pull_output(Level::High).degrade(),
    );
    let magnetic = acquisition::magnetic(chip.SPIM1, wires, pins.p0_22.into_push_pull_output(Level::High).degrade());
    let (outgoing, to_port) = OUTGOING.split();
    let (from_port, incoming) = INCOMING.split();
    let wires = (pins.p0_06.into_push_pull_output(Level::High).degrade(), pins.p0_08.into_floating_input().degrade());
    port::start(chip.UART0, wires, to_port, from_port);

    let (sample_period_us, full_scale, latency) = data_sheet(&inertial, &magnetic);
    // Without its cache the flash makes the core wait at most fetches (product specification, NVMC, ICACHECNF).
    chip.NVMC.icachecnf.write(|w| w.cacheen().enabled());
    let (models, mut region) = flash::split(chip.NVMC);
    let factory = factory_records(&mut region);
    let mut config = Config { sample_period_us, full_scale, latency, ..Config::default() };
    apply_factory_records(&factory, &mut config);
    let settings = Settings {
        config,
        stream: StreamConfig { bytes_per_s: BYTES_PER_S, ..StreamConfig::default() },
        recording: false,
        key: factory.key,
    };
    let (producer, samples) = SAMPLES.split();
    let identity = identity(&chip.FICR);
    let serial = SerialQueues { outgoing, incoming };
    let mut board = SensorBoard { samples, serial, watchdog, reset_reason, identity, factory: region };
    let memory = Memory::start(MEMORY, models, &settings.config, || board.feed_watchdog()).ok();
    let statics = Statics {
        probe: PROBE,
        surveyor: SURVEYOR.write(Surveyor::new()),
        burst: BURST,
        line: LINE,
        commands: COMMANDS,
        memory,
    };
    let Ok(mut application) = Application::start(board, statics, &settings) else {
        fault::stop("the configuration cannot be used")
    };
    start_sensors(SENSORS, (inertial, magnetic), Acquisition::new(producer, &COUNTS));
    // SAFETY: no critical section of this program rests on priorities, only on masking all interrupts.
    #[allow(unsafe_code)]
    unsafe {
        core.SCB.set_priority(SystemHandler::PendSV, 0xf0);
    }
    timer::start(chip.TIMER0, sample_period_us);
    loop {
        application.turn();
    }
}

/// The device's identifier and the first word of its address, both drawn at random by the factory (product
/// specification, FICR).
fn identity(ficr: &FICR) -> ProbeId {
    let (id, address) = (&ficr.deviceid, &ficr.deviceaddr);
    ProbeId::of_words([id[0].read().bits(), id[1].read().bits(), address[0].read().bits()])
}

/// Starts the watchdog, or takes over one that a reset by software left running.
fn watchdog(wdt: WDT) -> WatchdogHandle<Hdl0> {
    match Watchdog::try_new(wdt) {
        Ok(mut watchdog) => {
            watchdog.set_lfosc_ticks(WATCHDOG_TICKS);
            watchdog.run_during_debug_halt(false);
            watchdog.activate::<One>().handles.0
        }
        Err(wdt) => match Watchdog::try_recover::<One>(wdt) {
            Ok(parts) => parts.handles.0,
            Err(_) => fault::stop("the watchdog runs with another program's settings"),
        },
    }
}

/// Reads and clears RESETREAS (product specification, POWER). No bit set means that power came.
fn reset_reason(power: &POWER) -> ResetReason {
    let flags = power.resetreas.read();
    let asked = reset_record::start(flags.bits() == 0);
    // Writing a one clears a bit.
    power.resetreas.write(|w| {
        w.resetpin().set_bit();
        w.dog().set_bit();
        w.sreq().set_bit();
        w.lockup().set_bit()
    });
    if flags.dog().bit() {
        reset_record::count_watchdog_reset();
        ResetReason::Watchdog
    } else if flags.lockup().bit() {
        ResetReason::Fault
    } else if flags.sreq().bit() {
        asked.unwrap_or(ResetReason::Software)
    } else if flags.resetpin().bit() {
        ResetReason::Pin
    } else {
        ResetReason::PowerOn
    }
}
