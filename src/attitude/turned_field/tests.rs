//! Noise, and a field that turns by more than the gyro measures.

use super::*;
use crate::rotation::exp_quaternion;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const FIELD_UT: Vector3<f32> = Vector3::new(20.0, 1.0, 45.0);
const STEP_S: f32 = 0.01;

/// Nearly normal noise with this deviation on each axis, microtesla.
fn noisy(random: &mut Xoshiro128PlusPlus, sigma_ut: f32) -> Vector3<f32> {
    let mut normal = || (0..12).map(|_| (random.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5).sum::<f32>();
    Vector3::new(normal(), normal(), normal()) * sigma_ut
}

/// Takes a field that was read so long after the one before.
fn seen(turned: &mut TurnedField, field_ut: &Vector3<f32>, after_s: f32) -> bool {
    // Nine samples without a field.
    (0..10).for_each(|_| turned.pass(0.1 * after_s));
    turned.update(field_ut)
}

/// A detector that agrees with a noisy field.
fn settled(random: &mut Xoshiro128PlusPlus, sigma_ut: f32) -> TurnedField {
    let mut turned = TurnedField::new();
    for _ in 0..2_000 {
        seen(&mut turned, &(FIELD_UT + noisy(random, sigma_ut)), STEP_S);
        turned.agree(&FIELD_UT);
    }
    turned
}

#[test]
fn noise_is_in_doubt_once_in_a_thousand_whatever_its_size() {
    for sigma_ut in [0.1, 1.0] {
        let random = &mut Xoshiro128PlusPlus::seed_from_u64(5);
        let mut turned = settled(random, sigma_ut);
        let doubted = (0..100_000).filter(|_| seen(&mut turned, &(FIELD_UT + noisy(random, sigma_ut)), STEP_S)).count();
        assert!((20..400).contains(&doubted), "{doubted} of 100,000");
    }
}

#[test]
fn a_turn_is_in_doubt_by_its_own_angle_from_the_first_reading_and_no_longer_than_it_lasts() {
    let random = &mut Xoshiro128PlusPlus::seed_from_u64(6);
    let mut turned = settled(random, 0.2);
    let (angle_rad, axis) = (0.1_f32, FIELD_UT.cross(&Vector3::x()).normalize());
    let rotation = nalgebra::UnitQuaternion::new_normalize(exp_quaternion(&(axis * angle_rad)));
    assert!(seen(&mut turned, &(rotation * FIELD_UT), STEP_S));
    assert!((libm::sqrtf(turned.doubt()) / angle_rad - 1.0).abs() < 0.02, "{}", turned.doubt());
    turned.doubt_at_least(0.04);
    assert!((libm::sqrtf(turned.doubt()) - 0.2).abs() < 1e-4);
    assert!(!seen(&mut turned, &FIELD_UT, STEP_S) && turned.doubt() == 0.0);
}

#[test]
fn before_any_field_has_agreed_nothing_is_in_doubt() {
    let mut turned = TurnedField::new();
    seen(&mut turned, &(FIELD_UT * 100.0), STEP_S);
    turned.doubt_at_least(1.0);
    assert_eq!(turned.doubt(), 0.0);
}

/// Twelve seconds of a field that is read at 100, 10 and 5 Hz.
#[test]
fn the_noise_is_known_after_seconds_however_often_the_field_is_read() {
    for after_s in [0.01, 0.1, 0.2_f32] {
        let random = &mut Xoshiro128PlusPlus::seed_from_u64(7);
        let mut turned = TurnedField::new();
        for _ in 0..libm::roundf(12.0 / after_s) as u16 {
            seen(&mut turned, &(FIELD_UT + noisy(random, 0.2)), after_s);
            turned.agree(&FIELD_UT);
        }
        let axis = FIELD_UT.cross(&Vector3::x()).normalize();
        let rotation = nalgebra::UnitQuaternion::new_normalize(exp_quaternion(&(axis * 0.3)));
        assert!(seen(&mut turned, &(rotation * FIELD_UT), after_s), "{after_s}");
    }
}
