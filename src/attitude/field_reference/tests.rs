//! The reference of the field: what enters it, and what does not.

use super::*;

const DT_S: f32 = 0.02;

fn declared() -> Earth {
    Earth { magnetic_field_ut: Some(50.0), dip_rad: Some(1.2), ..Earth::default() }
}

fn run(reference: &mut FieldReference, norm_ut: f32, rate_rad_s: f32, seconds: u16) -> (u32, Option<f32>) {
    let (mut used, mut last) = (0, None);
    for _ in 0..seconds * 50 {
        let with = (&AttitudeConfig::default(), &declared());
        last = reference.compare([norm_ut, 1.2], rate_rad_s, DT_S, 0.0, with);
        used += u32::from(last.is_some());
    }
    (used, last)
}

#[test]
fn a_disturbance_is_refused_and_its_end_is_noticed() {
    let mut reference = FieldReference::new();
    assert_eq!(run(&mut reference, 50.0, 0.0, 5).0, 250);
    let (used, last) = run(&mut reference, 60.0, 0.0, 60);
    assert!(used < 5 && last.is_none());
    let (used, last) = run(&mut reference, 50.0, 0.0, 5);
    assert!(used > 200 && last.is_some_and(|d| d < 1e-4));
}

#[test]
fn a_new_field_that_stays_becomes_the_reference_sooner_when_it_stays_through_turns() {
    for (rate, refused_s, accepted_s) in [(1.0, 19, 3), (0.0, 115, 10)] {
        let mut reference = FieldReference::start(&declared());
        assert!(run(&mut reference, 70.0, rate, refused_s).1.is_none());
        assert!(run(&mut reference, 70.0, rate, accepted_s).1.is_some());
    }
}

#[test]
fn a_dip_that_an_uncertain_tilt_explains_is_no_disturbance_and_makes_the_field_no_less_certain() {
    let config = AttitudeConfig::default();
    for (sigma_rad, used) in [(0.0_f32, false), (0.02, false), (0.3, true)] {
        let mut reference = FieldReference::new();
        assert_eq!(run(&mut reference, 50.0, 0.0, 5).0, 250);
        let mut last = None;
        for _ in 0..50 {
            last = reference.compare([50.0, 1.45], 0.0, DT_S, sigma_rad * sigma_rad, (&config, &declared()));
        }
        assert_eq!(last.is_some_and(|deviation| deviation < 1e-6), used, "{sigma_rad} {last:?}");
    }
}

/// A field that grows by 8 % in a minute, as beside casing.
#[test]
fn a_field_that_comes_slowly_stays_a_deviation_from_the_declared_one() {
    let deviation = |mut reference: FieldReference| {
        let last = (0..60_u8).map(|k| run(&mut reference, 50.0 + 4.0 * f32::from(k) / 60.0, 0.0, 1).1).last();
        run(&mut reference, 54.0, 0.0, 60).1.filter(|_| last.is_some()).map(libm::sqrtf).unwrap()
    };
    let [declared, learnt] = [FieldReference::start(&declared()), FieldReference::new()].map(deviation);
    assert!((declared - 0.08).abs() < 0.002 && learnt < 0.02, "{declared} {learnt}");
}
