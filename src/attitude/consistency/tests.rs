//! The stated covariance follows what the innovations show.

use super::*;

fn steps(consistency: &mut Consistency, seconds: u16, ratio: f32, rate_rad_s: f32) {
    for _ in 0..seconds * 20 {
        consistency.note_heading(ratio, rate_rad_s * rate_rad_s, 0.05);
        consistency.note_velocity(0.04, 0.05);
        consistency.note_velocity(0.04, 0.05);
    }
}

#[test]
fn what_is_stated_follows_what_is_seen_within_half_a_minute() {
    let mut consistency = Consistency::new();
    let one = Matrix3::<f32>::identity();
    assert_eq!(consistency.stated(&one, 0.0), one);
    steps(&mut consistency, 120, 0.25, 0.0);
    let stated = consistency.stated(&one, 0.0);
    assert!((stated.m33 - 0.25).abs() < 0.02 && stated.m11 >= LEAST && stated.m11 < 0.12, "{stated}");
    steps(&mut consistency, 30, 4.0, 0.0);
    assert!((0.7..=1.0).contains(&consistency.stated(&one, 0.0).m33));
    // Tilt and heading stay as correlated as before.
    let mut common = one;
    (common.m13, common.m31) = (0.5, 0.5);
    let stated = consistency.stated(&common, 0.0);
    assert!((stated.m13 / libm::sqrtf(stated.m11 * stated.m33) - 0.5).abs() < 1e-5);
}

/// Squares of a normal distribution whose variance is this part of what is expected.
#[test]
fn the_mean_is_that_of_the_innovations_and_not_of_the_largest() {
    // Quantiles of a normal distribution, each for as long as an innovation stays the same.
    let quantiles = [-1.64, -1.04, -0.67, -0.39, -0.13, 0.13, 0.39, 0.67, 1.04, 1.64_f32];
    let mean_square = quantiles.iter().map(|z| z * z).sum::<f32>() / 10.0;
    for variance in [0.2, 0.5, 0.9] {
        let mut consistency = Consistency::new();
        let mut sum = 0.0;
        for round in 0..20_u8 {
            for z in quantiles {
                steps(&mut consistency, 3, z * z * variance, 1.0);
                if round >= 10 {
                    sum += consistency.stated(&Matrix3::identity(), 0.0).m33 / 100.0;
                }
            }
        }
        assert!((sum / (mean_square * variance) - 1.0).abs() < 0.05, "{variance} {sum}");
    }
}

#[test]
fn half_of_what_is_constant_is_judged_while_the_probe_turns() {
    let nothing = Matrix3::<f32>::zeros();
    let mut consistency = Consistency::new();
    steps(&mut consistency, 120, 0.25, 0.9 * TURNING_RAD_S);
    assert!((consistency.stated(&nothing, 1.0).m33 - 1.0).abs() < 1e-6);
    steps(&mut consistency, 120, 0.25, 1.1 * TURNING_RAD_S);
    assert!((consistency.stated(&nothing, 1.0).m33 - 0.625).abs() < 0.02);
}

#[test]
fn what_is_new_is_stated_as_it_is() {
    let (old, new) = (0.02, 0.05);
    let mut consistency = Consistency { tilt: 0.1, heading: 0.3, turning: 1.0 };
    consistency.note_added([new / (old + new); 2]);
    let stated = consistency.stated(&Matrix3::from_diagonal_element(old + new), 0.0);
    assert!((stated.m11 - (0.1 * old + new)).abs() < 1e-6 && (stated.m33 - (0.3 * old + new)).abs() < 1e-6, "{stated}");
    consistency.note_added([f32::NAN, f32::NAN]);
    assert_eq!(consistency.stated(&Matrix3::identity(), 0.0), Matrix3::identity());
    let mut larger = Consistency { tilt: 2.0, ..Consistency::new() };
    larger.note_added([0.5; 2]);
    assert_eq!(larger.tilt, 2.0);
}
