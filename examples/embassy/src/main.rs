//! The attitude tier under embassy, over register models of the sensors: on the emulated MPS2 with SysTick as the
//! clock, and on this machine with one that does not wait. It prints inclination and azimuth after 800 samples, and
//! ends.
//!
//! `cargo run -p embassy-probe`
//! `cargo build --release -p embassy-probe --target thumbv7em-none-eabihf`
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "chip.rs"]
mod platform;
#[cfg(not(target_os = "none"))]
#[path = "desk.rs"]
mod platform;

use embassy_executor::{Executor, Spawner};
use embassy_probe::{Parts, Played, Samples, acquire, fly};
use meerkat_mwd::{Config, probe::AttitudeProbe};
use platform::{Ticks, end};
use static_cell::{ConstStaticCell, StaticCell};

/// Period of the ISM330DHCX, 1/208 s, microseconds.
const PERIOD_US: u32 = 4_808;
const MOST: u32 = 800;

static SAMPLES: Samples = Samples::new();
static PARTS: StaticCell<Parts> = StaticCell::new();
static PROBE: ConstStaticCell<AttitudeProbe> = ConstStaticCell::new(AttitudeProbe::new());
static EXECUTOR: StaticCell<Executor> = StaticCell::new();

#[embassy_executor::task]
async fn acquisition(parts: &'static Parts, clock: Ticks) {
    let (mut inertial, mut magnetic) = (parts.inertial(), parts.magnetic());
    let mut clock = Played { clock, parts };
    if acquire(&mut clock, &mut inertial, &mut magnetic, &SAMPLES).await.is_err() {
        end(None);
    }
}

#[embassy_executor::task]
async fn flight(probe: &'static mut AttitudeProbe) {
    let attitude = fly(probe, &SAMPLES, MOST).await;
    let mdeg = |radians: f32| (radians * 57_295.78) as i32;
    end(attitude.map(|attitude| [MOST as i32, mdeg(attitude.inclination_rad), mdeg(attitude.azimuth_rad)]));
}

/// Starts both tasks.
fn start(spawner: Spawner, clock: Ticks) {
    let probe = PROBE.take();
    let config = Config { sample_period_us: PERIOD_US, ..Config::default() };
    if probe.configure(&config).is_err() {
        end(None);
    }
    let tasks = (acquisition(PARTS.init_with(Parts::new), clock), flight(probe));
    let (Ok(acquisition), Ok(flight)) = tasks else { end(None) };
    spawner.spawn(acquisition);
    spawner.spawn(flight);
}

fn run(clock: Ticks) -> ! {
    EXECUTOR.init_with(Executor::new).run(|spawner| start(spawner, clock))
}

#[cfg(not(target_os = "none"))]
fn main() {
    run(Ticks::start(PERIOD_US))
}
