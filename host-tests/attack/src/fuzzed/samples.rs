//! A flight: a tool that turns, with samples of any bits at all, wrong times and faults among its own.

use arbitrary::{Arbitrary, Unstructured};
use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    config::{IdentificationConfig, Motion},
    probe::Output,
};
use nalgebra::{UnitQuaternion, Vector3};

/// Most samples of an execution of [`samples`], and of [`flights`]: half a minute at the longest period, in which a
/// model is found and flies. An update takes as long as a hundred samples do.
const FEW: usize = 120;
const MANY: usize = 600;
/// Rate of a turn, rad/s, of a step of its byte: to 6.4.
const RATE_STEP_RAD_S: f32 = 0.05;
/// Gravity and field, north, east and down.
const FORCE_M_S2: Vector3<f32> = Vector3::new(0.0, 0.0, -9.806_65);
const FIELD_UT: Vector3<f32> = Vector3::new(20.0, 1.0, 45.0);

/// The flight.
#[derive(Arbitrary, Debug)]
struct Flight {
    /// Sample period, 5 to 50 ms.
    period: u8,
    by_hand: bool,
    /// Work between two samples, in eighths of what is budgeted: none, too little, enough.
    work: u8,
    moments: Vec<Moment>,
}

/// Next part of the flight.
#[derive(Arbitrary, Debug)]
enum Moment {
    /// The tool turns for so many periods. One of its ten numbers may be replaced, and flags set.
    Turn { rate: [i8; 3], periods: u8, replaced: Option<(u8, f32)>, flags: u16 },
    /// A sample after any step of time, microseconds, of any numbers.
    Any { step_us: i32, numbers: [f32; 10], flags: u16 },
}

/// A few samples. Each is taken or counted, what is said of it is finite, and what flies is a model.
///
/// # Panics
/// One is not.
pub fn samples(bytes: &[u8]) {
    fly(bytes, FEW);
}

/// The same of a flight that is long enough for updates, windows and their search.
///
/// # Panics
/// As of [`samples`].
pub fn flights(bytes: &[u8]) {
    fly(bytes, MANY);
}

fn fly(bytes: &[u8], most: usize) {
    let Ok(flight) = Flight::arbitrary(&mut Unstructured::new(bytes)) else { return };
    let mut flown = Flown::new(&flight);
    for moment in &flight.moments {
        match *moment {
            Moment::Turn { rate, periods, replaced, flags } => {
                for _ in 0..most.saturating_sub(flown.pushed).min(periods.into()) {
                    let mut numbers = flown.turned(rate);
                    if let Some((which, number)) = replaced {
                        numbers[usize::from(which) % 10] = number;
                    }
                    flown.push(flown.period_us.into(), numbers, flags);
                }
            }
            Moment::Any { step_us, numbers, flags } => flown.push(step_us.into(), numbers, flags),
        }
        if flown.pushed >= most {
            break;
        }
    }
    let counters = flown.probe.counters();
    assert_eq!(counters.samples + u64::from(counters.out_of_order), flown.pushed as u64);
}

/// A probe that flies.
struct Flown {
    probe: Box<Probe>,
    period_us: u32,
    units: u32,
    t_us: u64,
    /// Body to north, east and down.
    attitude: UnitQuaternion<f32>,
    pushed: usize,
}

impl Flown {
    fn new(flight: &Flight) -> Self {
        let motion = if flight.by_hand { Motion::Hand } else { Motion::DrillString };
        let defaults = Config::default();
        let config = Config {
            sample_period_us: 5_000 * (1 + u32::from(flight.period % 10)),
            // Often, so that a short flight has all of it.
            identification: IdentificationConfig {
                motion,
                update_s: 8.0,
                latency_s: 0.5,
                window_s: 16.0,
                step_s: 8.0,
                ..defaults.identification
            },
            ..defaults
        };
        let mut probe = Box::new(Probe::new());
        assert!(probe.configure(&config).is_ok());
        let units = probe.poll_budget() / 8 * u32::from(flight.work % 9);
        let period_us = config.sample_period_us;
        Self { probe, period_us, units, t_us: 1 << 40, attitude: UnitQuaternion::identity(), pushed: 0 }
    }

    /// Readings of the sensors of a tool that turns for a period.
    fn turned(&mut self, rate: [i8; 3]) -> [f32; 10] {
        let rate_rad_s = Vector3::from(rate.map(f32::from)) * RATE_STEP_RAD_S;
        self.attitude *= UnitQuaternion::from_scaled_axis(rate_rad_s * (self.period_us as f32 * 1e-6));
        self.attitude.renormalize_fast();
        let [down, north] = [FORCE_M_S2, FIELD_UT].map(|known| self.attitude.inverse() * known);
        // A sensor whose last bit never changes is taken for frozen.
        let noise = f32::from((self.pushed * 37 % 101) as u8) * 1e-4;
        let mut numbers = [25.0; 10];
        let read = rate_rad_s.iter().chain(&down).chain(&north);
        numbers.iter_mut().zip(read).for_each(|(number, read)| *number = read + noise);
        numbers
    }

    fn push(&mut self, step_us: i64, numbers: [f32; 10], flags: u16) {
        let [gx, gy, gz, ax, ay, az, mx, my, mz, temperature_c] = numbers;
        self.t_us = self.t_us.saturating_add_signed(step_us);
        let sample = Sample {
            t_us: self.t_us,
            gyro_rad_s: [gx, gy, gz],
            accel_m_s2: [ax, ay, az],
            mag_ut: [mx, my, mz],
            temperature_c,
            flags: SampleFlags::from_bits_retain(flags),
        };
        self.pushed += 1;
        if let Some(output) = self.probe.push(&sample) {
            finite(&output);
        }
        if let Some(report) = self.probe.poll(self.units) {
            assert!(report.flown.is_valid() && report.sigma.iter().all(|x| x.is_finite()), "{report:?}");
        }
        assert!(self.probe.gyro_model().is_valid(), "{:?}", self.probe.gyro_model());
        let _ = self.probe.take_diagnosis();
    }
}

/// # Panics
/// A number that is said is not finite.
pub(super) fn finite(output: &Output) {
    assert!(output.rate_rad_s.iter().all(|x| x.is_finite()), "{output:?}");
    if let Some(it) = output.attitude {
        let angles = [it.inclination_rad, it.azimuth_rad, it.gravity_toolface_rad, it.magnetic_toolface_rad];
        let sigmas = [it.sigma_inclination_rad, it.sigma_azimuth_rad, it.sigma_toolface_rad];
        assert!(it.q.iter().chain(&angles).chain(&sigmas).all(|x| x.is_finite()), "{output:?}");
    }
}
