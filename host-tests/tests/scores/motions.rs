//! Motions, traces of them, and flights with chosen errors.

use crate::rig::{self, rotation::rotation};
use meerkat_mwd::{
    Sample,
    attitude::{Attitude, AttitudeFlags},
    compensation::GyroModel,
    identification::{Decision, Refusal, WindowReport},
    probe::Output,
};
use nalgebra::{UnitQuaternion, Vector3};
use testbed::{flight::Flight, score::Settings, trace::Trace};

pub type Q = UnitQuaternion<f64>;

/// Only samples from `from_us` on, nothing calibrated, no declination.
pub fn from(from_us: u64) -> Settings {
    Settings { from_us, ..Settings::default() }
}

pub fn turn(x_deg: f64, y_deg: f64, z_deg: f64) -> Q {
    UnitQuaternion::from_scaled_axis(Vector3::new(x_deg, y_deg, z_deg).map(f64::to_radians))
}

pub fn cells(q: &Q) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// A trace at `period_us` with the given attitude (body to NED) and gyro reading (rad/s), both functions of
/// seconds.
pub fn trace(period_us: u64, seconds: u64, attitude: impl Fn(f64) -> Q, gyro: impl Fn(f64) -> Vector3<f64>) -> Trace {
    let mut trace = Trace::default();
    for i in 0..=seconds * 1_000_000 / period_us {
        let t_us = i * period_us;
        let t_s = t_us as f64 * 1e-6;
        let up = attitude(t_s).inverse() * Vector3::new(0.0, 0.0, -9.806_65);
        trace.samples.push(Sample {
            t_us,
            gyro_rad_s: gyro(t_s).map(|x| x as f32).into(),
            accel_m_s2: up.map(|x| x as f32).into(),
            ..Sample::default()
        });
        trace.reference.push(Some(cells(&attitude(t_s))));
    }
    trace
}

/// A flight of the raw gyro whose attitude is `error` (in the NED frame) times the reference's.
pub fn flight(trace: &Trace, error: impl Fn(f64) -> Q) -> Flight {
    let outputs = trace.samples.iter().zip(&trace.reference).map(|(sample, reference)| {
        let q = error(sample.t_us as f64 * 1e-6) * rotation(reference.unwrap_or([1.0, 0.0, 0.0, 0.0]));
        let attitude = Attitude {
            q: cells(&q).map(|x| x as f32),
            inclination_rad: 0.0,
            azimuth_rad: 0.0,
            gravity_toolface_rad: 0.0,
            magnetic_toolface_rad: 0.0,
            sigma_inclination_rad: 0.0,
            sigma_azimuth_rad: 0.0,
            sigma_toolface_rad: 0.0,
            flags: AttitudeFlags::default(),
        };
        Output { t_us: sample.t_us, rate_rad_s: sample.gyro_rad_s, attitude: Some(attitude) }
    });
    Flight { outputs: outputs.collect(), ..Flight::default() }
}

pub fn unturned(_: f64) -> Q {
    Q::identity()
}

pub fn still(_: f64) -> Vector3<f64> {
    Vector3::zeros()
}

pub fn report(t_effect_us: Option<u64>, fitted: GyroModel, bias_only: GyroModel) -> WindowReport {
    let decision = Decision::Refused(Refusal::Diverged { nis: 2.0 });
    WindowReport { t_effect_us, fitted, bias_only, ..rig::report::report(decision) }
}

pub fn bias(z_deg_s: f64) -> GyroModel {
    GyroModel { b_rad_s: [0.0, 0.0, z_deg_s.to_radians() as f32], ..GyroModel::IDENTITY }
}

/// A motion about all axes at up to 200 deg/s.
pub fn swing(t: f64) -> Q {
    turn(60.0 * (1.9 * t).sin(), 0.0, 0.0)
        * turn(0.0, 40.0 * (1.3 * t).sin(), 0.0)
        * turn(0.0, 0.0, 90.0 * (0.7 * t).sin())
}

/// Its body rate, by a central difference of the attitude.
pub fn swing_rate(t: f64) -> Vector3<f64> {
    let half = 1e-4;
    (swing(t - half).inverse() * swing(t + half)).scaled_axis() / (2.0 * half)
}

pub fn close(value: Option<f64>, expected: f64, tolerance: f64) {
    let value = value.unwrap();
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}
