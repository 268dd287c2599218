use crate::stack;
use core::{hint::black_box, time::Duration};
use cortex_m::{
    asm,
    peripheral::{SYST, syst::SystClkSource},
};
use cortex_m_rt::entry;
use meerkat_mwd::{
    attitude::{Attitude, AttitudeFilter, AttitudeFlags},
    compensation::GyroModel,
    config::{self, AttitudeConfig, Earth},
};
use nalgebra::{UnitQuaternion, Vector3};
use semihosting::{println, process};
use uf_ahrs::{Ahrs, Madgwick, MadgwickParams, Mahony, MahonyParams, Vqf, VqfParams};

/// Samples a second: of drilling probes, and of the BROAD recordings.
const RATES_HZ: [u16; 3] = [100, 200, 286];
/// Number of samples of a run.
const SAMPLES: u16 = 6_000;
/// Number of samples over which the stack is measured, the start included.
const STACK_SAMPLES: u16 = 400;
/// Rotation of the probe, rad/s: 30 rpm.
const TURN_RAD_S: f32 = 3.14;
/// Instructions of the calibration, under one round of the timer.
const CALIBRATION: u32 = 200_000;

/// A gyro model with plausible errors in all twelve parameters.
const MODEL: GyroModel =
    GyroModel { p: [[1.01, 0.02, 0.0], [0.0, 0.98, 0.01], [0.01, 0.0, 1.02]], b_rad_s: [0.01, -0.01, 0.02] };

#[entry]
fn main() -> ! {
    static mut FILTER: AttitudeFilter = AttitudeFilter::new();
    let Some(counter) = cortex_m::Peripherals::take().map(|peripherals| Counter::start(peripherals.SYST)) else {
        process::exit(1)
    };
    for rate_hz in RATES_HZ {
        let dt_s = 1.0 / f32::from(rate_hz);
        let dt = Duration::from_micros(u64::from(1_000_000 / u32::from(rate_hz)));
        FILTER.start(&AttitudeConfig::default(), &Earth::default(), config::Motion::DrillString);
        counter.run("ours", rate_hz, |m| {
            black_box(ours(FILTER, dt_s, m));
        });
        let mut vqf = Vqf::new(dt, VqfParams::default());
        counter.run("VQF", rate_hz, |m| {
            black_box(theirs(&mut vqf, m));
        });
        let mut madgwick = Madgwick::new(dt, MadgwickParams::default());
        counter.run("Madgwick", rate_hz, |m| {
            black_box(theirs(&mut madgwick, m));
        });
        let mut mahony = Mahony::new(dt, MahonyParams::default());
        counter.run("Mahony", rate_hz, |m| {
            black_box(theirs(&mut mahony, m));
        });
    }
    process::exit(0)
}

/// Compensation, propagation, fusion, angles with their uncertainties.
#[inline(never)]
fn ours(filter: &mut AttitudeFilter, dt_s: f32, m: &Measurement) -> Option<Attitude> {
    filter.propagate(dt_s, &MODEL.compensate(m.gyro_rad_s.into()));
    filter.observe(Some(&m.accel_m_s2), Some(&m.mag_ut));
    filter.attitude(AttitudeFlags::empty())
}

#[inline(never)]
fn theirs(filter: &mut impl Ahrs, m: &Measurement) -> UnitQuaternion<f32> {
    filter.update(m.gyro_rad_s, m.accel_m_s2, m.mag_ut);
    filter.orientation()
}

struct Measurement {
    gyro_rad_s: Vector3<f32>,
    accel_m_s2: Vector3<f32>,
    mag_ut: Vector3<f32>,
}

/// A probe that turns about its axis at 30 deg of inclination, in a field of 50 uT that dips by 65 deg, with
/// noise.
struct Motion {
    t_s: f32,
    state: u32,
}

impl Motion {
    fn noise(&mut self, size: f32) -> Vector3<f32> {
        Vector3::from_fn(|_, _| {
            // A congruential generator (Numerical Recipes, ranqd1).
            self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            size * ((self.state >> 8) as f32 / 16_777_216.0 - 0.5)
        })
    }

    fn step(&mut self, dt_s: f32) -> Measurement {
        self.t_s += dt_s;
        let (sine, cosine) = libm::sincosf(TURN_RAD_S * self.t_s);
        let (north, down) =
            (Vector3::new(0.866 * cosine, -0.866 * sine, 0.5), Vector3::new(-0.5 * cosine, 0.5 * sine, 0.866));
        Measurement {
            gyro_rad_s: Vector3::new(0.0, 0.0, TURN_RAD_S) + self.noise(0.01),
            accel_m_s2: down * -9.8 + self.noise(0.1),
            mag_ut: north * 21.1 + down * 45.3 + self.noise(0.2),
        }
    }
}

/// SysTick: under `-icount` it counts executed instructions, and how many ticks one takes is measured with a
/// loop of known length.
struct Counter {
    ticks_per_instruction: f32,
    overhead_ticks: u32,
}

impl Counter {
    fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(0x00ff_ffff);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Self { ticks_per_instruction: 1.0, overhead_ticks: 0 };
        counter.overhead_ticks = counter.ticks(|| ());
        // `asm::delay` is a loop of two instructions.
        let base = counter.ticks(|| asm::delay(0));
        let delayed = counter.ticks(|| asm::delay(CALIBRATION / 2));
        counter.ticks_per_instruction = (delayed - base) as f32 / CALIBRATION as f32;
        counter
    }

    fn ticks(&self, work: impl FnOnce()) -> u32 {
        let before = SYST::get_current();
        work();
        (before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff).saturating_sub(self.overhead_ticks)
    }

    fn run(&self, name: &str, rate_hz: u16, mut update: impl FnMut(&Measurement)) {
        let mut motion = Motion { t_s: 0.0, state: 1 };
        let mut stack_bytes = 0;
        for _ in 0..STACK_SAMPLES {
            let measurement = black_box(motion.step(1.0 / f32::from(rate_hz)));
            stack_bytes = stack_bytes.max(stack::depth(|| update(&measurement)));
        }
        let (mut sum, mut worst) = (0_u64, 0);
        for _ in 0..SAMPLES {
            let measurement = black_box(motion.step(1.0 / f32::from(rate_hz)));
            let ticks = self.ticks(|| update(&measurement));
            sum += u64::from(ticks);
            worst = worst.max(ticks);
        }
        let instructions = |ticks: f32| (ticks / self.ticks_per_instruction + 0.5) as u32;
        let mean = instructions(sum as f32 / f32::from(SAMPLES));
        println!("{name},{rate_hz},{mean},{},{stack_bytes}", instructions(worst as f32));
    }
}
