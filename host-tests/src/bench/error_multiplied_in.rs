//! The gyro error that is multiplied into a recording.

use meerkat_mwd::compensation::GyroModel;

use testbed::simulate::Random;

/// Largest deviation of P's diagonal from 1 at scale 1.
const DIAGONAL: f64 = 0.10;

/// Largest off-diagonal of P at scale 1.
const OFF_DIAGONAL: f64 = 0.05;

/// Largest bias of an axis at scale 1, deg/s.
const BIAS_DEG_S: f64 = 2.0;

/// Draws P and b, uniform within their bounds times `scale`. All scales share a draw: half the scale is half
/// of the same error.
pub(crate) fn drawn(name: &str, draw: u64, scale: f64) -> GyroModel {
    let mut random = Random::new(seed(name, draw));
    let mut within = |bound: f64| scale * random.between(-bound, bound);
    let p = std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let element = if row == column { 1.0 + within(DIAGONAL) } else { within(OFF_DIAGONAL) };
            element as f32
        })
    });
    GyroModel { p, b_rad_s: std::array::from_fn(|_| within(BIAS_DEG_S).to_radians() as f32) }
}

/// Seed of a name and a draw, the same on every machine: FNV-1a of 64 bits (draft-eastlake-fnv).
fn seed(name: &str, draw: u64) -> u64 {
    let bytes = name.bytes().chain(draw.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_draws_differ_and_scales_do_not_but_in_size() {
        let whole = drawn("a", 0, 1.0);
        assert_eq!(whole, drawn("a", 0, 1.0));
        assert_ne!(whole, drawn("a", 1, 1.0));
        assert_ne!(whole, drawn("b", 0, 1.0));
        assert_eq!(drawn("a", 0, 0.0), GyroModel::IDENTITY);
        let tenth = drawn("a", 0, 0.1);
        assert!((0.1 * (whole.p[0][0] - 1.0) - (tenth.p[0][0] - 1.0)).abs() < 1e-6);
        assert!((0.1 * whole.p[2][1] - tenth.p[2][1]).abs() < 1e-8);
        assert!((0.1 * whole.b_rad_s[1] - tenth.b_rad_s[1]).abs() < 1e-8);
    }

    #[test]
    fn every_element_stays_within_its_bound_and_comes_near_it() {
        let drawn: Vec<GyroModel> = (0..200).map(|draw| drawn("a", draw, 0.3)).collect();
        let largest =
            |of: &dyn Fn(&GyroModel) -> f32| drawn.iter().map(|model| f64::from(of(model).abs())).fold(0.0, f64::max);
        for (found, bound) in [
            (largest(&|model| model.p[1][1] - 1.0), 0.03),
            (largest(&|model| model.p[0][2]), 0.015),
            (largest(&|model| model.b_rad_s[2].to_degrees()), 0.6),
        ] {
            assert!(found <= bound + 1e-6 && found > 0.95 * bound, "{found} {bound}");
        }
    }
}
