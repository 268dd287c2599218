//! Common part of the boards with sensors: the parts are read in PendSV, the line's bytes go through queues.

#[cfg(feature = "board-nrf52840")]
use crate::nrf52840::chip;
#[cfg(feature = "board-stm32f405")]
use crate::stm32f405::chip;
use crate::{
    reset_record,
    sample_clock::{self, COUNTS},
    serial_queues::SerialQueues,
    stack,
};
use core::{cell::Cell, mem::MaybeUninit};
use cortex_m_rt::exception;
use critical_section::Mutex;
use meerkat_mwd::{
    application::{Acquired, Acquisition, AcquisitionCounts, Board, Interrupts, SampleConsumer, Sensors, provision},
    storage::FactoryRecord,
    telemetry::{CommandRefusal, ProbeId, ResetReason},
};

pub type BoardSensors = Sensors<'static, chip::Inertial, chip::Magnetic>;

/// Sensors on their way from `main` to the interrupt.
static SENSORS: Mutex<Cell<Option<&'static mut BoardSensors>>> = Mutex::new(Cell::new(None));

/// Hands the sensors to the interrupt. Call it before the sample clock starts.
pub fn start_sensors(
    place: &'static mut MaybeUninit<BoardSensors>,
    (inertial, magnetic): (chip::Inertial, chip::Magnetic),
    acquisition: Acquisition<'static>,
) {
    let sensors = place.write(Sensors::new(inertial, magnetic, acquisition));
    critical_section::with(|cs| SENSORS.borrow(cs).set(Some(sensors)));
}

#[exception]
fn PendSV() {
    static mut MINE: Option<&'static mut BoardSensors> = None;
    if MINE.is_none() {
        *MINE = critical_section::with(|cs| SENSORS.borrow(cs).take());
    }
    if let Some(sensors) = MINE {
        sensors.read(sample_clock::rounds(), chip::now_us(), Interrupts::default());
    }
}

pub struct SensorBoard {
    pub samples: SampleConsumer<'static>,
    pub serial: SerialQueues,
    pub watchdog: chip::Watchdog,
    pub reset_reason: ResetReason,
    pub identity: ProbeId,
    pub factory: chip::FactoryFlash,
}

impl Board for SensorBoard {
    type Flash = chip::ModelFlash;

    fn now_us(&self) -> u64 {
        chip::now_us()
    }

    fn clock_hz(&self) -> u32 {
        if cfg!(feature = "board-nrf52840") { 64_000_000 } else { 168_000_000 }
    }

    fn sample(&mut self) -> Option<Acquired> {
        self.samples.dequeue()
    }

    fn acquisition(&self) -> &AcquisitionCounts {
        &COUNTS
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        let sent = self.serial.send(bytes);
        chip::wake();
        sent
    }

    fn receive(&mut self) -> Option<u8> {
        self.serial.receive()
    }

    fn feed_watchdog(&mut self) {
        chip::feed(&mut self.watchdog);
    }

    fn idle(&mut self) {
        // With interrupts masked, one that comes between the check and the sleep still wakes the core.
        cortex_m::interrupt::free(|_| {
            if self.samples.is_empty() {
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
        self.identity
    }

    fn provision(&mut self, record: &FactoryRecord, only_check: bool) -> Result<(), CommandRefusal> {
        provision(&mut self.factory, record, only_check)
    }

    fn stack_bytes(&self) -> [u32; 2] {
        stack::high_water_mark()
    }
}
