//! A known gyro error multiplied into a trace, so that the right result of an identification is known on real
//! data too.

use meerkat_mwd::{SampleFlags, compensation::GyroModel};
use nalgebra::{Matrix3, Vector3};

use crate::{simulate::random::Random, trace::Trace};

/// Largest deviation of P's diagonal from 1.
const DIAGONAL: f64 = 0.10;

/// Largest off-diagonal of P.
const OFF_DIAGONAL: f64 = 0.05;

/// Magnitude of b, rad/s (2 deg/s).
const BIAS_RAD_S: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Draws a gyro model: every element of P is off by half to all of 10 % (diagonal) or 5 % (off-diagonal) with
/// random sign; b is 2 deg/s in a random direction. The same seed gives the same model.
#[must_use]
pub fn draw(seed: u64) -> GyroModel {
    let mut random = Random::new(seed);
    let p = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let size = random.sign() * random.between(0.5, 1.0);
            let element = if row == column { 1.0 + DIAGONAL * size } else { OFF_DIAGONAL * size };
            element as f32
        })
    });
    GyroModel { p, b_rad_s: random.direction().map(|x| (BIAS_RAD_S * x) as f32) }
}

/// The same error at `scale` of its size.
#[must_use]
pub fn scaled(model: &GyroModel, scale: f64) -> GyroModel {
    let identity = GyroModel::IDENTITY.p;
    let p = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let whole = |p: &[[f32; 3]; 3]| p.get(row).and_then(|row| row.get(column)).copied().map_or(0.0, f64::from);
            (whole(&identity) + scale * (whole(&model.p) - whole(&identity))) as f32
        })
    });
    GyroModel { p, b_rad_s: model.b_rad_s.map(|b| (scale * f64::from(b)) as f32) }
}

/// Puts the error into the gyro readings: raw' = P^-1 raw + b, so that `truth` compensates raw' back to raw.
/// The recorded sensor's own errors stay in raw. If P has no inverse the trace stays as it is.
pub fn apply(trace: &mut Trace, truth: &GyroModel) {
    let Some(inverse) = truth.p_matrix().map(f64::from).try_inverse() else { return };
    let b_rad_s = Vector3::from(truth.b_rad_s.map(f64::from));
    for sample in trace.samples.iter_mut().filter(|s| !s.flags.contains(SampleFlags::GYRO_MISSING)) {
        sample.gyro_rad_s = distort(&inverse, &b_rad_s, sample.gyro_rad_s);
    }
}

fn distort(inverse: &Matrix3<f64>, b_rad_s: &Vector3<f64>, raw_rad_s: [f32; 3]) -> [f32; 3] {
    let distorted = inverse * Vector3::from(raw_rad_s.map(f64::from)) + b_rad_s;
    <[f64; 3]>::from(distorted).map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use meerkat_mwd::Sample;

    #[test]
    fn every_element_is_off_by_half_to_all_of_its_bound() {
        for seed in 0..200 {
            let model = draw(seed);
            for (row, values) in model.p.iter().enumerate() {
                for (column, &value) in values.iter().enumerate() {
                    let (off, bound) = if row == column { (value - 1.0, 0.10) } else { (value, 0.05) };
                    assert!((0.5 * bound - 1e-6..=bound + 1e-6).contains(&off.abs()), "seed {seed}: {value}");
                }
            }
            let norm = Vector3::from(model.b_rad_s).norm().to_degrees();
            assert!((norm - 2.0).abs() < 1e-4, "seed {seed}: {norm}");
        }
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
    }

    #[test]
    fn a_scaled_error_keeps_its_signs_and_shares() {
        let (whole, fifth) = (draw(1), scaled(&draw(1), 0.2));
        let off = |model: &GyroModel| (model.p_matrix() - Matrix3::identity(), Vector3::from(model.b_rad_s));
        assert!((0.2 * off(&whole).0 - off(&fifth).0).norm() < 1e-6);
        assert!((0.2 * off(&whole).1 - off(&fifth).1).norm() < 1e-8);
        assert_eq!(scaled(&whole, 0.0), GyroModel::IDENTITY);
    }

    #[test]
    fn the_model_that_was_applied_compensates_it_and_missing_readings_stay_zero() {
        let truth = draw(3);
        let missing = Sample { flags: SampleFlags::GYRO_MISSING, ..Sample::default() };
        let turning = Sample { gyro_rad_s: [1.0, -2.0, 3.0], ..Sample::default() };
        let mut trace = Trace { samples: vec![turning, missing], ..Trace::default() };
        apply(&mut trace, &truth);
        let back = truth.compensate(trace.samples.first().unwrap().gyro_rad_s);
        assert!((back - Vector3::new(1.0, -2.0, 3.0)).norm() < 2e-6);
        assert_eq!(trace.samples.last().unwrap().gyro_rad_s, [0.0; 3]);
    }
}
