//! The watch finds a magnet, and nothing where there is none.

use super::*;
use crate::magnet::FieldUse;
use nalgebra::{UnitQuaternion, Vector3};
extern crate std;
use std::vec::Vec;

/// Sample period, microseconds: 100 Hz.
const PERIOD_US: u32 = 10_000;
const FIELD_UT: Vector3<f64> = Vector3::new(20.0, 0.0, 45.0);

/// A body that rests for some seconds and then tumbles, and what its sensors read; no noise.
struct Run {
    length_s: f64,
    rest_s: f64,
    /// Raw over true rate.
    gain: f64,
    lag_s: f64,
    /// Body-fixed offset at a time.
    iron_ut: fn(f64) -> Vector3<f64>,
    /// Change of the earth field, added to [`FIELD_UT`].
    disturbance_ut: fn(f64) -> Vector3<f64>,
    freeze_us: Option<u64>,
    /// False while the gyro gives no reading.
    gyro_reads: fn(f64) -> bool,
    /// Error of the gyro's reading about z, rad/s.
    gyro_error_rad_s: fn(f64) -> f64,
    /// Times between which the body stands still, seconds.
    pause_s: [f64; 2],
}

fn nothing(_: f64) -> Vector3<f64> {
    Vector3::zeros()
}

fn magnet(t_s: f64) -> Vector3<f64> {
    if (12.0..30.0).contains(&t_s) { Vector3::new(6.0, -4.0, 9.0) } else { Vector3::zeros() }
}

const QUIET: Run = Run {
    length_s: 50.0,
    rest_s: 4.0,
    gain: 1.0,
    lag_s: 0.0,
    iron_ut: nothing,
    disturbance_ut: nothing,
    freeze_us: None,
    gyro_reads: |_| true,
    gyro_error_rad_s: |_| 0.0,
    pause_s: [0.0; 2],
};

impl Run {
    /// The watch at the end of the run, and its use of the field at each sample.
    fn watched(&self) -> (HardIronWatch, Vec<UsableField>) {
        let config = Config { sample_period_us: PERIOD_US, ..Config::default() };
        let mut watch = HardIronWatch::zero();
        watch.configure(&config);
        watch.start(0);
        let rate_at = |t: f64| {
            let s = |hz: f64, phase: f64| (core::f64::consts::TAU * hz * t + phase).sin();
            let tumbling = Vector3::new(1.2 * s(0.21, 0.3) + 0.3, s(0.17, 1.7) - 0.2, 1.5 * s(0.13, 2.9) + 0.4);
            let [from_s, to_s] = self.pause_s;
            if t < self.rest_s || (from_s..to_s).contains(&t) { Vector3::zeros() } else { tumbling }
        };
        let (mut attitude, mut uses) = (UnitQuaternion::<f64>::identity(), Vec::new());
        let dt = f64::from(PERIOD_US) * 1e-6;
        for k in 0..(self.length_s / dt) as u64 {
            let t = k as f64 * dt;
            let earlier = attitude * UnitQuaternion::from_scaled_axis(-rate_at(t) * self.lag_s);
            let earths = FIELD_UT + (self.disturbance_ut)(t);
            let field = earlier.inverse_transform_vector(&earths) + (self.iron_ut)(t);
            let raw = rate_at(t) * self.gain + Vector3::z() * (self.gyro_error_rad_s)(t);
            let rate = if (self.gyro_reads)(t) { Reading::Usable(raw.cast()) } else { Reading::Missing };
            let force = attitude.inverse_transform_vector(&Vector3::new(0.0, 0.0, -9.8));
            let [force, field] = [force, field].map(|v| Reading::Usable(v.cast()));
            let t_us = k * u64::from(PERIOD_US);
            if self.freeze_us.is_some_and(|freeze_us| t_us >= freeze_us) {
                watch.freeze();
            }
            watch.push(t_us, [rate, force, field]);
            uses.push(watch.usable_field());
            attitude *= UnitQuaternion::from_scaled_axis(rate_at(t + 0.5 * dt) * dt);
        }
        (watch, uses)
    }
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

fn is_left_alone(run: &Run) -> bool {
    let (watch, uses) = run.watched();
    watch.counts() == HardIronCounts::default() && uses.iter().all(|u| *u == UsableField::Less(Vector3::zeros()))
}

#[test]
fn a_magnet_on_a_tumbling_body_is_found_with_its_time_and_size() {
    let run = Run { iron_ut: magnet, ..QUIET };
    let (watch, uses) = run.watched();
    let found: Vec<_> = watch.intervals().collect();
    assert_eq!(found.len(), 1);
    assert!((seconds(found[0].from_us) - 12.0).abs() < 0.3, "{found:?}");
    assert!((seconds(found[0].to_us.unwrap()) - 30.0).abs() < 0.3, "{found:?}");
    assert!((found[0].offset() - magnet(20.0).cast()).norm() < 0.3, "{found:?}");
    assert_eq!(uses[1250], UsableField::Withheld, "not decided yet");
    assert!(matches!(uses[2900], UsableField::Less(offset) if (offset - magnet(20.0).cast()).norm() < 0.3));
    assert_eq!(uses[3030], UsableField::Withheld, "its leaving is noticed at once");
    assert_eq!(*uses.last().unwrap(), UsableField::Less(Vector3::zeros()));
}

#[test]
fn a_magnet_that_is_brought_at_rest_is_told_once_the_body_turns() {
    let run = Run { iron_ut: magnet, rest_s: 16.0, ..QUIET };
    let (watch, uses) = run.watched();
    let found: Vec<_> = watch.intervals().collect();
    assert_eq!(found.len(), 1);
    assert!((seconds(found[0].from_us) - 12.0).abs() < 0.3, "{found:?}");
    // Iron that was there before, and never showed at rest, is as uncertain as the calibration.
    assert!((found[0].offset() - magnet(20.0).cast()).norm() < 1.0, "{found:?}");
    assert!(uses[1250..1600].iter().all(|u| *u == UsableField::Withheld));
}

/// A magnet that is brought at rest; the gyro falls silent when new iron is the likelier, but not decided.
const TOLD_LATE: Run = Run { iron_ut: magnet, rest_s: 16.0, gyro_reads: |t| !(18.4..18.7).contains(&t), ..QUIET };

#[test]
fn a_magnet_that_could_not_be_told_when_it_came_is_told_when_it_leaves() {
    let (watch, uses) = TOLD_LATE.watched();
    let found: Vec<_> = watch.intervals().collect();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].field_use, FieldUse::ToldAfterwards);
    assert!((seconds(found[0].from_us) - 12.0).abs() < 0.3, "{found:?}");
    assert!((seconds(found[0].to_us.unwrap()) - 30.0).abs() < 0.3, "{found:?}");
    assert!((found[0].offset() - magnet(20.0).cast()).norm() < 1.0, "{found:?}");
    assert_eq!(*uses.last().unwrap(), UsableField::Less(Vector3::zeros()));
}

#[test]
fn what_left_is_not_what_came_if_their_offsets_differ() {
    let other = |t: f64| if (20.0..30.0).contains(&t) { Vector3::new(6.0, 4.0, 9.0) } else { magnet(t) };
    let (watch, _) = Run { iron_ut: other, ..TOLD_LATE }.watched();
    assert!(watch.intervals().all(|interval| interval.field_use != FieldUse::ToldAfterwards));
}

#[test]
fn an_interval_is_news_when_it_begins_and_when_it_ends() {
    let (mut watch, _) = Run { iron_ut: magnet, length_s: 25.0, ..QUIET }.watched();
    assert_eq!(watch.take_interval().map(|interval| interval.to_us), Some(None));
    assert_eq!(watch.take_interval(), None);
    let (mut watch, _) = Run { iron_ut: magnet, ..QUIET }.watched();
    assert!(watch.take_interval().is_some_and(|interval| interval.to_us.is_some()));
    assert_eq!(watch.take_interval(), None);
}

#[test]
fn a_field_that_changes_in_the_earth_is_no_magnet() {
    let jump = |t: f64| if (12.0..30.0).contains(&t) { Vector3::new(6.0, -4.0, 9.0) } else { Vector3::zeros() };
    for rest_s in [4.0, 16.0] {
        let (watch, uses) = Run { disturbance_ut: jump, rest_s, ..QUIET }.watched();
        assert_eq!(watch.counts().intervals, 0, "{rest_s}");
        assert!(watch.counts().suspicions > 0 && watch.counts().suspicions == watch.counts().dismissed);
        assert_eq!(*uses.last().unwrap(), UsableField::Less(Vector3::zeros()));
    }
}

#[test]
fn a_lag_a_wrong_p_and_iron_from_the_start_are_no_events() {
    assert!(is_left_alone(&QUIET));
    assert!(is_left_alone(&Run { lag_s: 0.015, ..QUIET }));
    assert!(is_left_alone(&Run { gain: 1.05, lag_s: 0.011, ..QUIET }));
    let (watch, _) = Run { lag_s: 0.011, ..QUIET }.watched();
    assert!((watch.tracked.lag_s() - 0.011).abs() < 0.002, "{}", watch.tracked.lag_s());
    assert!(is_left_alone(&Run { iron_ut: |_| Vector3::new(1.0, -1.5, 1.0), ..QUIET }));
    assert!(is_left_alone(&Run { iron_ut: |_| Vector3::new(12.0, -15.0, 10.0), ..QUIET }));
}

#[test]
fn a_magnet_after_the_freeze_is_corrected_only_if_it_was_known_before() {
    let twice = |t: f64| if t > 35.0 { magnet(t - 23.0) } else { magnet(t) };
    let frozen_at = |freeze_us| Run { iron_ut: twice, length_s: 60.0, freeze_us: Some(freeze_us), ..QUIET }.watched();
    let corrected = |watch: &HardIronWatch| watch.intervals().map(HardIronInterval::is_corrected).collect::<Vec<_>>();
    let (watch, uses) = frozen_at(25_000_000);
    assert_eq!(corrected(&watch), [true, true]);
    assert!(matches!(uses[4500], UsableField::Less(offset) if (offset - magnet(20.0).cast()).norm() < 0.5));
    let (watch, uses) = frozen_at(5_000_000);
    assert_eq!(corrected(&watch), [false, false]);
    assert_eq!((uses[2500], uses[4500]), (UsableField::Withheld, UsableField::Withheld));
}

#[test]
fn a_gap_ends_a_suspicion_and_claims_nothing() {
    let mut watch = HardIronWatch::zero();
    watch.configure(&Config { sample_period_us: PERIOD_US, ..Config::default() });
    watch.start(0);
    let field = |t_us: u64| Vector3::new(20.0, if t_us > 5_000_000 { 12.0 } else { 0.0 }, 45.0);
    let mut t_us = 0;
    while t_us < 6_000_000 {
        watch.push(t_us, [Reading::Usable(Vector3::zeros()), Reading::Missing, Reading::Usable(field(t_us))]);
        t_us += u64::from(PERIOD_US);
    }
    assert_eq!(watch.usable_field(), UsableField::Withheld);
    watch.gap(9_000_000);
    for k in 0..500 {
        watch.push(
            9_000_000 + k * u64::from(PERIOD_US),
            [Reading::Missing, Reading::Missing, Reading::Usable(field(t_us))],
        );
    }
    assert_eq!(watch.usable_field(), UsableField::Less(Vector3::zeros()));
    assert_eq!(watch.counts().intervals, 0);
}

#[test]
fn a_turn_within_a_gap_withholds_no_field() {
    let mut watch = HardIronWatch::zero();
    watch.configure(&Config { sample_period_us: PERIOD_US, ..Config::default() });
    watch.start(0);
    // A gyro that reads the very same never is frozen.
    let rate = |t_us: u64| Vector3::new(1e-5, -1e-5, 2e-5) * ((t_us / u64::from(PERIOD_US)) % 7) as f32;
    let push = |watch: &mut HardIronWatch, t_us: u64, field: Vector3<f32>| {
        watch.push(t_us, [Reading::Usable(rate(t_us)), Reading::Missing, Reading::Usable(field)]);
    };
    let mut t_us = 0;
    while t_us < 5_100_000 {
        push(&mut watch, t_us, Vector3::new(20.0, 0.0, 45.0));
        t_us += u64::from(PERIOD_US);
    }
    watch.gap(9_000_000);
    for k in 0..500 {
        push(&mut watch, 9_000_000 + k * u64::from(PERIOD_US), Vector3::new(0.0, 20.0, 45.0));
        assert_eq!(watch.usable_field(), UsableField::Less(Vector3::zeros()), "{k}");
    }
}

#[test]
fn a_gyro_that_reads_a_turn_at_rest_brings_no_magnet() {
    for begin_s in [20.0, 20.5, 21.3, 22.0] {
        let wrong = |t: f64| if (22.0..25.0).contains(&t) { 0.3 } else { 0.0 };
        let run = Run { gyro_error_rad_s: wrong, pause_s: [begin_s, 28.0], ..QUIET };
        let (watch, uses) = run.watched();
        assert_eq!(watch.counts().intervals, 0, "{begin_s}: {:?}", watch.intervals().collect::<Vec<_>>());
        assert_eq!(*uses.last().unwrap(), UsableField::Less(Vector3::zeros()));
    }
}

/// The start falls into a turn that the gyro misses, and what it reads first is wrong.
#[test]
fn a_turn_that_the_gyro_has_not_seen_brings_no_magnet() {
    let silences: [fn(f64) -> bool; 3] = [|t| t > 0.5, |t| t > 1.1, |t| t > 2.0];
    let errors: [fn(f64) -> f64; 2] = [|_| 0.0, |t| if t < 3.0 { 0.3 } else { 0.0 }];
    for (silence, gyro_reads) in silences.into_iter().enumerate() {
        for gyro_error_rad_s in errors {
            let run = Run { gyro_reads, gyro_error_rad_s, rest_s: 0.0, pause_s: [1.1, 8.0], ..QUIET };
            let (watch, _) = run.watched();
            assert_eq!(watch.counts().intervals, 0, "silence {silence}");
        }
    }
}
