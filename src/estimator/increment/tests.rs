//! What was not read makes an increment uncertain.

use super::*;
use crate::compensation::GyroModel;

/// Sum over the increments of a steady turn at 100 Hz, in which one rate is read as told: variance of the turn, rad^2.
fn unread_turn(rate_rad_s: f32, told: Reading) -> f64 {
    let with = Composition::<f64>::new(&GyroModel::IDENTITY).unwrap();
    let mut builder = Builder::<f64>::zero();
    builder.start(0.01, false);
    let usable = |v: [f32; 3]| Reading::Usable(v.into());
    (0..100_u64)
        .filter_map(|k| {
            let rate = if k == 50 { told } else { usable([0.0, 0.0, rate_rad_s]) };
            let vectors = [usable([0.0, 0.0, -9.8]), usable([20.0, 0.0, 40.0])];
            builder.push((k * 10_000, 0.01), &with, [rate, vectors[0], vectors[1]])
        })
        .map(|item| match item {
            Item::Increment(increment) => increment.unread_turn,
            other => panic!("{other:?}"),
        })
        .sum()
}

#[test]
fn a_rate_beyond_the_full_scale_is_uncertain_by_itself_and_a_lost_one_by_less() {
    for rate_rad_s in [0.3, 2.0, 8.7] {
        let read = unread_turn(rate_rad_s, Reading::Usable([0.0, 0.0, rate_rad_s].into()));
        let lost = unread_turn(rate_rad_s, Reading::Missing);
        let clipped = unread_turn(rate_rad_s, Reading::Unusable);
        let turn = f64::from(rate_rad_s) * 0.01;
        assert!(read == 0.0 && lost < 0.1 * clipped + 1e-5, "{rate_rad_s}: {read} {lost} {clipped}");
        assert!((clipped / (turn * turn) - 1.0).abs() < 0.1, "{rate_rad_s}: {clipped}");
    }
}
