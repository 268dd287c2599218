use crate::{
    compensation::GyroModel,
    identification::prior::theta_of,
    rotation::rotate_back,
    window::{Reading, RestLimits, SampleStream, Scales, StreamSettings},
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Increments of 20 ms in 50 s, and from one test window to the next; one lasts four of these.
const INCREMENTS: u64 = 2_500;
pub const HOP: u32 = 25;

/// White noise of an increment: a vibrating accelerometer, a quiet magnetometer.
const GRAVITY_NOISE_M_S2: f32 = 1.0;
const FIELD_NOISE_UT: f32 = 0.2;

/// Raw rate, gravity and field of an increment.
pub type Readings = [Vector3<f32>; 3];

/// 50 s of a body that tumbles smoothly, with a gyro whose scale errs by some percent; `disturb` changes each increment.
pub fn tumbling(disturb: impl Fn(u32, &mut Readings)) -> SampleStream {
    let mut stream = SampleStream::zero();
    stream.configure(&StreamSettings {
        sample_period_us: 20_000,
        rest_limits: RestLimits { deviation_rad_s: 0.01, bias_rad_s: 0.08 },
        bias_walk_rad_s_rts: 1e-5,
        gravity_m_s2: 9.81,
        scales: Scales::new(10.0, 100.0, 300.0),
    });
    stream.start(0, &theta_of(&GyroModel::IDENTITY));
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
    let mut normal = || (0..12).map(|_| generator.next_u32() as f32 / u32::MAX as f32).sum::<f32>() - 6.0;
    let mut q = Quaternion::<f64>::identity();
    for k in 0..=INCREMENTS {
        let mut means = [Vector3::zeros(); 3];
        for j in 0..20 {
            let t = (k as f64 + (f64::from(j) + 0.5) / 20.0) * 0.02;
            let sine = |f: f64, phase: f64| libm::sin(core::f64::consts::TAU * f * t + phase);
            let rate = Vector3::new(1.2 * sine(0.21, 0.3) + 0.3, sine(0.17, 1.7) - 0.2, 1.5 * sine(0.13, 2.9) + 0.4);
            q = (q * UnitQuaternion::from_scaled_axis(rate * 0.001).into_inner()).normalize();
            let single = q.cast::<f32>();
            let rate = rate.cast::<f32>().component_mul(&Vector3::new(1.02, 0.97, 1.01));
            means[0] += rate / 20.0;
            means[1] += rotate_back(&single, &Vector3::new(0.0, 0.0, 9.81)) / 20.0;
            means[2] += rotate_back(&single, &Vector3::new(20.0, 0.0, 45.0)) / 20.0;
        }
        for (mean, sigma) in means.iter_mut().zip([1e-3, GRAVITY_NOISE_M_S2, FIELD_NOISE_UT]) {
            *mean += Vector3::new(normal(), normal(), normal()) * sigma;
        }
        disturb(k as u32, &mut means);
        let [rate, gravity, field] = means.map(Reading::Good);
        stream.push(20_000 * k, rate, gravity, field, None);
    }
    stream
}
