//! Bad input leaves a finite attitude, honest flags and a filter that recovers.

use crate::simulation::{Noise, Truth, apart, feed, sound};
use meerkat_mwd::{
    attitude::{Attitude, AttitudeFilter, AttitudeFlags},
    compensation::GyroModel,
    config::{AttitudeConfig, Earth, Motion},
};
use nalgebra::Vector3;
use std::f64::consts::PI;

const DT_S: f64 = 0.005;
const STILL: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);

/// A still probe whose sensors may be made to lie.
struct Bench {
    filter: AttitudeFilter,
    truth: Truth,
    noise: Noise,
}

impl Bench {
    fn new(earth: &Earth) -> Self {
        let mut filter = AttitudeFilter::new();
        filter.start(&AttitudeConfig::default(), earth, Motion::DrillString);
        Self { filter, truth: Truth::at(70.0, 40.0, 20.0), noise: Noise::new(3) }
    }

    /// Runs for some seconds, checks every attitude and returns the last one.
    fn run(
        &mut self,
        seconds: f64,
        rate: Vector3<f64>,
        force: impl Fn(Vector3<f64>) -> Option<Vector3<f64>>,
        field: impl Fn(Vector3<f64>) -> Option<Vector3<f64>>,
    ) -> Option<Attitude> {
        let mut last = None;
        for _ in 0..(seconds / DT_S) as u32 {
            self.truth.turn(&rate, DT_S);
            let reading = rate + self.noise.vector() * 0.002;
            let accel = self.truth.force(&STILL) + self.noise.vector() * 0.02;
            let mag = self.truth.field(65.0, 0.0) + self.noise.vector() * 0.2;
            last = feed(&mut self.filter, DT_S, &reading, force(accel), field(mag));
            assert!(last.as_ref().is_none_or(sound), "{last:?}");
        }
        last
    }

    fn azimuth_error_deg(&self, a: &Attitude) -> f64 {
        apart(a.azimuth_rad.into(), self.truth.azimuth_rad()).abs().to_degrees()
    }
}

#[test]
fn without_a_specific_force_there_is_no_attitude() {
    let mut bench = Bench::new(&Earth::default());
    assert_eq!(bench.run(2.0, STILL, |_| None, Some), None);
    assert_eq!(bench.run(2.0, STILL, |_| Some(STILL), Some), None, "free fall from the start");
    assert!(bench.run(0.01, STILL, Some, Some).is_some());
}

#[test]
fn without_a_magnetometer_heading_starts_at_zero_and_says_that_it_is_unknown() {
    for field in [None, Some(STILL)] {
        let mut bench = Bench::new(&Earth::default());
        let first = bench.run(DT_S, STILL, Some, |_| field).unwrap();
        assert!(apart(first.azimuth_rad.into(), 0.0).abs() < 1e-3);
        let a = bench.run(60.0, STILL, Some, |_| field).unwrap();
        assert!(a.flags.contains(AttitudeFlags::NO_HEADING | AttitudeFlags::MAG_UNUSED));
        assert!(a.sigma_azimuth_rad > 3.0 && a.sigma_inclination_rad < 0.02);
        assert!(apart(a.azimuth_rad.into(), 0.0).abs().to_degrees() < 0.5, "at rest the bias is known: {a:?}");
        assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 0.2);
        // The field returns.
        let a = bench.run(3.0, STILL, Some, Some).unwrap();
        assert!(bench.azimuth_error_deg(&a) < 1.0 && !a.flags.contains(AttitudeFlags::NO_HEADING));
    }
}

#[test]
fn a_minute_without_accelerometer_widens_the_tilt_and_ends_well() {
    let mut bench = Bench::new(&Earth::default());
    let before = bench.run(10.0, STILL, Some, Some).unwrap();
    let turning = Vector3::new(0.1, -0.05, 0.2);
    let a = bench.run(60.0, turning, |_| None, Some).unwrap();
    assert!(a.flags.contains(AttitudeFlags::ACCEL_UNUSED));
    assert!(a.sigma_inclination_rad > 1.2 * before.sigma_inclination_rad);
    assert!(bench.truth.tilt_error_rad(&a) < 4.0 * f64::from(a.sigma_inclination_rad));
    let a = bench.run(20.0, turning, Some, Some).unwrap();
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 0.3 && !a.flags.contains(AttitudeFlags::ACCEL_UNUSED));
}

#[test]
fn free_fall_is_not_taken_for_a_tilt() {
    let mut bench = Bench::new(&Earth::default());
    bench.run(10.0, STILL, Some, Some);
    let a = bench.run(20.0, STILL, |_| Some(STILL), Some).unwrap();
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 1.0);
}

#[test]
fn dead_axes_and_swapped_signs_stay_finite() {
    type Lie = fn(Vector3<f64>) -> Option<Vector3<f64>>;
    let lies: [Lie; 6] = [
        |v| Some(Vector3::new(0.0, v.y, v.z)),
        |v| Some(Vector3::new(v.x, v.y, 0.0)),
        |v| Some(-v),
        |v| Some(Vector3::new(v.y, v.x, v.z)),
        |v| Some(v * 1e30),
        |_| Some(Vector3::new(157.0, 157.0, 157.0)),
    ];
    for (which, lie) in lies.into_iter().enumerate() {
        for turning in [STILL, Vector3::new(0.5, 1.0, -2.0)] {
            Bench::new(&Earth::default()).run(20.0, turning, lie, Some);
            Bench::new(&Earth::default()).run(20.0, turning, Some, lie);
            let mut bench = Bench::new(&Earth::default());
            bench.run(5.0, turning, Some, Some);
            bench.run(20.0, turning, lie, lie);
            let a = bench.run(40.0, turning, Some, Some).unwrap();
            assert!(
                bench.truth.tilt_error_rad(&a).to_degrees() < 2.0,
                "recovers from lie {which}: {a:?} {:?}",
                bench.filter.residual_bias_rad_s()
            );
        }
    }
}

#[test]
fn absurd_rates_make_the_attitude_unknown_and_gravity_and_field_bring_it_back() {
    let mut bench = Bench::new(&Earth::default());
    bench.run(5.0, STILL, Some, Some);
    for rate in [1e38, 1e30, 2e3, -1e20] {
        let a = feed(&mut bench.filter, DT_S, &Vector3::new(rate, 0.0, -rate), None, None).unwrap();
        assert!(sound(&a) && a.sigma_inclination_rad > 1.0);
    }
    let a = bench.run(20.0, STILL, Some, Some).unwrap();
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 0.5 && bench.azimuth_error_deg(&a) < 2.0);
}

#[test]
fn a_gap_is_flagged_once_widens_the_sigmas_and_is_healed() {
    let mut bench = Bench::new(&Earth::default());
    let turning = Vector3::new(0.2, 0.1, 1.0);
    let before = bench.run(10.0, turning, Some, Some).unwrap();
    // Three seconds of motion that the gyro does not see.
    (0..600).for_each(|_| bench.truth.turn(&(turning * 1.2), DT_S));
    bench.filter.gap(3.0);
    let a = bench.filter.attitude(AttitudeFlags::empty()).unwrap();
    assert!(a.flags.contains(AttitudeFlags::AFTER_GAP) && a.sigma_azimuth_rad > 1.0);
    assert!(a.q.iter().zip(&before.q).all(|(x, y)| x == y), "kept across the gap");
    let a = bench.run(3.0, turning, Some, Some).unwrap();
    assert!(!a.flags.contains(AttitudeFlags::AFTER_GAP));
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 1.0 && bench.azimuth_error_deg(&a) < 2.0, "{a:?}");
}

/// A filter that has found a bias at rest.
fn with_bias(bias: &Vector3<f64>) -> Bench {
    let mut bench = Bench::new(&Earth::default());
    for _ in 0..6_000 {
        feed(&mut bench.filter, DT_S, bias, Some(bench.truth.force(&STILL)), Some(bench.truth.field(65.0, 0.0)));
    }
    assert!((bench.filter.residual_bias_rad_s().cast::<f64>() - bias).norm() < 5e-4);
    bench
}

#[test]
fn another_bias_in_the_model_moves_neither_the_attitude_nor_the_total_bias() {
    let bias = Vector3::new(0.004, -0.003, 0.005);
    let mut bench = with_bias(&bias);
    let before = bench.filter.attitude(AttitudeFlags::empty()).unwrap();
    let old = GyroModel { p: [[1.1, 0.0, 0.02], [0.0, 0.9, 0.0], [0.01, 0.0, 1.0]], ..GyroModel::IDENTITY };
    let new = GyroModel { b_rad_s: [0.01, -0.02, 0.03], ..old };
    bench.filter.model_changed(&old, &new, &[1e-3; 12]);
    let after = bench.filter.attitude(AttitudeFlags::empty()).unwrap();
    assert_eq!(before, after);
    let raw = [0.1, 0.2, 0.3];
    let change = (new.compensate(raw) - bench.filter.residual_bias_rad_s()).cast::<f64>()
        - (old.compensate(raw).cast::<f64>() - bias);
    assert!(change.norm() < 5e-4, "{change}");
}

#[test]
fn another_p_forgets_the_residual_bias_and_does_not_move_the_attitude() {
    let mut bench = with_bias(&Vector3::new(0.004, -0.003, 0.005));
    let before = bench.filter.attitude(AttitudeFlags::empty()).unwrap();
    let new = GyroModel { p: [[1.1, 0.0, 0.02], [0.0, 0.9, 0.0], [0.01, 0.0, 1.0]], ..GyroModel::IDENTITY };
    bench.filter.model_changed(&GyroModel::IDENTITY, &new, &[1e-3; 12]);
    let after = bench.filter.attitude(AttitudeFlags::empty()).unwrap();
    assert_eq!(after.q, before.q);
    assert!(after.sigma_azimuth_rad > 3.0, "carried by a P that was off by percents");
    assert_eq!(bench.filter.residual_bias_rad_s(), Vector3::zeros());
    // The new model has removed the bias.
    let a = bench.run(10.0, STILL, Some, Some).unwrap();
    assert!(bench.azimuth_error_deg(&a) < 0.3 && bench.truth.tilt_error_rad(&a).to_degrees() < 0.1);
}

#[test]
fn a_disturbed_field_moves_neither_tilt_nor_heading_and_a_lasting_one_is_taken_up() {
    let mut bench = Bench::new(&Earth::default());
    bench.run(30.0, STILL, Some, Some);
    let magnet = |m: Vector3<f64>| Some(m + Vector3::new(25.0, -15.0, 10.0));
    let a = bench.run(30.0, STILL, Some, magnet).unwrap();
    assert!(a.flags.contains(AttitudeFlags::MAG_UNUSED));
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 0.1 && bench.azimuth_error_deg(&a) < 0.5);
    let a = bench.run(180.0, STILL, Some, magnet).unwrap();
    assert!(!a.flags.contains(AttitudeFlags::MAG_UNUSED));
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 0.1, "whatever the field does");
}

#[test]
fn a_heading_that_the_gyro_carries_is_not_given_up_for_a_field_that_tells_less() {
    // Near a magnetic pole the first heading is uncertain. A steeper field, as by iron that passes in a second, tells
    // still less of it, and its horizontal part points anywhere.
    let mut noise = Noise::new(11);
    let runs = 40;
    let (mut moved, mut stated) = (0.0, 0.0);
    for _ in 0..runs {
        let mut filter = AttitudeFilter::new();
        filter.start(&AttitudeConfig::default(), &Earth::default(), Motion::Hand);
        let mut truth = Truth::at(noise.uniform(0.0, 360.0), noise.uniform(30.0, 150.0), noise.uniform(0.0, 360.0));
        let dip_deg = noise.uniform(84.2, 85.5);
        let (steeper_deg, turned_rad) = (noise.uniform(86.3, 86.9), noise.uniform(-PI, PI));
        let rate = noise.vector() * 0.1;
        let mut turn = |filter: &mut AttitudeFilter, seconds: f64, dip_deg, turned_rad| {
            let mut last = None;
            for _ in 0..(seconds / DT_S) as u32 {
                truth.turn(&rate, DT_S);
                let (force, field) = (truth.force(&STILL), truth.field(dip_deg, turned_rad));
                last = feed(filter, DT_S, &rate, Some(force), Some(field));
            }
            let a = last.unwrap();
            (apart(a.azimuth_rad.into(), truth.azimuth_rad()), f64::from(a.sigma_azimuth_rad))
        };
        let (before, sigma) = turn(&mut filter, 5.0, dip_deg, 0.0);
        let (after, _) = turn(&mut filter, 1.0, steeper_deg, turned_rad);
        moved += apart(after, before).powi(2) / f64::from(runs);
        stated += sigma * sigma / f64::from(runs);
    }
    let [moved, stated] = [moved, stated].map(|square: f64| square.sqrt().to_degrees());
    println!("heading moved by {moved:.1} deg rms where its sigma was {stated:.1} deg");
    assert!(moved < stated, "moved by {moved} deg rms, sigma {stated}");
}

#[test]
fn a_heading_that_an_undisturbed_field_contradicts_gives_in() {
    let mut bench = Bench::new(&Earth::default());
    bench.run(30.0, STILL, Some, Some);
    // Turned by 60 deg about the vertical without the gyro seeing it.
    let unseen = bench.truth.q.inverse() * Vector3::new(0.0, 0.0, PI / 3.0);
    bench.truth.turn(&unseen, 1.0);
    let a = bench.run(10.0, STILL, Some, Some).unwrap();
    assert!(bench.azimuth_error_deg(&a) > 50.0 && a.flags.contains(AttitudeFlags::MAG_UNUSED));
    let a = bench.run(40.0, STILL, Some, Some).unwrap();
    assert!(bench.azimuth_error_deg(&a) < 5.0 && !a.flags.contains(AttitudeFlags::MAG_UNUSED), "{a:?}");
}

#[test]
fn an_estimate_that_is_upside_down_finds_up_again() {
    let mut bench = Bench::new(&Earth::default());
    bench.run(10.0, STILL, Some, Some);
    let unseen = bench.truth.q.inverse() * Vector3::new(PI, 0.0, 0.0);
    bench.truth.turn(&unseen, 1.0);
    let a = bench.run(20.0, STILL, Some, Some).unwrap();
    assert!(bench.truth.tilt_error_rad(&a).to_degrees() < 1.0, "{a:?}");
}

#[test]
fn declination_turns_north_and_latitude_takes_out_the_earths_rotation() {
    let declination = 12.0_f64.to_radians();
    let mut bench = Bench::new(&Earth { declination_rad: Some(declination as f32), ..Earth::default() });
    let a = bench.run(5.0, STILL, Some, Some).unwrap();
    assert!((apart(a.azimuth_rad.into(), bench.truth.azimuth_rad() + declination)).abs() < 0.01);

    // Ten minutes without a magnetometer: 1.8 deg of earth rotation at 45 deg of latitude.
    let latitude = std::f64::consts::FRAC_PI_4;
    let earth = Earth { latitude_rad: Some(latitude as f32), ..Earth::default() };
    let mut filter = AttitudeFilter::new();
    filter.start(&AttitudeConfig::default(), &earth, Motion::DrillString);
    let truth = Truth::at(0.0, 40.0, 20.0);
    let earth_rate = truth.q.inverse() * Vector3::new(latitude.cos(), 0.0, -latitude.sin()) * 7.292_115e-5;
    let mut last = None;
    for _ in 0..60_000 {
        last = feed(&mut filter, 0.01, &earth_rate, Some(truth.force(&STILL)), None);
    }
    assert!(apart(last.unwrap().azimuth_rad.into(), 0.0).abs().to_degrees() < 0.3, "{last:?}");
}

/// Rotation of the earth in the body, against its closed form at the true attitude; zero without a latitude.
#[test]
fn the_earths_rotation_is_that_of_the_latitude_at_the_attitude() {
    let mut noise = Noise::new(9);
    for _ in 0..20 {
        let [turn, tilt, lat] = [noise.normal(), noise.normal(), noise.normal()];
        let latitude = (0.6 * lat).clamp(-1.4, 1.4);
        for known in [Some(latitude as f32), None] {
            let mut bench = Bench::new(&Earth { latitude_rad: known, ..Earth::default() });
            bench.truth = Truth::at(90.0 * turn, 45.0 + 20.0 * tilt.clamp(-2.0, 2.0), 70.0 * lat);
            bench.run(5.0, STILL, Some, Some);
            let ned = Vector3::new(latitude.cos(), 0.0, -latitude.sin()) * 7.292_115e-5;
            let expected = if known.is_some() { bench.truth.q.inverse() * ned } else { STILL };
            let error = bench.filter.earth_rate_rad_s().cast::<f64>() - expected;
            assert!(error.norm() < 0.03 * 7.292_115e-5, "{latitude} {known:?}: {error} {expected}");
        }
    }
}
