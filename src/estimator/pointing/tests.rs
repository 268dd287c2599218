//! Axes that swing, turn with the hole, or go round with the tool.

extern crate std;

use super::*;
use crate::estimator::real::{V3, rotation};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Attitudes of a tool that turns about its axis, which swings by so much. They are known to a hundredth, but for
/// two after a gap.
fn turning(swing_rad: f64, new_heading: bool) -> [bool; 3] {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
    let mut pointing = Pointing::<f64>::zero();
    for k in 0..400 {
        let time = f64::from(k);
        let error = if k == 90 || k == 91 { 0.5 } else { 0.01 };
        let noise = V3::new(uniform(), uniform(), uniform()) * error;
        let swing = V3::new(0.6 + swing_rad * libm::sin(0.1 * time), 0.0, 0.0);
        let heading = if new_heading && k >= 200 { 2.0 } else { 0.0 };
        if new_heading && k == 200 {
            pointing.turn_anew();
        }
        let about_the_axis = rotation(&V3::new(0.0, 0.0, 1.3 * time));
        let attitude = rotation(&V3::new(0.0, 0.0, heading)) * rotation(&noise) * rotation(&swing) * about_the_axis;
        pointing.add(&attitude, error * error);
    }
    pointing.hides()
}

#[test]
fn an_axis_that_points_one_way_hides_and_one_that_swings_by_more_than_the_attitude_errs_does_not() {
    assert_eq!(turning(0.0, false), [false, false, true]);
    assert_eq!(turning(0.01, false), [false, false, true]);
    assert_eq!(turning(0.05, false), [false, false, false]);
}

/// The body's axes are those of the sensors: that about which the tool turns is none of them, but fixed among them.
#[test]
fn an_axis_that_goes_round_with_the_tool_hides() {
    let mut pointing = Pointing::<f64>::zero();
    let tilt = rotation(&V3::new(0.02, 0.03, 0.0));
    for k in 0..400 {
        let turned = rotation(&V3::new(0.6, 0.0, 0.0)) * rotation(&V3::new(0.0, 0.0, 1.3 * f64::from(k))) * tilt;
        pointing.add(&turned, 1e-4);
    }
    assert_eq!(pointing.hides(), [false, false, true]);
}

#[test]
fn an_axis_that_turns_with_the_hole_hides() {
    let mut pointing = Pointing::<f64>::zero();
    for k in 0..8_000 {
        let time = f64::from(k);
        let (hole, tool) = (V3::new(0.6 + 5e-5 * time, 0.0, 0.0), V3::new(0.0, 0.0, 1.3 * time));
        pointing.add(&(rotation(&hole) * rotation(&tool)), 1e-4);
    }
    assert_eq!(pointing.hides(), [false, false, true]);
}

#[test]
fn some_nodes_with_a_wrong_attitude_are_no_turn() {
    let mut pointing = Pointing::<f64>::zero();
    for k in 0..400 {
        let wrong = if (200..210).contains(&k) { 0.5 } else { 0.0 };
        let turned = rotation(&V3::new(0.6 + wrong, 0.0, 0.0)) * rotation(&V3::new(0.0, 0.0, 1.3 * f64::from(k)));
        pointing.add(&turned, 1e-4);
    }
    assert_eq!(pointing.hides(), [false, false, true]);
}

#[test]
fn a_new_heading_is_no_turn() {
    assert_eq!(turning(0.0, true), [false, false, true]);
    assert_eq!(turning(0.05, true), [false, false, false]);
}

#[test]
fn before_any_node_all_are_hidden() {
    assert_eq!(Pointing::<f32>::zero().hides(), [true; 3]);
}
