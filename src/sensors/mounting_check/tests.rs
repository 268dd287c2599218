//! Probes turned by hand, with sensors that are mounted wrong, and tools that drill.

extern crate std;

use super::*;
use crate::units::STANDARD_GRAVITY_M_S2;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

const EVERY: TurnFlags = TurnFlags::all();
const BY_MAG: TurnFlags = TurnFlags::X_BY_MAG.union(TurnFlags::Y_BY_MAG).union(TurnFlags::Z_BY_MAG);
const FIELD_UT: [f32; 3] = [20.0, 4.0, 42.0];

/// A probe that is turned by hand about one body axis after another, there and most of the way back, at 100 Hz: noise
/// and bias of a data sheet, and accelerations of the hand. It starts anywhere.
fn by_hand(seed: u64, axes: &[usize]) -> Vec<Sample> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut uniform = || random.next_u32() as f32 / u32::MAX as f32 - 0.5;
    let mut vector = |size: f32| Vector3::new(uniform(), uniform(), uniform()) * size;
    let bias = vector(0.2);
    let start = nalgebra::Rotation3::new(vector(6.0));
    let mut body_to_earth = start;
    let mut samples = Vec::new();
    let mut t_us = 0;
    for axis in axes.iter().flat_map(|axis| [*axis; 2]) {
        for k in 0..400 {
            t_us += 10_000;
            let swing = 2.0 * libm::sinf(core::f32::consts::TAU * k as f32 / 400.0) + 0.2;
            let rate = Vector3::ith(axis, swing) + vector(0.3);
            body_to_earth *= nalgebra::Rotation3::new(rate * 0.01);
            let force = body_to_earth.inverse() * Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_S2) + vector(3.0);
            let field = body_to_earth.inverse() * Vector3::from(FIELD_UT) + vector(1.0);
            samples.push(Sample {
                t_us,
                gyro_rad_s: (rate + bias + vector(0.01)).into(),
                accel_m_s2: force.into(),
                mag_ut: field.into(),
                temperature_c: 25.0,
                flags: SampleFlags::empty(),
            });
        }
    }
    samples
}

fn checked(samples: impl IntoIterator<Item = Sample>) -> MountingCheck {
    let mut check = MountingCheck::new();
    samples.into_iter().for_each(|sample| {
        check.update(&sample, [0.0; 3]);
    });
    check
}

fn with(samples: &[Sample], change: impl Fn(&mut Sample)) -> MountingCheck {
    checked(samples.iter().map(|sample| {
        let mut sample = *sample;
        change(&mut sample);
        sample
    }))
}

#[test]
fn turns_about_all_axes_agree_where_all_is_well_and_name_what_is_wrong() {
    for seed in 0..20 {
        let samples = by_hand(seed, &[0, 1, 2, 0, 1, 2]);
        let [x, y, z] = [
            TurnFlags::X_BY_ACCEL | TurnFlags::X_BY_MAG,
            TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG,
            TurnFlags::Z_BY_ACCEL | TurnFlags::Z_BY_MAG,
        ];
        let well = checked(samples.iter().copied());
        assert_eq!((well.seen(), well.wrong()), (EVERY, TurnFlags::empty()), "seed {seed} {:?}", well.columns());
        let wrong = |change: fn(&mut Sample)| with(&samples, change).wrong();
        assert_eq!(wrong(|sample| sample.gyro_rad_s[1] *= -1.0), y, "seed {seed}");
        assert_eq!(
            wrong(|sample| sample.accel_m_s2[2] *= -1.0),
            TurnFlags::X_BY_ACCEL | TurnFlags::Y_BY_ACCEL,
            "seed {seed}"
        );
        assert_eq!(wrong(|sample| sample.mag_ut[0] *= -1.0), TurnFlags::Y_BY_MAG | TurnFlags::Z_BY_MAG, "seed {seed}");
        assert_eq!(wrong(|sample| sample.gyro_rad_s.swap(0, 2)), x | z, "seed {seed}");
        assert_eq!(wrong(|sample| sample.mag_ut.swap(0, 1)), (x | y | z) & BY_MAG, "seed {seed}");
        // A full scale that is wrong by two, on a probe that takes twice the time for the same turns and on this one.
        assert_eq!(wrong(|sample| sample.t_us *= 2), EVERY, "seed {seed}");
        assert_eq!(wrong(|sample| sample.gyro_rad_s = sample.gyro_rad_s.map(|x| 0.5 * x)), EVERY, "seed {seed}");
        let tenth = wrong(|sample| sample.gyro_rad_s = sample.gyro_rad_s.map(|x| 1.1 * x));
        assert_eq!(tenth, TurnFlags::empty(), "seed {seed}");
        // In degrees a second.
        let degrees = with(&samples, |sample| sample.gyro_rad_s = sample.gyro_rad_s.map(f32::to_degrees));
        assert_eq!(degrees.wrong(), EVERY, "seed {seed}");
    }
}

#[test]
fn an_axis_about_which_nothing_turned_is_not_judged() {
    for seed in 0..20 {
        let about_z = checked(
            by_hand(seed, &[2])
                .into_iter()
                .map(|sample| Sample { gyro_rad_s: [0.1, -0.05, sample.gyro_rad_s[2]], ..sample }),
        );
        assert_eq!(about_z.wrong(), TurnFlags::empty(), "seed {seed}: {:?}", about_z.columns());
        assert!((about_z.seen() - TurnFlags::Z_BY_ACCEL - TurnFlags::Z_BY_MAG).is_empty());
    }
    let samples = by_hand(1, &[0, 1, 2, 0, 1, 2]);
    let slower = with(&samples, |sample| {
        sample.flags.set(SampleFlags::MAG_MISSING, sample.t_us % 40_000 != 0);
    });
    assert_eq!((slower.seen(), slower.wrong()), (EVERY, TurnFlags::empty()));
    let without = with(&samples, |sample| sample.flags = SampleFlags::MAG_MISSING);
    assert!(!without.seen().intersects(TurnFlags::X_BY_MAG | TurnFlags::Y_BY_MAG | TurnFlags::Z_BY_MAG));
    assert_eq!(without.norms()[1], None);
    assert_eq!(with(&samples, |sample| sample.flags = SampleFlags::GYRO_MISSING).seen(), TurnFlags::empty());
}

/// A gyro with a large bias, an hour at rest: nothing is judged, and gravity and field are as they are.
#[test]
fn rest_is_no_turn() {
    let at_rest = by_hand(3, &[0]).into_iter().cycle().take(360_000).enumerate().map(|(k, sample)| Sample {
        t_us: 10_000 * (k as u64 + 1),
        gyro_rad_s: [0.17 + 0.1 * (sample.mag_ut[0] % 0.1), -0.1, 0.05],
        accel_m_s2: [3.0, 4.0, -8.43],
        mag_ut: [20.0, 4.0, 42.0 + 0.01 * (k % 7) as f32],
        ..sample
    });
    let check = checked(at_rest);
    assert_eq!(check.seen(), TurnFlags::empty(), "{:?}", check.columns());
    let [gravity, field] = check.norms().map(Option::unwrap);
    assert!((gravity - 9.80).abs() < 0.02 && (field - 46.7).abs() < 0.1, "{gravity} {field}");
}

/// A tool in a vertical hole, slowly and at speed, with an accelerometer off the axis and with a bias.
#[test]
fn drilling_makes_no_wrong_axis() {
    for (rate_rad_s, inclination_rad) in [(2.0, 0.0), (2.9, 0.02), (5.0, 0.0), (12.0, 0.1), (2.5, 0.7)] {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(9);
        let mut noise = move |size: f32| size * (random.next_u32() as f32 / u32::MAX as f32 - 0.5);
        let drilling = (1..60_000_u32).map(|k| {
            let swing = libm::sinf(k as f32 * 0.02);
            let angle = rate_rad_s * (k as f32 * 0.01 - 0.25 * libm::cosf(k as f32 * 0.02));
            let body_to_earth = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), inclination_rad)
                * nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
            let rate = rate_rad_s * (1.0 + 0.5 * swing);
            let mut vector = |v: Vector3<f32>, size: f32| v + Vector3::new(noise(size), noise(size), noise(size));
            let felt = Vector3::new(0.2 - 0.02 * rate * rate, 0.1, 0.0);
            let force = body_to_earth.inverse() * Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_S2) + felt;
            Sample {
                t_us: 10_000 * u64::from(k),
                gyro_rad_s: vector(Vector3::new(0.02, -0.01, rate), 0.01).into(),
                accel_m_s2: vector(force, 3.0).into(),
                mag_ut: vector(body_to_earth.inverse() * Vector3::from(FIELD_UT), 1.0).into(),
                temperature_c: 25.0,
                flags: SampleFlags::empty(),
            }
        });
        let check = checked(drilling);
        assert_eq!(check.wrong(), TurnFlags::empty(), "{rate_rad_s} {inclination_rad}: {:?}", check.columns());
    }
}

#[test]
fn nothing_makes_it_panic_or_keep_a_nan() {
    let mut samples = by_hand(5, &[0, 1, 2]);
    for (k, sample) in samples.iter_mut().enumerate() {
        match k % 50 {
            7 => sample.gyro_rad_s[0] = f32::NAN,
            19 => sample.accel_m_s2[1] = f32::INFINITY,
            31 => sample.t_us = 0,
            _ => {}
        }
    }
    let check = checked(samples);
    assert!(check.columns().iter().flatten().flatten().flatten().flatten().all(|factor| factor.is_finite()));
}

/// A probe that hangs and swings, its sensors 0.6 m under the rope's end: the acceleration takes 0.6 of gravity's turn
/// away, in step with the gyro.
#[test]
fn a_probe_that_swings_is_not_called_wrong() {
    for amplitude_rad in [0.1, 0.2, 0.26] {
        let swing = (1..6_000_u32).map(|k| {
            let (t_s, pulse) = (0.01 * k as f32, core::f32::consts::PI);
            let (sine, cosine) = libm::sincosf(pulse * t_s);
            let [angle, rate, change] =
                [amplitude_rad * sine, amplitude_rad * pulse * cosine, -amplitude_rad * pulse * pulse * sine];
            let body_to_earth = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
            let acceleration = Vector3::new(0.6 * change, 0.0, -0.6 * rate * rate);
            let force = acceleration + body_to_earth.inverse() * Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_S2);
            Sample {
                t_us: 10_000 * u64::from(k),
                gyro_rad_s: [0.0, rate, 0.0],
                accel_m_s2: force.into(),
                mag_ut: (body_to_earth.inverse() * Vector3::from(FIELD_UT)).into(),
                temperature_c: 25.0,
                flags: SampleFlags::empty(),
            }
        });
        let check = checked(swing);
        assert_eq!(check.wrong(), TurnFlags::empty(), "{amplitude_rad}: {:?}", check.columns());
    }
}

#[test]
fn ten_minutes_without_a_turn_forget_those_before() {
    let mut samples = by_hand(7, &[0, 1, 2]);
    samples.iter_mut().for_each(|sample| sample.gyro_rad_s[1] *= -1.0);
    let at_rest = Sample { gyro_rad_s: [0.0; 3], ..samples[samples.len() - 1] };
    let mut check = checked(samples.iter().copied());
    let mut last_wrong_s = 0;
    for k in 1..70_000 {
        check.update(&Sample { t_us: at_rest.t_us + 10_000 * k, ..at_rest }, [0.0; 3]);
        if check.wrong() == TurnFlags::Y_BY_ACCEL | TurnFlags::Y_BY_MAG {
            last_wrong_s = k / 100;
        }
    }
    assert!((599..=602).contains(&last_wrong_s) && check.seen().is_empty(), "{last_wrong_s}");
}

/// Hard iron of a third of the field, a gyro with cross-axis errors and a late magnetometer, at rates that are judged.
#[test]
fn iron_lag_and_cross_axis_errors_make_no_wrong_axis() {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(21);
    let mut uniform = move |size: f32| size * (random.next_u32() as f32 / u32::MAX as f32 - 0.5);
    for run in 0..60 {
        let (mean, inclination_rad, dip_rad) = (1.6 + uniform(2.0), 0.4 + uniform(0.8), uniform(2.6));
        let iron = Vector3::new(uniform(1.0), uniform(1.0), uniform(1.0)).normalize() * 12.0;
        let errors = Matrix3::from_fn(|_, _| uniform(0.1));
        let field = Vector3::new(40.0 * libm::cosf(dip_rad), 0.0, 40.0 * libm::sinf(dip_rad));
        let (lag_s, wobble) = (0.015, 0.02);
        let at = |t: f32| {
            let angle = mean * (t - 1.9 * libm::cosf(0.5 * t));
            let tilt = nalgebra::Rotation3::new(Vector3::new(libm::sinf(1.3 * t), libm::cosf(1.7 * t), 0.0) * wobble);
            nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), inclination_rad)
                * tilt
                * nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), angle)
        };
        let drilling: Vec<Sample> = (1..30_000_u32)
            .map(|k| {
                let t = 0.01 * k as f32;
                let rate = (at(t).inverse() * at(t + 0.01)).scaled_axis() / 0.01;
                let mut noise = |size: f32| Vector3::new(uniform(size), uniform(size), uniform(size));
                Sample {
                    t_us: 10_000 * u64::from(k),
                    gyro_rad_s: (rate + errors * rate + noise(0.01)).into(),
                    accel_m_s2: (at(t).inverse() * Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_S2) + noise(6.0)).into(),
                    mag_ut: (at(t - lag_s).inverse() * field + iron + noise(1.0)).into(),
                    temperature_c: 25.0,
                    flags: SampleFlags::empty(),
                }
            })
            .collect();
        let check = checked(drilling);
        assert_eq!(
            check.wrong(),
            TurnFlags::empty(),
            "{run}: {mean} {inclination_rad} {dip_rad} {:?}",
            check.columns()
        );
    }
}
