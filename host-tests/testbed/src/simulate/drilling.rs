//! Motion of the tool: attitude and body rate in closed form, apart from the angle that stick-slip adds up
//! to.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{
    multisine::Multisine,
    ramp::smooth_ramp,
    random::Random,
    scenario::{Hole, Scenario},
};

/// The tool at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Tool to NED (magnetic north).
    pub(super) attitude: UnitQuaternion<f64>,
    /// Body rate relative to the earth, tool axes, rad/s.
    pub(super) rate_rad_s: Vector3<f64>,
    /// Angle turned about the tool axis, rad, for whatever repeats with the rotation.
    pub(super) toolface_rad: f64,
    /// Speed about the tool axis, rad/s.
    pub(super) toolface_rate_rad_s: f64,
    /// 0 at rest, 1 at full drilling.
    pub(super) drilling: f64,
}

/// The drilling run, stepped through in time.
///
/// Tool to NED is Rz(azimuth) Ry(inclination) Rx Ry (wobble) Rz(toolface) Rx Ry Rz (angular vibration).
pub(super) struct Drilling<'a> {
    scenario: &'a Scenario,
    stick_slip: StickSlip,
    wobble: [Multisine; 2],
    angular: [Multisine; 3],
    /// Time, toolface and its rate at the last call.
    last: Option<(f64, f64, f64)>,
}

impl<'a> Drilling<'a> {
    pub(super) fn new(scenario: &'a Scenario, random: &mut Random) -> Self {
        let wobble_rad = scenario.wobble.rms_deg.to_radians();
        let [low, high] = scenario.vibration.angular_band_hz;
        // The scenario states the rate, the angle is drawn: the conversion is right in the middle of the
        // band.
        let angular_rad = scenario.vibration.angular_deg_s.to_radians() / (TAU * 0.5 * (low + high));
        Self {
            scenario,
            stick_slip: StickSlip::new(scenario, random),
            wobble: std::array::from_fn(|_| Multisine::new(random, 4, scenario.wobble.band_hz, wobble_rad)),
            angular: std::array::from_fn(|_| Multisine::new(random, 5, [low, high], angular_rad)),
            last: None,
        }
    }

    /// The tool at `t_s`, which must not decrease from call to call: the toolface is integrated in between
    /// (trapezoids).
    pub(super) fn advance(&mut self, t_s: f64) -> Motion {
        let (drilling, onset) = self.scenario.drilling_at(t_s);
        let toolface_rate = drilling * self.stick_slip.rate_rad_s(t_s);
        let toolface_rad = match self.last {
            None => self.scenario.rotation.toolface_deg.to_radians(),
            Some((last_s, angle, rate)) => angle + 0.5 * (rate + toolface_rate) * (t_s - last_s),
        };
        self.last = Some((t_s, toolface_rad, toolface_rate));

        let bit_s = self.scenario.stop_s.map_or(t_s, |stop_s| t_s.min(stop_s));
        let drilled_s = if bit_s > self.scenario.rest_s { bit_s - self.scenario.rest_s } else { 0.0 };
        let goes_on = drilled_s > 0.0 && bit_s >= t_s;
        let deg_h = |rate: f64| if goes_on { rate.to_radians() / 3600.0 } else { 0.0 };
        let Hole { build_rate_deg_h, turn_rate_deg_h, .. } = self.scenario.hole;
        let (build, turn) = (deg_h(build_rate_deg_h), deg_h(turn_rate_deg_h));
        let so_far = |rate: f64| rate.to_radians() / 3600.0 * drilled_s;
        // An oscillation that fades in with the drilling, and its rate.
        let faded = |wave: &Multisine| {
            let (value, slope) = wave.at(t_s);
            (drilling * value, drilling * slope + onset * value)
        };
        let [wobble_x, wobble_y] = &self.wobble;
        let [angular_x, angular_y, angular_z] = &self.angular;
        let mut chain = Chain::default();
        chain.turn(Vector3::z(), (self.scenario.hole.azimuth_deg.to_radians() + so_far(turn_rate_deg_h), turn));
        chain.turn(Vector3::y(), (self.scenario.hole.inclination_deg.to_radians() + so_far(build_rate_deg_h), build));
        chain.turn(Vector3::x(), faded(wobble_x));
        chain.turn(Vector3::y(), faded(wobble_y));
        chain.turn(Vector3::z(), (toolface_rad, toolface_rate));
        chain.turn(Vector3::x(), faded(angular_x));
        chain.turn(Vector3::y(), faded(angular_y));
        chain.turn(Vector3::z(), faded(angular_z));
        Motion {
            attitude: chain.attitude,
            rate_rad_s: chain.rate_rad_s,
            toolface_rad,
            toolface_rate_rad_s: toolface_rate,
            drilling,
        }
    }
}

impl Scenario {
    /// Share of full drilling at `t_s`, 0 to 1, and its slope, 1/s: a smooth ramp (3 x^2 - 2 x^3) after the
    /// rest, and its mirror image before the stop.
    #[must_use]
    pub fn drilling_at(&self, t_s: f64) -> (f64, f64) {
        let (on, slope) = smooth_ramp((t_s - self.rest_s) / self.ramp_s);
        let (still_on, decline) = self.stop_s.map_or((1.0, 0.0), |stop_s| smooth_ramp((stop_s - t_s) / self.ramp_s));
        (on * still_on, (slope * still_on - on * decline) / self.ramp_s)
    }
}

/// A chain of rotations, each about an axis of the frame reached so far, and the rate that they make.
struct Chain {
    attitude: UnitQuaternion<f64>,
    rate_rad_s: Vector3<f64>,
}

impl Default for Chain {
    fn default() -> Self {
        Self { attitude: UnitQuaternion::identity(), rate_rad_s: Vector3::zeros() }
    }
}

impl Chain {
    fn turn(&mut self, axis: Vector3<f64>, (angle_rad, rate_rad_s): (f64, f64)) {
        let (sine, cosine) = libm::sincos(0.5 * angle_rad);
        let turn = UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, axis * sine));
        self.attitude *= turn;
        self.rate_rad_s = turn.inverse_transform_vector(&self.rate_rad_s) + axis * rate_rad_s;
    }
}

/// Speed about the tool axis: mean times 1 + depth(t) sin(phase(t)), never backwards. Depth and phase wander
/// slowly.
struct StickSlip {
    mean_rad_s: f64,
    depth: f64,
    frequency_rad_s: f64,
    phase_rad: f64,
    depth_wander: Multisine,
    phase_wander: Multisine,
}

/// Number of sinusoids in each wander; below it their band.
const WANDER_COUNT: u32 = 3;
const WANDER_HZ: [f64; 2] = [0.005, 0.05];

impl StickSlip {
    fn new(scenario: &Scenario, random: &mut Random) -> Self {
        let rotation = &scenario.rotation;
        // A multisine's peak is its rms times the square root of twice its count: scaled so, it stays within
        // plus and minus 1.
        let within_one = 1.0 / libm::sqrt(2.0 * f64::from(WANDER_COUNT));
        Self {
            mean_rad_s: rotation.mean_rpm * TAU / 60.0,
            depth: rotation.stick_slip,
            frequency_rad_s: TAU * rotation.stick_slip_hz,
            phase_rad: TAU * random.uniform(),
            depth_wander: Multisine::new(random, WANDER_COUNT, WANDER_HZ, within_one),
            phase_wander: Multisine::new(random, WANDER_COUNT, WANDER_HZ, 1.0),
        }
    }

    fn rate_rad_s(&self, t_s: f64) -> f64 {
        let depth = self.depth * (0.8 + 0.2 * self.depth_wander.at(t_s).0);
        let phase = self.phase_rad + self.frequency_rad_s * t_s + self.phase_wander.at(t_s).0;
        self.mean_rad_s * (1.0 + depth * libm::sin(phase))
    }
}
