//! Motion of a tool that swings about all axes, as its sensors see it.

use meerkat_mwd::{Sample, SampleFlags};
use nalgebra::{Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::f32::consts::TAU;

/// Step of the truth, microseconds.
pub const STEP_US: u64 = 1_000;
/// Length of the motion before time 0, microseconds.
pub const BEFORE_US: u64 = 6_000_000;
/// Steps of the truth from one of its samples to the next.
const BEFORE_STEPS: usize = 5;
/// Half width of the readings' uniform noise: some codes, as sound sensors have.
const NOISE: [f32; 3] = [0.01, 0.06, 0.06];
const GRAVITY_M_S2: f32 = 9.81;

/// The truth of a run, with noise and without.
pub struct Motion {
    /// Truth with noise, which the parts measure, every `STEP_US` from time 0.
    pub seen: Vec<Sample>,
    /// Truth without noise.
    pub truth: Vec<Sample>,
    /// `BEFORE_US` of the same motion as good sensors would see it; it ends at time 0 of the run.
    pub before: Vec<Sample>,
}

impl Motion {
    /// Draws three sines of random phase for each axis, up to 3 rad/s and 20 rad/s^2.
    #[must_use]
    pub fn new(duration_us: u64, seed: u64) -> Self {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut uniform = move || rng.next_u32() as f32 / u32::MAX as f32;
        let waves: [[(f32, f32, f32); 3]; 3] = std::array::from_fn(|_| {
            std::array::from_fn(|k| (1.0 / (k + 1) as f32, 0.7 + 0.8 * k as f32 + 0.3 * uniform(), TAU * uniform()))
        });
        let field = Vector3::new(20.0, 3.0, 45.0);
        let mut body_to_ned = Rotation3::from_euler_angles(0.3, 0.7, 1.1);
        let (mut seen, mut truth) = (Vec::new(), Vec::new());
        for step in 0..=(BEFORE_US + duration_us) / STEP_US {
            let t_us = step * STEP_US;
            let t_s = t_us as f32 * 1e-6;
            let rate =
                Vector3::from(waves.map(|axis| axis.iter().map(|(a, hz, p)| a * libm::sinf(TAU * hz * t_s + p)).sum()));
            let down = body_to_ned.inverse() * Vector3::new(0.0, 0.0, GRAVITY_M_S2);
            let clean = Sample {
                t_us,
                gyro_rad_s: rate.into(),
                accel_m_s2: (-down).into(),
                mag_ut: (body_to_ned.inverse() * field).into(),
                temperature_c: 40.0 + t_s,
                flags: SampleFlags::empty(),
            };
            let mut noisy = |v: [f32; 3], noise: f32| v.map(|x| x + noise * (2.0 * uniform() - 1.0));
            truth.push(clean);
            seen.push(Sample {
                gyro_rad_s: noisy(clean.gyro_rad_s, NOISE[0]),
                accel_m_s2: noisy(clean.accel_m_s2, NOISE[1]),
                mag_ut: noisy(clean.mag_ut, NOISE[2]),
                ..clean
            });
            body_to_ned *= Rotation3::new(rate * (STEP_US as f32 * 1e-6));
        }
        let start = (BEFORE_US / STEP_US) as usize;
        let before = seen.iter().take(start).step_by(BEFORE_STEPS).copied().collect();
        let from_start = |samples: Vec<Sample>| {
            let later = samples.into_iter().skip(start);
            later.map(|sample| Sample { t_us: sample.t_us - BEFORE_US, ..sample }).collect()
        };
        Self { seen: from_start(seen), truth: from_start(truth), before }
    }

    /// Smallest and largest truth of each axis from `from_us` to `to_us`.
    pub(super) fn range(&self, of: fn(&Sample) -> [f32; 3], from_us: u64, to_us: u64) -> [(f32, f32); 3] {
        let (from, to) = ((from_us / STEP_US) as usize, to_us.div_ceil(STEP_US) as usize);
        let mut range = [(f32::INFINITY, f32::NEG_INFINITY); 3];
        let last = self.truth.len().saturating_sub(1);
        for sample in &self.truth[from.min(last)..=to.min(last)] {
            for (axis, x) in of(sample).into_iter().enumerate() {
                range[axis] = (
                    if x < range[axis].0 { x } else { range[axis].0 },
                    if x > range[axis].1 { x } else { range[axis].1 },
                );
            }
        }
        range
    }
}
