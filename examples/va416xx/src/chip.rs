//! The chip's side: clocks, buses, sensors, and the loop.

use core::{
    convert::Infallible,
    sync::atomic::{AtomicU32, Ordering},
};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::{entry, exception};
use embedded_hal::{digital::PinState, spi::MODE_3};
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use heapless::Vec;
use meerkat_mwd::{
    Config,
    probe::AttitudeProbe,
    sensors::{
        BURST_FRAMES, Combiner, InertialReading, MagneticReading, Mounting, Rm3100Settings, Trigger,
        blocking::{InertialSource, Ism330dhcx, MagneticSource, Rm3100, Supervised},
    },
    survey::{SurveyNews, Surveys},
};
use static_cell::{ConstStaticCell, StaticCell};
use va416xx_hal::{
    gpio::Output,
    pac::Peripherals,
    pins::{PinsB, PinsC},
    prelude::*,
    spi::{Spi, SpiClockConfig, SpiConfig},
    time::Hertz,
    wdt::{Wdt, disable_wdt_interrupts},
};

/// Clock that a generator gives on XTAL_N, Hz.
const CLOCK_HZ: u32 = 40_000_000;
/// Time without a feed until the watchdog resets, milliseconds.
const WATCHDOG_MS: u32 = 1_000;

static PROBE: ConstStaticCell<AttitudeProbe> = ConstStaticCell::new(AttitudeProbe::new());
/// Written at the start: as a constant it would take its size in flash, too.
static SURVEYS: StaticCell<Surveys> = StaticCell::new();
/// Rounds of the sample clock.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

/// Sensors, and what flies their readings.
struct Loop<I, M> {
    inertial: I,
    magnetic: M,
    combiner: Combiner,
    probe: &'static mut AttitudeProbe,
    surveys: &'static mut Surveys,
}

impl<I: InertialSource, M: MagneticSource> Loop<I, M> {
    /// Reads what the sensors have, and flies it. A part that fails is started anew by its source. Returns what is new:
    /// `surveys` holds it, for a line of one's own.
    fn turn(&mut self, now_us: u64) -> SurveyNews {
        let mut fields = Vec::<MagneticReading, BURST_FRAMES>::new();
        let _ = self.magnetic.read(now_us, Trigger::Polled, &mut fields);
        fields.into_iter().for_each(|reading| self.combiner.magnetic(reading));
        let mut readings = Vec::<InertialReading, BURST_FRAMES>::new();
        let _ = self.inertial.read(now_us, Trigger::Polled, &mut readings);
        let mut news = SurveyNews::empty();
        for sample in readings.iter().filter_map(|reading| self.combiner.inertial(reading)) {
            if let Some(output) = self.probe.push(&sample) {
                news |= self.surveys.push(&self.probe.survey_input(&sample, &output));
            }
        }
        news
    }
}

#[entry]
fn main() -> ! {
    let (Some(chip), Some(core)) = (Peripherals::take(), cortex_m::Peripherals::take()) else { stop() };
    let clock = chip.clkgen.constrain().xtal_n_clk_with_src_freq(Hertz::from_raw(CLOCK_HZ));
    let Ok(clocks) = clock.freeze() else { stop() };
    // The counter resets the chip when it runs out for the second time without a feed. The first time it raises an
    // interrupt, which the HAL enables: it has no handler, and a feed in the second half is in time.
    let mut watchdog = Wdt::start(chip.watch_dog, &clocks, WATCHDOG_MS / 2);
    disable_wdt_interrupts();
    watchdog.enable_reset();

    let (b, c) = (PinsB::new(chip.portb), PinsC::new(chip.portc));
    let settings = |hz| {
        let clock = SpiClockConfig::from_clks(&clocks, Hertz::from_raw(hz)).unwrap_or_else(|| stop());
        SpiConfig::default().mode(MODE_3).blockmode(false).bmstall(false).clk_cfg(clock)
    };
    let bus = Spi::<u8>::new_for_spi0(chip.spi0, (b.pb15, c.pc0, c.pc1), settings(10_000_000));
    let device = device(bus, Output::new(b.pb14, PinState::High));
    let inertial = Supervised::<_, 2>::new(Ism330dhcx::new_spi(device, 1), Mounting::ALIGNED);
    let bus = Spi::<u8>::new_for_spi1(chip.spi1, (c.pc9, c.pc10, c.pc11), settings(1_000_000));
    let device = self::device(bus, Output::new(c.pc8, PinState::High));
    let part = Rm3100::new_spi(device, Rm3100Settings::default());
    let magnetic = Supervised::<_, 1>::new(part, Mounting::ALIGNED);

    let period_us = inertial.data().period_us;
    let (probe, surveys) = (PROBE.take(), SURVEYS.init_with(Surveys::new));
    let config = Config { sample_period_us: period_us, ..Config::default() };
    if probe.configure(&config).is_err() || surveys.configure(&config.earth, &config.survey).is_err() {
        stop();
    }
    let mut flight = Loop { inertial, magnetic, combiner: Combiner::new(period_us), probe, surveys };
    start(core.SYST, period_us);
    let mut flown = 0;
    loop {
        // With interrupts masked, one that comes between the check and the sleep still wakes the core.
        let rounds = cortex_m::interrupt::free(|_| {
            let rounds = ROUNDS.load(Ordering::Relaxed);
            if rounds == flown {
                cortex_m::asm::wfi();
            }
            rounds
        });
        if rounds == flown {
            continue;
        }
        flown = rounds;
        let _ = flight.turn(u64::from(rounds) * u64::from(period_us));
        watchdog.feed();
    }
}

fn device(bus: Spi<u8>, select: Output) -> ExclusiveDevice<Spi<u8>, Output, NoDelay> {
    let device: Result<_, Infallible> = ExclusiveDevice::new_no_delay(bus, select);
    let Ok(device) = device;
    device
}

fn start(mut timer: SYST, period_us: u32) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(period_us * (CLOCK_HZ / 1_000_000) - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

#[exception]
fn SysTick() {
    // Loads and stores: nothing else counts.
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// Waits for the watchdog.
fn stop() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    stop()
}
