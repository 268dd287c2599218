//! A board with an STM32F405 and an 8 MHz crystal: an ISM330DHCX on SPI1 (PA5 to PA7, select PA4), an RM3100 on SPI2
//! (PB13 to PB15, select PB12), the line on USART1 (PA9, PA10) at 921,600 baud, logs by RTT.

mod acquisition;
pub mod chip;
mod flash;
mod flash_registers;
mod port;
mod watchdog_time;

use crate::{
    fault, reset_record,
    sample_clock::{self, COUNTS, systick},
    sensor_board::{BoardSensors, SensorBoard, start_sensors},
    serial_queues::{Incoming, Outgoing, SerialQueues},
    stack,
};
use core::mem::MaybeUninit;
use cortex_m::{Peripherals as Core, peripheral::SCB};
use cortex_m_rt::{entry, exception};
use flash_registers::ModelFlash;
use meerkat_mwd::{
    Config, Probe,
    application::{
        Acquisition, Application, Board, Burst, Commands, Line, Memory, SampleQueue, Settings, Statics,
        apply_factory_records, data_sheet, factory_records,
    },
    survey::Surveyor,
    telemetry::{ProbeId, ResetReason, StreamConfig},
};
use stm32f4xx_hal::{
    pac::{Peripherals, RCC},
    prelude::*,
    rcc,
    serial::Config as SerialConfig,
    watchdog::IndependentWatchdog,
};
use watchdog_time::WATCHDOG_MS;

const BAUD: u32 = 921_600;
/// The unique device number (RM0090, section 39.1).
const UNIQUE_NUMBER: *const [u32; 3] = 0x1fff_7a10 as *const [u32; 3];

// In the core-coupled memory, below the stack. Uninitialised: a value that is not all zero would stand in flash, too.
#[allow(unsafe_code)]
#[unsafe(link_section = ".ccm.surveyor")]
static mut SURVEYOR: MaybeUninit<Surveyor> = MaybeUninit::uninit();
#[allow(unsafe_code)]
#[unsafe(link_section = ".ccm.memory")]
static mut MEMORY: MaybeUninit<Memory<ModelFlash>> = MaybeUninit::uninit();
#[allow(unsafe_code)]
#[unsafe(link_section = ".ccm.sensors")]
static mut SENSORS: MaybeUninit<BoardSensors> = MaybeUninit::uninit();

#[entry]
#[allow(clippy::too_many_arguments)] // `entry` turns its statics into arguments.
fn main() -> ! {
    // `entry` hands these out as `&'static mut`, once: it lets nobody call `main`.
    static mut PROBE: Probe = Probe::new();
    static mut BURST: Burst = Burst::new();
    static mut LINE: Line = Line::new();
    static mut COMMANDS: Commands = Commands::new();
    static mut SAMPLES: SampleQueue = SampleQueue::new();
    static mut OUTGOING: Outgoing = Outgoing::new();
    static mut INCOMING: Incoming = Incoming::new();
    // SAFETY: nothing else names them, and `entry` lets nobody call `main` again.
    #[allow(unsafe_code, clippy::deref_addrof)] // A reference to a `static mut` goes by way of its address.
    let (surveyor, memory, sensors) =
        unsafe { (&mut *&raw mut SURVEYOR, &mut *&raw mut MEMORY, &mut *&raw mut SENSORS) };

    let (Some(chip), Some(mut core)) = (Peripherals::take(), Core::take()) else { fault::stop("started twice") };
    stack::guard(&core.MPU);
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    // Start the watchdog before anything that may hang, such as a crystal that does not start.
    let mut watchdog = IndependentWatchdog::new(chip.IWDG);
    watchdog.start(WATCHDOG_MS.millis());
    let reset_reason = reset_reason(&chip.RCC);

    let mut rcc = chip.RCC.freeze(rcc::Config::hse(8.MHz()).sysclk(168.MHz()));
    let (a, b) = (chip.GPIOA.split(&mut rcc), chip.GPIOB.split(&mut rcc));
    let inertial = acquisition::inertial(chip.SPI1, (a.pa5, a.pa6, a.pa7), a.pa4, &mut rcc);
    let magnetic = acquisition::magnetic(chip.SPI2, (b.pb13, b.pb14, b.pb15), b.pb12, &mut rcc);
    let line = chip.USART1.serial((a.pa9, a.pa10), SerialConfig::default().baudrate(BAUD.bps()), &mut rcc);
    let Ok(line) = line else { fault::stop("921,600 baud cannot be had from this clock") };
    let (outgoing, to_port) = OUTGOING.split();
    let (from_port, incoming) = INCOMING.split();
    port::start(line, to_port, from_port);

    let (sample_period_us, full_scale, latency) = data_sheet(&inertial, &magnetic);
    let models = flash::ModelFlash(chip.FLASH);
    let mut region = flash::FactoryFlash(flash_registers::again());
    let factory = factory_records(&mut region);
    let mut config = Config { sample_period_us, full_scale, latency, ..Config::default() };
    apply_factory_records(&factory, &mut config);
    let settings = Settings {
        config,
        stream: StreamConfig { bytes_per_s: BAUD / 10, ..StreamConfig::default() },
        recording: false,
        key: factory.key,
    };
    let (producer, samples) = SAMPLES.split();
    let serial = SerialQueues { outgoing, incoming };
    let mut board = SensorBoard { samples, serial, watchdog, reset_reason, identity: identity(), factory: region };
    let memory = Memory::start(memory, models, &settings.config, || board.feed_watchdog()).ok();
    let statics = Statics {
        probe: PROBE,
        surveyor: surveyor.write(Surveyor::new()),
        burst: BURST,
        line: LINE,
        commands: COMMANDS,
        memory,
    };
    let Ok(mut application) = Application::start(board, statics, &settings) else {
        fault::stop("the configuration cannot be used")
    };
    start_sensors(sensors, (inertial, magnetic), Acquisition::new(producer, &COUNTS));
    systick::start(core.SYST, core.SCB, sample_period_us);
    loop {
        application.turn();
    }
}

fn identity() -> ProbeId {
    // SAFETY: three aligned words of the chip's own memory, which is always readable.
    #[allow(unsafe_code)]
    ProbeId::of_words(unsafe { UNIQUE_NUMBER.read_volatile() })
}

/// Reads and clears the reset flags (RM0090 section 7.3.21). Every reset sets the pin's flag, so that it is judged
/// last.
fn reset_reason(rcc: &RCC) -> ResetReason {
    let flags = rcc.csr().read();
    let asked = reset_record::start(flags.porrstf().bit() || flags.borrstf().bit());
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    if flags.wdgrstf().bit() || flags.wwdgrstf().bit() {
        reset_record::count_watchdog_reset();
        ResetReason::Watchdog
    } else if let Some(asked) = asked.filter(|_| flags.sftrstf().bit()) {
        asked
    } else if flags.sftrstf().bit() {
        ResetReason::Software
    } else if flags.porrstf().bit() {
        ResetReason::PowerOn
    } else if flags.borrstf().bit() {
        ResetReason::BrownOut
    } else if flags.padrstf().bit() {
        ResetReason::Pin
    } else {
        ResetReason::Unknown
    }
}

#[exception]
fn SysTick() {
    sample_clock::round();
    SCB::set_pendsv();
}
