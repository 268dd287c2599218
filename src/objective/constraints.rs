use nalgebra::Vector3;

/// Largest e_h of eq 8 with which a pair of readings counts (paper, after eq 8).
const NORM_ERROR_LIMIT: f32 = 0.5;

/// An angle under so many of its standard deviations says nothing of the rotation that made it.
const LEAST_SIGMAS: f32 = 3.0;

/// Eq 6 in our reading: |ln(|w_perp| T / angle)|, 0 where gyro and accelerometer agree on how far the body has turned.
///
/// `earlier` and `later` are specific force, body frame, `interval_s` apart, `rate_rad_s` the mean body rate between them, w_perp
/// its part across specific force (their mean direction), `sigma_rad` the standard deviation of the angle between the two.
///
/// `None` where the angle is under 3 sigma. As printed the ratio is of the whole rate, and it diverges at the TRUE parameters when the
/// body turns about gravity, as it does in a vertical hole: such a rotation does not move gravity. A logarithm, so that half and
/// double are equally far from agreement. For half a turn and more the angle is ambiguous; about an axis at the angle A to
/// gravity the ratio is low by cos(A)^2 (w T)^2 / 12 of itself, so the interval should be short.
pub(crate) fn rotation_disagreement(
    rate_rad_s: &Vector3<f32>,
    (earlier, later): (&Vector3<f32>, &Vector3<f32>),
    interval_s: f32,
    sigma_rad: f32,
) -> Option<f32> {
    let angle = libm::atan2f(earlier.cross(later).norm(), earlier.dot(later));
    if !(angle > LEAST_SIGMAS * sigma_rad && sigma_rad >= 0.0) {
        return None;
    }
    let middle = earlier / earlier.norm() + later / later.norm();
    let across = rate_rad_s - middle * (rate_rad_s.dot(&middle) / middle.norm_squared());
    finite(libm::fabsf(libm::logf(across.norm() * interval_s / angle)))
}

/// e_h of eq 8 and a_h of eq 16, ||h_hat| - |h|| / |h|. A rotation keeps the norm, so this judges the readings and not the gyro:
/// the earlier one does as well as its prediction. `None` where it is not finite.
fn norm_error(earlier_norm: f32, norm: f32) -> Option<f32> {
    finite(libm::fabsf(earlier_norm - norm) / norm)
}

/// Eq 8 as a flag of the data: whether a reading of one norm is fit for use after one of another. What is not finite is not.
pub(crate) fn fit_for_use(earlier_norm: f32, norm: f32) -> bool {
    norm_error(earlier_norm, norm).is_some_and(|error| error <= NORM_ERROR_LIMIT)
}

const fn finite(x: f32) -> Option<f32> {
    if x.is_finite() { Some(x) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::{exp_quaternion, rotate_back};
    use core::f32::consts::LN_2;

    /// The paper's turntable: 180 deg/s about z, 30 Hz.
    const RATE: Vector3<f32> = Vector3::new(0.0, 0.0, core::f32::consts::PI);
    const INTERVAL_S: f32 = 1.0 / 30.0;

    /// A vector at an angle from z, and what the true rotation makes of it in the body frame.
    fn pair(from_axis_deg: f32) -> (Vector3<f32>, Vector3<f32>) {
        let (sine, cosine) = libm::sincosf(from_axis_deg.to_radians());
        let (s, c) = libm::sincosf(-RATE.z * INTERVAL_S);
        (Vector3::new(50.0 * sine, 0.0, 50.0 * cosine), Vector3::new(50.0 * sine * c, 50.0 * sine * s, 50.0 * cosine))
    }

    /// Eq 7 in our reading: exp(-[w]x dt) h, what an earth-fixed vector of the body frame becomes while the body turns. The window's nodes
    /// are de-rotated by it, step by step.
    fn predicted(rate_rad_s: &Vector3<f32>, earlier: &Vector3<f32>) -> Vector3<f32> {
        rotate_back(&exp_quaternion(&(rate_rad_s * INTERVAL_S)), earlier)
    }

    /// |h_hat - h| / |h|: what the innovations constrain in place of eq 8.
    fn vector_residual(predicted: &Vector3<f32>, measured: &Vector3<f32>) -> f32 {
        (predicted - measured).norm() / measured.norm()
    }

    fn angle_deg(a: &Vector3<f32>, b: &Vector3<f32>) -> f32 {
        libm::atan2f(a.cross(b).norm(), a.dot(b)).to_degrees()
    }

    /// As printed, (1 + [w]x dt) h, it turns the vector the wrong way; the same holds for eq 15.
    #[test]
    fn the_prediction_is_the_true_rotation_and_the_printed_sign_is_the_wrong_way() {
        for from_axis_deg in [0.0, 25.0, 38.0, 90.0_f32] {
            let (before, after) = pair(from_axis_deg);
            let exact = predicted(&RATE, &before);
            assert!(vector_residual(&exact, &after) < 1e-6, "{from_axis_deg}");
        }
        // Across the axis: 6 deg one way, and atan(6 deg) the other way.
        let (before, after) = pair(90.0);
        let turn = before.cross(&RATE) * -INTERVAL_S;
        let six = 6.0_f32.to_radians();
        let expected = 6.0 + libm::atanf(six).to_degrees();
        assert!((angle_deg(&(before + turn), &after) - expected).abs() < 1e-3);
        // First order with the minus sign: the direction is off by the cube, the vector by half the square.
        assert!((angle_deg(&(before - turn), &after) - (6.0 - libm::atanf(six).to_degrees())).abs() < 1e-3);
        let residual = vector_residual(&(before - turn), &after);
        assert!((residual / (0.5 * six * six) - 1.0).abs() < 0.01);
        assert!((residual.to_degrees() - 0.31).abs() < 0.01);

        let (before, after) = pair(38.0);
        let turn = before.cross(&RATE) * -INTERVAL_S;
        assert!((angle_deg(&(before + turn), &after) - 7.4).abs() < 0.05);
    }

    #[test]
    fn a_rotation_across_gravity_agrees_and_a_scale_error_is_its_logarithm() {
        let (before, after) = pair(90.0);
        for (scale, expected) in [(1.0_f32, 0.0), (1.1, 0.095_310), (0.5, LN_2), (2.0, LN_2)] {
            let found = rotation_disagreement(&(RATE * scale), (&before, &after), INTERVAL_S, 0.01).unwrap();
            assert!((found - expected).abs() < 1e-4, "{scale}: {found}");
        }
        // About an axis off gravity only the part across it counts, to second order of the angle.
        let (before, after) = pair(38.0);
        let found = rotation_disagreement(&RATE, (&before, &after), INTERVAL_S, 0.01).unwrap();
        let turn = RATE.z * INTERVAL_S;
        let cosine = libm::cosf(38.0_f32.to_radians());
        assert!((found - turn * turn * cosine * cosine / 12.0).abs() < 1e-5, "{found}");
    }

    /// Where the printed eq 6 divides by zero.
    #[test]
    fn a_rotation_about_gravity_says_nothing() {
        let (before, after) = pair(0.0);
        assert_eq!(rotation_disagreement(&RATE, (&before, &after), INTERVAL_S, 0.01), None);
        // 1 deg from it: 0.1 deg of angle, under three sigma of 0.05.
        let (before, after) = pair(1.0);
        assert_eq!(rotation_disagreement(&RATE, (&before, &after), INTERVAL_S, 0.05_f32.to_radians()), None);
        assert!(rotation_disagreement(&RATE, (&before, &after), INTERVAL_S, 0.02_f32.to_radians()).is_some());
    }

    #[test]
    fn the_norm_is_blind_to_the_gyro_and_sees_bad_data() {
        let (before, after) = pair(60.0);
        for scale in [0.0, 1.0, 3.0] {
            let error = norm_error(predicted(&(RATE * scale), &before).norm(), after.norm()).unwrap();
            assert!(error < 1e-6, "{scale}: {error}");
        }
        assert!(fit_for_use(74.5, 50.0) && fit_for_use(25.5, 50.0));
        assert!(!fit_for_use(75.5, 50.0) && !fit_for_use(24.5, 50.0));
    }

    #[test]
    fn what_is_not_finite_is_no_constraint() {
        let (before, after) = pair(60.0);
        let zero = Vector3::zeros();
        for bad in [Vector3::new(f32::NAN, 0.0, 1.0), Vector3::new(0.0, f32::INFINITY, 1.0)] {
            assert!(!fit_for_use(bad.norm(), 50.0) && !fit_for_use(50.0, bad.norm()));
            assert_eq!(rotation_disagreement(&RATE, (&before, &bad), INTERVAL_S, 0.01), None);
            assert_eq!(rotation_disagreement(&bad, (&before, &after), INTERVAL_S, 0.01), None);
        }
        assert!(!fit_for_use(50.0, 0.0));
        assert_eq!(rotation_disagreement(&RATE, (&before, &zero), INTERVAL_S, 0.01), None);
        for sigma in [f32::NAN, -1.0] {
            assert_eq!(rotation_disagreement(&RATE, (&before, &after), INTERVAL_S, sigma), None);
        }
        // No rate: the logarithm of zero.
        assert_eq!(rotation_disagreement(&zero, (&before, &after), INTERVAL_S, 0.01), None);
    }
}
