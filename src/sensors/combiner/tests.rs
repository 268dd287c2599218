//! Delays from the parts' data sheets through the combiner to the attitude.

extern crate std;

use super::*;
use crate::{
    Config, Probe,
    attitude::AttitudeFlags,
    sensors::{
        Rm3100Settings,
        blocking::{Ism330dhcx, Part, Rm3100},
    },
};
use core::{convert::Infallible, f64::consts::TAU};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Bus that is never used: the figures of a data sheet need none.
struct NoBus;

impl ErrorType for NoBus {
    type Error = Infallible;
}

impl SpiDevice for NoBus {
    fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Rate of the turning tool: 180 rpm.
const RATE_RAD_S: f64 = 3.0 * TAU;

/// Toolface and rate of a tool that stands still for 2 s, then speeds up for 2 s.
fn turned(t_s: f64) -> (f64, f64) {
    let (speeding_s, steady_s) = ((t_s - 2.0).clamp(0.0, 2.0), (t_s - 4.0).max(0.0));
    (RATE_RAD_S * (0.25 * speeding_s * speeding_s + steady_s), RATE_RAD_S * 0.5 * speeding_s)
}

/// Vector of the earth (north, east, down) as a tool in a vertical hole reads it at this toolface.
fn in_tool([north, east, down]: [f64; 3], toolface: f64) -> [f64; 3] {
    let (s, c) = libm::sincos(toolface);
    [c * north + s * east, c * east - s * north, down]
}

/// Each part reads the truth of its own latency ago and has a clock of its own. If ignored, the mean wait of a
/// magnetic for an inertial reading would turn the field by 2.6 deg; a millisecond, within which a declared delay
/// counts as known, turns it by 1.1 deg.
#[test]
fn a_turning_tool_points_where_it_does_by_its_parts_latencies() {
    let inertial = Ism330dhcx::new_spi(NoBus, 1).data();
    let magnetic = Rm3100::new_spi(NoBus, Rm3100Settings::default()).data();
    let config = Config {
        sample_period_us: inertial.period_us,
        latency: Latency::of_parts(&inertial, &magnetic),
        effects: false,
        ..Config::default()
    };
    let mut probe = std::boxed::Box::new(Probe::new());
    probe.configure(&config).unwrap();
    let mut combiner = Combiner::new(inertial.period_us);
    let mut random = Xoshiro128PlusPlus::seed_from_u64(4);
    // Without noise a sensor counts as frozen.
    let mut noisy = |v: [f64; 3], width: f64| {
        v.map(|x| (x + width * (f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5)) as f32)
    };
    let gyro_s = f64::from(inertial.sensors[0].mean_latency_s());
    let mag_s = f64::from(magnetic.sensors[0].mean_latency_s());
    let (mut next_us, mut sum_rad, mut count) = (0, 0.0, 0);
    for k in 0..40_000_000 / u64::from(inertial.period_us) {
        let t_us = k * u64::from(inertial.period_us);
        let t_s = t_us as f64 * 1e-6;
        while next_us <= t_us {
            let (toolface, _) = turned(next_us as f64 * 1e-6 - mag_s);
            let mag_ut = noisy(in_tool([20.0, 0.0, 45.0], toolface), 0.2);
            combiner.magnetic(MagneticReading { t_us: next_us, mag_ut, ..MagneticReading::default() });
            next_us += u64::from(magnetic.period_us);
        }
        let reading = InertialReading {
            t_us,
            gyro_rad_s: noisy([0.0, 0.0, turned(t_s - gyro_s).1], 0.002),
            accel_m_s2: noisy([0.0, 0.0, -9.806_65], 0.02),
            temperature_c: 25.0,
            ..InertialReading::default()
        };
        let sample = combiner.inertial(&reading).unwrap();
        let output = probe.push(&sample).unwrap();
        if let Some(attitude) = output.attitude.filter(|_| t_s > 20.0) {
            assert!(!attitude.flags.contains(AttitudeFlags::NO_HEADING));
            let (truth, _) = turned(output.t_us as f64 * 1e-6);
            let error = (f64::from(attitude.magnetic_toolface_rad) - truth).rem_euclid(TAU);
            sum_rad += if error > 0.5 * TAU { error - TAU } else { error };
            count += 1;
        }
    }
    let mean_deg = (sum_rad / f64::from(count)).to_degrees();
    assert!(mean_deg.abs() < 0.3, "{mean_deg} deg");
}
