//! Rotation error over a second: rotation by compensated readings, with noise and lags, against the true one.

use meerkat_mwd::{SampleFlags, compensation::GyroModel};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use testbed::study::one_window::Run;

/// Length of a rotation, seconds.
const ROTATION_S: f64 = 1.0;

/// Angle between the rotations that a model gives over consecutive seconds and the true ones, degrees rms,
/// from the sample on at which the window's result applies. Seconds with a missing or clipped gyro reading
/// are left out; NaN if none is left.
#[must_use]
pub fn rotation_error_deg(run: &Run, model: &GyroModel) -> f64 {
    let period_s = f64::from(run.scenario.sample_period_us) * 1e-6;
    let (p, b) = (model.p_matrix().map(f64::from), Vector3::from(model.b_rad_s.map(f64::from)));
    let length = (ROTATION_S / period_s).round() as usize;
    let attitude = |index: usize| -> Option<UnitQuaternion<f64>> {
        let [w, x, y, z] = (*run.trace.reference.get(index)?)?;
        Some(UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
    };
    let (mut sum, mut count) = (0.0, 0_u32);
    for start in (run.effect..run.trace.samples.len().saturating_sub(length)).step_by(length) {
        let Some(samples) = run.trace.samples.get(start..=start + length) else { break };
        let unread = SampleFlags::GYRO_MISSING | SampleFlags::GYRO_CLIPPED;
        if samples.iter().any(|sample| sample.flags.intersects(unread)) {
            continue;
        }
        let turned = samples.iter().map(|s| p * (Vector3::from(s.gyro_rad_s.map(f64::from)) - b) * period_s);
        let mut before = Vector3::zeros();
        let rotation = turned.enumerate().fold(UnitQuaternion::identity(), |rotation, (k, now)| {
            // Readings are means around their times: half of the first and half of the last lies inside.
            let inside = if k == 0 || k == length { 0.5 } else { 1.0 };
            let coning = before.cross(&now) / 12.0;
            before = now;
            rotation * UnitQuaternion::from_scaled_axis((now + coning) * inside)
        });
        if let (Some(from), Some(to)) = (attitude(start), attitude(start + length)) {
            sum += rotation.angle_to(&(from.inverse() * to)).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt().to_degrees()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use testbed::simulate::{Gyro, Scenario};

    /// With the true model only noise remains, 0.1 deg/s/rtHz on three axes over a second; a bias of 0.3
    /// deg/s adds to it.
    #[test]
    fn the_truth_leaves_the_angle_random_walk_and_a_bias_adds_a_second_of_itself() {
        let gyro = Gyro {
            noise_deg_s_rthz: 0.1,
            bias_walk_deg_s_rts: 0.0,
            p: Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            ..Gyro::default()
        };
        let run = Run::simulate(&Scenario { gyro, ..Scenario::default() }, 5).unwrap();
        let mut model = run.true_model();
        let walk = 0.1 * 3_f64.sqrt();
        let noise = rotation_error_deg(&run, &model);
        assert!((noise / walk - 1.0).abs() < 0.1, "{noise}");
        model.b_rad_s[2] += 0.3_f32.to_radians();
        let with_bias = rotation_error_deg(&run, &model);
        assert!((with_bias / walk.hypot(0.3) - 1.0).abs() < 0.1, "{with_bias}");
    }
}
