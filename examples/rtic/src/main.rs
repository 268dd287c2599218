//! The attitude tier under RTIC 2, on the emulated MPS2: SysTick takes a sample two hundred times a second, and a
//! software task of a lower priority flies it. It prints inclination and azimuth after four seconds, and ends. On a
//! desk this is an empty program.
//!
//! `cargo build --release -p rtic-probe --target thumbv7em-none-eabihf`
#![cfg_attr(target_os = "none", no_std, no_main)]
// Lints that are allowed for the code that RTIC's macro writes.
#![allow(unsafe_code, missing_docs)]

#[cfg(target_os = "none")]
mod device;

// Start-up and the table of exceptions.
#[cfg(target_os = "none")]
use cortex_m_rt as _;

#[cfg(target_os = "none")]
#[rtic::app(device = crate::device, peripherals = false, dispatchers = [UART0_RX])]
mod app {
    use cortex_m::peripheral::{SYST, syst::SystClkSource};
    use meerkat_mwd::{
        Config, Sample,
        heapless::spsc::{Consumer, Producer, Queue},
        probe::AttitudeProbe,
    };
    use semihosting::{println, process};

    /// Clock of the MPS2's processor (Arm DAI 0386), over 200 samples a second.
    const TICKS: u32 = 25_000_000 / 200;
    const SAMPLES: u32 = 800;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        systick: SYST,
        taken: u32,
        into: Producer<'static, Sample>,
        out: Consumer<'static, Sample>,
        probe: AttitudeProbe,
        flown: u32,
    }

    #[init(local = [queue: Queue<Sample, 16> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut systick = cx.core.SYST;
        systick.set_clock_source(SystClkSource::Core);
        systick.set_reload(TICKS - 1);
        systick.clear_current();
        systick.enable_counter();
        systick.enable_interrupt();
        let mut probe = AttitudeProbe::new();
        if probe.configure(&Config::default()).is_err() {
            process::exit(1);
        }
        let (into, out) = cx.local.queue.split();
        (Shared {}, Local { systick, taken: 0, into, out, probe, flown: 0 })
    }

    /// The driver: here a tool that rests at 30 deg of inclination, its highside up.
    #[task(binds = SysTick, priority = 2, local = [systick, taken, into])]
    fn sample(cx: sample::Context) {
        let k = *cx.local.taken;
        *cx.local.taken += 1;
        // A little noise: a sensor that never changes counts as frozen.
        let noise = (k.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-6;
        let sample = Sample {
            t_us: 5_000 * u64::from(k),
            gyro_rad_s: [noise, -noise, noise],
            accel_m_s2: [4.903 + noise, 0.0 + noise, -8.493 + noise],
            mag_ut: [-40.5 + noise, -10.0 + noise, 27.7 + noise],
            temperature_c: 25.0,
            ..Sample::default()
        };
        // A full queue is a task that is too slow.
        if cx.local.into.enqueue(sample).is_err() {
            println!("a sample was lost");
            process::exit(1);
        }
        let _ = fly::spawn();
    }

    #[task(priority = 1, local = [out, probe, flown])]
    async fn fly(cx: fly::Context) {
        while let Some(sample) = cx.local.out.dequeue() {
            let output = cx.local.probe.push(&sample);
            *cx.local.flown += 1;
            let attitude = output.and_then(|output| output.attitude);
            if let Some(attitude) = attitude.filter(|_| *cx.local.flown == SAMPLES) {
                let mdeg = |radians: f32| (radians * 57_295.78) as i32;
                println!("{SAMPLES} {} {}", mdeg(attitude.inclination_rad), mdeg(attitude.azimuth_rad));
                process::exit(0);
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
