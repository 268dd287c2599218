//! Toolfaces of known slides, through the surveyor.

use super::*;
use crate::{
    attitude::{Attitude, AttitudeFlags},
    config::Earth,
    survey::{SurveyNews, Surveyor},
};

/// All toolfaces of 40 s at 200 Hz, with the tool's toolface and speed at a time in seconds, inclination in degrees.
fn toolfaces(inclination_deg: f32, of: impl Fn(f32) -> (f32, f32)) -> heapless::Vec<SlidingToolface, 16> {
    toolfaces_with(inclination_deg, |_| AttitudeFlags::empty(), of)
}

/// All toolfaces of 40 s, with flags of the attitude at a time in seconds.
fn toolfaces_with(
    inclination_deg: f32,
    flags: impl Fn(f32) -> AttitudeFlags,
    of: impl Fn(f32) -> (f32, f32),
) -> heapless::Vec<SlidingToolface, 16> {
    let config = SurveyConfig { toolface_offset_rad: 0.5, ..SurveyConfig::default() };
    let mut surveyor = Surveyor::new();
    surveyor.configure(&Earth { declination_rad: Some(0.1), ..Earth::default() }, &config).unwrap();
    let mut all = heapless::Vec::new();
    for k in 1..8_000_u32 {
        let (toolface, rate) = of(k as f32 * 0.005);
        let attitude = Attitude {
            q: [1.0, 0.0, 0.0, 0.0],
            inclination_rad: inclination_deg.to_radians(),
            azimuth_rad: 1.0,
            gravity_toolface_rad: positive_angle(libm::remainderf(toolface, TAU)),
            magnetic_toolface_rad: positive_angle(libm::remainderf(toolface + 1.0, TAU)),
            sigma_inclination_rad: 0.001,
            sigma_azimuth_rad: 0.01,
            sigma_toolface_rad: 0.004,
            flags: flags(k as f32 * 0.005),
        };
        let input = SurveyInput {
            t_us: u64::from(k) * 5_000,
            rate_rad_s: Some([0.0, 0.0, rate]),
            attitude: Some(attitude),
            ..SurveyInput::default()
        };
        if surveyor.push(&input).contains(SurveyNews::TOOLFACE) {
            all.push(*surveyor.sliding_toolface().unwrap()).unwrap();
        }
    }
    all
}

#[test]
fn one_comes_every_five_seconds_and_is_the_mean_across_the_highside() {
    // Toolface swings by 0.3 rad about 0.05 rad before the highside, five swings in a mean.
    let all = toolfaces(40.0, |t| (-0.05 + 0.3 * libm::sinf(TAU * t), 0.0));
    assert_eq!(all.len(), 7);
    for toolface in &all {
        assert_eq!((toolface.kind, toolface.t_end_us - toolface.t_start_us), (ToolfaceKind::Gravity, 5_000_000));
        assert!((toolface.toolface_rad.value - 0.45).abs() < 1e-3, "{toolface:?}");
        assert!((toolface.swing_rad - 0.3 / core::f32::consts::SQRT_2).abs() < 2e-3);
        assert!((toolface.toolface_rad.sigma - 0.004).abs() < 1e-6);
    }
}

#[test]
fn the_latency_is_the_lag_behind_a_toolface_that_creeps() {
    // Toolface creeps by 2 deg/s: a mean lags by the latency that it states.
    let creep = 2.0_f32.to_radians();
    let all = toolfaces(40.0, |t| (creep * t, creep));
    assert_eq!(all.len(), 7);
    for toolface in &all {
        let now = creep * (toolface.t_end_us as f32 * 1e-6) + 0.5;
        let lag_s = libm::remainderf(now - toolface.toolface_rad.value, TAU) / creep;
        assert!((lag_s - toolface.latency_s).abs() < 0.02, "{lag_s} {toolface:?}");
        assert!((toolface.latency_s - 2.5).abs() < 0.01);
    }
}

#[test]
fn near_the_vertical_it_counts_from_magnetic_north_and_while_rotating_there_is_none() {
    let all = toolfaces(1.0, |_| (0.2, 0.0));
    let toolface = all.first().unwrap();
    assert_eq!(toolface.kind, ToolfaceKind::Magnetic);
    assert!((toolface.toolface_rad.value - (0.2 + 1.0 + 0.5 - 0.1)).abs() < 1e-5);
    assert!(toolfaces(40.0, |t| (12.0 * t, 12.0)).len() < 2);
}

/// A heading that is found after 2 s jumps by 1.5 rad.
#[test]
fn a_magnetic_toolface_waits_for_a_heading() {
    let flags = |t: f32| if t < 2.0 { AttitudeFlags::NO_HEADING } else { AttitudeFlags::empty() };
    let of = |t: f32| (if t < 2.0 { 1.5 } else { 0.0 }, 0.0);
    let all = toolfaces_with(1.0, flags, of);
    assert_eq!(all.len(), 7);
    for toolface in &all {
        // 1 rad from true north, less the declination, and the offset.
        assert_eq!(toolface.kind, ToolfaceKind::Magnetic);
        assert!((toolface.toolface_rad.value - 1.4).abs() < 1e-3 && toolface.swing_rad < 1e-3, "{toolface:?}");
    }
    // Gravity's needs none.
    assert_eq!(toolfaces_with(40.0, flags, of).len(), 7);
}
