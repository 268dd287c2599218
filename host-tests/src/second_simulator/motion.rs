//! Motion of the tool.

use super::{Plan, STEP_S, resonator::Resonator};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};
use testbed::simulate::Random;

/// One step of the motion.
pub(super) struct Moved {
    /// In its middle, body to NED.
    pub(super) attitude: UnitQuaternion<f64>,
    /// Mean, body axes.
    pub(super) rate_rad_s: Vector3<f64>,
    pub(super) change_rad_s2: Vector3<f64>,
    /// Without gravity, body axes.
    pub(super) acceleration_m_s2: Vector3<f64>,
}

/// Torque of a shock that rings down.
struct Shock {
    at_s: f64,
    peak_m_s2: Vector3<f64>,
    hz: f64,
    decay_s: f64,
}

pub(super) struct Motion {
    hole: UnitQuaternion<f64>,
    /// Times and speeds at which the driller's plan changes, seconds and rad/s.
    plateaus: Vec<(f64, f64)>,
    commanded_rad_s: f64,
    toolface_rad: f64,
    torsion: Resonator,
    depth: f64,
    tilt: [Resonator; 2],
    flutter: [Resonator; 3],
    shaking: [Resonator; 3],
    whirl: (f64, f64, f64),
    shocks: Vec<Shock>,
    shaken: f64,
    pub(super) last: UnitQuaternion<f64>,
    last_rate_rad_s: Vector3<f64>,
}

/// Speed gained by the rotary in a second, rad/s^2: 6 to 60 rpm/s are usual.
const GAIN_RAD_S2: f64 = 1.5;

impl Motion {
    pub(super) fn new(plan: &Plan, place: &mut Random, moving: &mut Random) -> Self {
        let [low, high] = plan.inclination_deg;
        let inclination = place.between(low, high).to_radians();
        let azimuth = place.between(0.0, TAU);
        let hole = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), azimuth)
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), inclination);
        let mut plateaus = Vec::new();
        let mut t_s = moving.between(8.0, 14.0);
        while t_s < plan.duration_s {
            let rests = !plateaus.is_empty() && moving.uniform() < 0.12;
            let speed = if rests { 0.0 } else { moving.between(40.0, 150.0) * TAU / 60.0 };
            plateaus.push((t_s, speed));
            t_s += if rests { moving.between(6.0, 12.0) } else { moving.between(15.0, 45.0) };
        }
        let mode = |hz: f64, damping: f64, deviation: f64| Resonator::new(hz, damping, deviation, STEP_S);
        let (torsion_hz, tilt_hz) = (moving.between(0.15, 0.4), moving.between(0.8, 3.0));
        let depth = if plan.reverses { moving.between(0.9, 1.2) } else { moving.between(0.15, 0.45) };
        let flutter_hz = moving.between(9.0, 30.0);
        let mut of = |low_hz: f64, high_hz: f64, low: f64, high: f64| {
            let hz = moving.between(low_hz, high_hz);
            // Acceleration of a narrow mode is (2 pi f)^2 of its displacement.
            mode(hz, 0.05, moving.between(low, high) / (TAU * hz).powi(2))
        };
        let shaking = [of(14.0, 60.0, 1.0, 5.0), of(14.0, 60.0, 1.0, 5.0), of(20.0, 80.0, 0.5, 3.0)];
        let mut shocks = Vec::new();
        let mut shock = |at_s: f64, moving: &mut Random| {
            shocks.push(Shock {
                at_s,
                peak_m_s2: Vector3::from(moving.direction()) * 9.81 * moving.between(6.0, 30.0),
                hz: moving.between(80.0, 250.0),
                decay_s: moving.between(0.003, 0.012),
            });
        };
        let mut at_s = 20.0;
        loop {
            at_s += 15.0 * moving.exponential();
            if at_s >= plan.duration_s {
                break;
            }
            shock(at_s, moving);
        }
        if let Some(at_s) = plan.shock_s {
            shock(at_s, moving);
            shocks.iter_mut().rev().take(1).for_each(|shock| shock.peak_m_s2 *= 3.0);
        }
        let order = moving.between(1.0, 5.0);
        // Acceleration at 10 rad/s.
        let whirl_m_s2 = if moving.uniform() < 0.4 { moving.between(1.0, 6.0) } else { 0.0 };
        let whirl = (whirl_m_s2 / (10.0 * order).powi(2), order, moving.between(0.0, TAU));
        Self {
            hole,
            plateaus,
            commanded_rad_s: 0.0,
            toolface_rad: place.between(0.0, TAU),
            torsion: mode(torsion_hz, 0.04, depth * 0.7),
            depth,
            tilt: [mode(tilt_hz, 0.1, 0.1_f64.to_radians()), mode(tilt_hz * 1.13, 0.1, 0.1_f64.to_radians())],
            flutter: [0.0, 0.17, 0.31].map(|more| {
                let hz = flutter_hz * (1.0 + more);
                mode(hz, 0.06, moving.between(1.0, 4.0).to_radians() / (TAU * hz))
            }),
            shaking,
            whirl,
            shocks,
            shaken: 0.0,
            last: hole,
            last_rate_rad_s: Vector3::zeros(),
        }
    }

    pub(super) fn attitude(&self) -> UnitQuaternion<f64> {
        self.last
    }

    pub(super) fn step(&mut self, t_s: f64, random: &mut Random) -> Moved {
        let plan = self.plateaus.iter().rev().find(|(from_s, _)| *from_s <= t_s).map_or(0.0, |(_, speed)| *speed);
        let missing = plan - self.commanded_rad_s;
        self.commanded_rad_s += missing.clamp(-GAIN_RAD_S2 * STEP_S, GAIN_RAD_S2 * STEP_S);
        // A tool that turns shakes; the shaking fades with the speed.
        self.shaken = (self.commanded_rad_s / 6.0).min(1.0);
        self.torsion.step(STEP_S, random);
        let wave = self.torsion.x.clamp(-self.depth, self.depth);
        let speed = self.commanded_rad_s * (1.0 + wave);
        self.toolface_rad += speed * STEP_S;
        self.tilt.iter_mut().chain(&mut self.flutter).for_each(|mode| {
            mode.step(STEP_S, random);
        });
        let s = self.shaken;
        let turn = |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_scaled_axis(axis * angle);
        let [tilt_x, tilt_y] = &self.tilt;
        let [x, y, z] = &self.flutter;
        let next = self.hole
            * turn(Vector3::x(), s * tilt_x.x)
            * turn(Vector3::y(), s * tilt_y.x)
            * turn(Vector3::z(), self.toolface_rad)
            * turn(Vector3::x(), s * x.x)
            * turn(Vector3::y(), s * y.x)
            * turn(Vector3::z(), s * z.x);
        if t_s == 0.0 {
            self.last = next;
        }
        let turned = (self.last.inverse() * next).scaled_axis();
        let rate_rad_s = turned / STEP_S;
        let change_rad_s2 = (rate_rad_s - self.last_rate_rad_s) / STEP_S;
        let attitude = self.last * UnitQuaternion::from_scaled_axis(turned * 0.5);
        (self.last, self.last_rate_rad_s) = (next, rate_rad_s);
        let mut acceleration = Vector3::zeros();
        for (axis, mode) in acceleration.iter_mut().zip(&mut self.shaking) {
            *axis = s * mode.step(STEP_S, random);
        }
        // The axis of the collar goes about that of the hole, backwards.
        let (radius_m, order, phase) = self.whirl;
        let (sine, cosine) = (order * self.toolface_rad + phase + self.toolface_rad).sin_cos();
        let centripetal = radius_m * (order * speed).powi(2);
        acceleration += Vector3::new(-cosine, sine, 0.0) * centripetal;
        for shock in &self.shocks {
            let since_s = t_s - shock.at_s;
            if (0.0..0.2).contains(&since_s) {
                let ring = (-since_s / shock.decay_s).exp() * (TAU * shock.hz * since_s + 0.5 * PI).sin();
                acceleration += shock.peak_m_s2 * ring;
            }
        }
        Moved { attitude, rate_rad_s, change_rad_s2, acceleration_m_s2: acceleration }
    }
}
