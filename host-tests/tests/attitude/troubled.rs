//! A whole probe that drills with a failing sensor, and its attitude errors.

use std::f64::consts::TAU;

use meerkat_mwd::{
    Sample,
    attitude::{Attitude, AttitudeFlags},
    config::Latency,
    probe::Output,
};
use nalgebra::{UnitQuaternion, Vector3};
use testbed::{
    flight::{configuration::of_trace, fly},
    simulate::{Hole, Rotation, Scenario, simulate},
    trace::Trace,
};

use crate::{rig::rotation::rotation, simulation::sound};

/// A flight of a probe whose gyro is calibrated and whose delays are known, at 45 deg and 30 rpm after 20 s
/// of rest.
pub struct Flown {
    pub trace: Trace,
    pub outputs: Vec<Output>,
}

pub fn flown(duration_s: f64, seed: u64, change: impl FnMut(f64, &mut Sample)) -> Flown {
    let rotation = Rotation { mean_rpm: 30.0, stick_slip: 0.5, ..Rotation::default() };
    let hole = Hole { inclination_deg: 45.0, azimuth_deg: 60.0, ..Hole::default() };
    flown_in(Scenario { duration_s, rest_s: 20.0, rotation, hole, ..Scenario::default() }, seed, None, change)
}

pub fn flown_in(
    scenario: Scenario,
    seed: u64,
    gyro_full_scale_rad_s: Option<f32>,
    mut change: impl FnMut(f64, &mut Sample),
) -> Flown {
    let (trace, truth) = simulate(&scenario, seed);
    let mut config = of_trace(&trace);
    config.gyro = truth.gyro;
    config.latency = Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) };
    config.full_scale.gyro_rad_s = gyro_full_scale_rad_s;
    let mut samples = trace.samples.clone();
    for sample in &mut samples {
        change(sample.t_us as f64 * 1e-6, sample);
    }
    let outputs = fly(&config, &samples, |_| {}).unwrap().outputs;
    assert!(outputs.iter().filter_map(|o| o.attitude.as_ref()).all(sound), "no number that is none");
    Flown { trace, outputs }
}

/// Errors and flags over an interval of a flight.
#[derive(Debug, Default)]
pub struct Seen {
    /// Largest errors, degrees: of the vertical, then of the azimuth.
    pub tilt_deg: f64,
    pub azimuth_deg: f64,
    /// Largest of these errors in stated sigmas.
    pub tilt_sigmas: f64,
    pub azimuth_sigmas: f64,
    /// Largest change of the error from one sample to the next, degrees, then in the sigmas stated before.
    pub jump_deg: f64,
    pub jump_sigmas: f64,
    /// Share of samples flagged as wrong.
    pub flagged: f64,
    /// Share of samples with an error of more than 4 stated sigmas.
    pub beyond: f64,
    /// Share of samples whose inclination, azimuth or toolface is off by more than 4 of its sigmas.
    pub untold: f64,
}

impl Flown {
    pub fn seen(&self, from_s: f64, to_s: f64) -> Seen {
        let (mut seen, mut count, mut flagged, mut beyond, mut untold) = (Seen::default(), 0.0, 0.0, 0.0, 0.0);
        let mut before: Option<(UnitQuaternion<f64>, f64)> = None;
        for output in self.outputs.iter().filter(|o| (from_s..to_s).contains(&(o.t_us as f64 * 1e-6))) {
            let a = output.attitude.unwrap();
            let truth = self.truth(output.t_us);
            let estimate = rotation(a.q.map(f64::from));
            let tilt = (estimate.inverse() * Vector3::z()).angle(&(truth.inverse() * Vector3::z()));
            let c = truth.to_rotation_matrix();
            let azimuth = libm::remainder(f64::from(a.azimuth_rad) - c[(1, 2)].atan2(c[(0, 2)]), TAU).abs();
            let error = estimate * truth.inverse();
            let sigmas = (tilt / f64::from(a.sigma_inclination_rad)).max(azimuth / f64::from(a.sigma_azimuth_rad));
            beyond += f64::from(u8::from(sigmas > 4.0));
            let inclination = f64::from(a.inclination_rad) - c[(2, 2)].acos();
            let toolface = libm::remainder(f64::from(a.gravity_toolface_rad) - c[(2, 1)].atan2(-c[(2, 0)]), TAU);
            let told = [
                inclination.abs() < 4.0 * f64::from(a.sigma_inclination_rad),
                toolface.abs() < 4.0 * f64::from(a.sigma_toolface_rad),
                azimuth < 4.0 * f64::from(a.sigma_azimuth_rad),
            ];
            untold += f64::from(u8::from(told != [true; 3]));
            seen.tilt_deg = seen.tilt_deg.max(tilt.to_degrees());
            seen.azimuth_deg = seen.azimuth_deg.max(azimuth.to_degrees());
            seen.tilt_sigmas = seen.tilt_sigmas.max(tilt / f64::from(a.sigma_inclination_rad));
            seen.azimuth_sigmas = seen.azimuth_sigmas.max(azimuth / f64::from(a.sigma_azimuth_rad));
            if let Some((before, sigma)) = before {
                let jump = error.angle_to(&before);
                seen.jump_deg = seen.jump_deg.max(jump.to_degrees());
                seen.jump_sigmas = seen.jump_sigmas.max(jump / sigma);
            }
            before = Some((error, f64::from(a.sigma_inclination_rad).hypot(f64::from(a.sigma_azimuth_rad))));
            count += 1.0;
            flagged += f64::from(u8::from(troubled(&a)));
        }
        (seen.flagged, seen.beyond, seen.untold) = (flagged / count, beyond / count, untold / count);
        seen
    }

    pub fn truth(&self, t_us: u64) -> UnitQuaternion<f64> {
        let index = self.trace.samples.partition_point(|s| s.t_us < t_us);
        rotation(self.trace.reference[index].unwrap())
    }
}

pub fn troubled(a: &Attitude) -> bool {
    a.flags.intersects(
        AttitudeFlags::GYRO_HELD
            | AttitudeFlags::GYRO_CLIPPED
            | AttitudeFlags::ACCEL_UNUSED
            | AttitudeFlags::MAG_UNUSED
            | AttitudeFlags::FROZEN_SENSOR
            | AttitudeFlags::FAULT,
    )
}
