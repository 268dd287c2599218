use std::ops::Range;

use meerkat_mwd::compensation::GyroModel;
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

use testbed::{simulate::Hits, trace::Trace};

/// The twelve unknowns: P row by row, then c = P b, so that w = P `w_raw` - c.
pub(super) type Theta = SVector<f64, 12>;

/// A matrix over the unknowns: an information or a covariance.
pub(super) type Matrix12 = SMatrix<f64, 12, 12>;

/// One sample of the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Raw rate, rad/s.
    pub raw: Vector3<f64>,
    /// Gravity (minus specific force, m/s^2) and field (microtesla), body axes.
    pub vectors: [Vector3<f64>; 2],
    /// For gyro, accelerometer and magnetometer: true if it is hit; only the oracle may look.
    pub hit: [bool; 3],
}

/// The samples of a window, in double precision.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    pub period_s: f64,
    pub samples: Vec<Reading>,
}

impl Readings {
    pub fn new(trace: &Trace, window: &Range<usize>, hits: Option<&Hits>) -> Self {
        let double = |v: [f32; 3]| Vector3::from(v.map(f64::from));
        let reading = |k: usize| {
            let sample = trace.samples.get(k)?;
            let is_hit = |mask: fn(&Hits) -> &Vec<bool>| hits.is_some_and(|h| mask(h).get(k) == Some(&true));
            Some(Reading {
                raw: double(sample.gyro_rad_s),
                vectors: [-double(sample.accel_m_s2), double(sample.mag_ut)],
                hit: [is_hit(|h| &h.gyro), is_hit(|h| &h.accel), is_hit(|h| &h.mag)],
            })
        };
        let period_s = f64::from(trace.nominal_period_us()) * 1e-6;
        Self { period_s, samples: window.clone().filter_map(reading).collect() }
    }

    /// Rotation from each sample to the first one's frame, with the rates of `theta`: trapezoids and the
    /// two-sample coning term.
    pub fn attitudes(&self, theta: &Theta) -> Vec<Matrix3<f64>> {
        let dt = self.period_s;
        let mut q = UnitQuaternion::identity();
        let mut last: Option<Vector3<f64>> = None;
        let mut attitude = |sample: &Reading| {
            let rate = rate(theta, &sample.raw);
            if let Some(before) = last {
                q *= UnitQuaternion::from_scaled_axis(
                    (before + rate) * (0.5 * dt) + before.cross(&rate) * (dt * dt / 12.0),
                );
            }
            last = Some(rate);
            q.to_rotation_matrix().into_inner()
        };
        self.samples.iter().map(&mut attitude).collect()
    }
}

/// w = P `w_raw` - c.
pub(super) fn rate(theta: &Theta, raw: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| theta[3 * i] * raw.x + theta[3 * i + 1] * raw.y + theta[3 * i + 2] * raw.z - theta[9 + i])
}

/// P = I, no bias.
pub(super) fn identity() -> Theta {
    Theta::from_fn(|i, _| if matches!(i, 0 | 4 | 8) { 1.0 } else { 0.0 })
}

/// The model of a theta; the identity where its P cannot be inverted.
pub(super) fn model_of(theta: &Theta) -> GyroModel {
    let p = Matrix3::from_fn(|i, j| theta[3 * i + j]);
    let Some(inverse) = p.try_inverse() else { return GyroModel::IDENTITY };
    let b = inverse * Vector3::new(theta[9], theta[10], theta[11]);
    let row = |i: usize| [p[(i, 0)] as f32, p[(i, 1)] as f32, p[(i, 2)] as f32];
    GyroModel { p: [row(0), row(1), row(2)], b_rad_s: [b.x as f32, b.y as f32, b.z as f32] }
}

/// Adds `gain (x) (raw, -1)` to the twelve columns of three rows: the derivative of a rate by P and c, seen
/// through `gain`.
pub(super) fn add_gyro_rows(rows: &mut SMatrix<f64, 3, 12>, gain: &Matrix3<f64>, raw: &Vector3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            let g = gain[(i, j)];
            rows[(i, 3 * j)] += g * raw.x;
            rows[(i, 3 * j + 1)] += g * raw.y;
            rows[(i, 3 * j + 2)] += g * raw.z;
            rows[(i, 9 + j)] -= g;
        }
    }
}
