//! Vectors turned to the gyro's time, against an integration in double precision.

use super::*;
use crate::rotation::{exp_quaternion, rotate_back};
use nalgebra::UnitQuaternion;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn a_vector_is_turned_as_the_body_turns() {
    let (v, turn) = (Vector3::new(20.0, -5.0, 45.0), Vector3::new(0.09, -0.12, 0.0));
    let exact = rotate_back(&exp_quaternion(&turn), &v);
    assert!((later(&v, &turn) - exact).norm() < 6e-4 * v.norm());
}

/// Rates, accelerations and delays of either sign, with turns up to 0.15 rad.
#[test]
fn a_reading_is_turned_over_its_delay_while_the_rate_changes() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut vector =
        |most: f64| Vector3::from_fn(|_, _| (f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0) * most);
    const STEPS: u16 = 400;
    for _ in 0..200 {
        let (rate, acceleration, v, behind_s) = (vector(8.0), vector(100.0), vector(50.0), vector(0.01).x);
        let mut turned = UnitQuaternion::<f64>::identity();
        let dt_s = behind_s / f64::from(STEPS);
        for k in 0..STEPS {
            // Time until the gyro's, from the middle of the step.
            let left_s = behind_s - (f64::from(k) + 0.5) * dt_s;
            turned *= UnitQuaternion::from_scaled_axis((rate - acceleration * left_s) * dt_s);
        }
        let exact = turned.inverse_transform_vector(&v).cast::<f32>();
        let reading = Reading::Usable(v.cast());
        let found = at_gyro_time(reading, behind_s as f32, &rate.cast(), &acceleration.cast());
        let Reading::Usable(found) = found else { panic!("{found:?}") };
        assert!((found - exact).norm() < 7e-4 * exact.norm(), "{rate} {acceleration} {behind_s}: {found} {exact}");
    }
    let missing = at_gyro_time(Reading::Missing, 0.01, &Vector3::zeros(), &Vector3::zeros());
    assert_eq!(missing, Reading::Missing);
}
