//! Simulator of a drilling run: a scenario in; a trace with true attitude and rate, and the gyro's true
//! model, out.
//!
//! Every reading is the mean of the truth over the sample interval centred on its time: an ideal anti-alias
//! filter without delay. The same scenario and seed give the same trace, to the bit.

mod contamination;
mod drilling;
mod effects;
mod error;
mod interval;
pub mod known_error;
mod limits;
mod multisine;
mod ramp;
pub mod random;
mod scenario;
pub mod sensors;
mod temperature;
mod validation;
pub mod vibration;

use meerkat_mwd::{SampleFlags, compensation::GyroModel, config::Motion};
use nalgebra::Vector3;

use crate::{
    score::nees::p_of,
    trace::{BodyFrame, EarthFrame, Keys, Trace},
};
pub use contamination::{Contamination, Hits, contaminate};
use drilling::Drilling;
use effects::{Disturber, bias_step};
pub use effects::{Dropouts, Effects, HardIronInterval, MagneticBursts, MountRotation};
pub use error::ScenarioError;
use interval::Interval;
pub use random::Random;
pub use scenario::{
    Accelerometer, EarthSettings, Gyro, Hole, Magnetometer, Rotation, Scenario, ShockSettings, Vibration, Wobble,
};
use sensors::{Ideal, Sensors};
pub use temperature::Temperature;
pub use vibration::Shock;

/// Rotation of the earth relative to the stars, rad/s (WGS 84).
const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// Truth beyond the trace's own columns of true attitude (`reference`) and true rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The gyro's true model with the bias of the start.
    pub gyro: GyroModel,
    /// The shocks of the run, in order of time.
    pub shocks: Vec<Shock>,
    /// The gyro's true bias in each reading, rad/s: walk, step, temperature and time, without sensitivity to
    /// specific force.
    pub bias_rad_s: Vec<[f32; 3]>,
    mount_rotation: Option<MountRotation>,
    sample_period_s: f64,
}

impl Truth {
    /// The gyro's true model at a sample, turned with its mount; the start's if there is no such sample.
    #[must_use]
    pub fn gyro_at(&self, sample: usize) -> GyroModel {
        let Some(&b_rad_s) = self.bias_rad_s.get(sample) else { return self.gyro };
        // A P that did not turn stays the same to the bit.
        let p = self.mount_rotation.as_ref().map_or(self.gyro.p, |mount| {
            let turn = mount.turn_at(sample as f64 * self.sample_period_s).to_rotation_matrix();
            let turned = turn.matrix() * self.gyro.p_matrix().map(f64::from);
            std::array::from_fn(|row| std::array::from_fn(|column| turned[(row, column)] as f32))
        });
        GyroModel { p, b_rad_s }
    }
}

/// Simulates a scenario, which must be valid ([`Scenario::validate`]).
///
/// The trace is in tool axes and NED with magnetic north. `true_rate` is relative to the earth and a mean
/// over the sample interval, as an ideal gyro reads it; if the scenario gives a latitude the gyro also senses
/// the earth's rotation.
#[must_use]
pub fn simulate(scenario: &Scenario, seed: u64) -> (Trace, Truth) {
    simulate_with(scenario, seed, |_| {})
}

/// Number of samples of a scenario.
#[must_use]
pub fn samples_of(scenario: &Scenario) -> u64 {
    (scenario.duration_s / (f64::from(scenario.sample_period_us) * 1e-6) + 1e-9) as u64 + 1
}

/// The same, and calls `progress` with the number of samples simulated so far.
pub fn simulate_with(scenario: &Scenario, seed: u64, mut progress: impl FnMut(u64)) -> (Trace, Truth) {
    let mut streams = Random::new(seed);
    // One random stream for each subject, so that changing one setting leaves the other draws as they were.
    let [mut gyro, noise, mut motion, mut vibration, mut shock, mut effect] = std::array::from_fn(|_| streams.split());
    let mut sensors = Sensors::new(scenario, &mut gyro, noise);
    let mut drilling = Drilling::new(scenario, &mut motion);
    let mut broadband = vibration::Broadband::new(scenario);
    let chatter = vibration::Chatter::new(scenario, &mut vibration);
    let until_s = scenario.stop_s.unwrap_or(scenario.duration_s);
    let shocks = vibration::draw_shocks(&scenario.shocks, scenario.rest_s, until_s, &mut shock);
    let period_us = u64::from(scenario.sample_period_us);
    let period_s = period_us as f64 * 1e-6;
    let mut truth = Truth {
        gyro: sensors.truth(),
        shocks,
        bias_rad_s: Vec::new(),
        mount_rotation: scenario.effects.mount_rotation.clone(),
        sample_period_s: period_s,
    };
    let earth = EarthVectors::new(scenario);
    let mut step = bias_step(&scenario.effects, &truth.shocks);
    let lever_arm_m = Vector3::from(scenario.effects.lever_arm_mm) * 1e-3;

    let count = samples_of(scenario) - 1;
    let mut disturber = Disturber::new(&scenario.effects, period_s, scenario.duration_s, &mut effect);
    let mut trace = Trace { keys: keys(scenario, seed, &truth), ..Trace::default() };
    let mut true_rate = Vec::new();
    let longest_shock_s = (scenario.shocks.length_ms[1] + scenario.shocks.rebound_ms) * 1e-3;
    let mut next_shock = 0;
    let mut start = drilling.advance(-0.5 * period_s);
    for index in 0..=count {
        let t_s = index as f64 * period_s;
        let (from_s, to_s) = (t_s - 0.5 * period_s, t_s + 0.5 * period_s);
        let interval = Interval::mean(&mut drilling, start, t_s, period_s, scenario.oversampling, |motion| {
            let rate = motion.rate_rad_s;
            let to_body = |v: &Vector3<f64>| motion.attitude.inverse_transform_vector(v);
            let gravity_m_s2 = to_body(&earth.gravity_m_s2);
            Ideal {
                rate_rad_s: rate + to_body(&earth.rate_rad_s),
                specific_force_m_s2: chatter.at(motion) - gravity_m_s2 + rate.cross(&rate.cross(&lever_arm_m)),
                gravity_m_s2,
                field_ut: to_body(&earth.field_ut),
            }
        });
        let mut ideal = interval.ideal;
        ideal.specific_force_m_s2 += broadband.next(&mut vibration) * interval.middle.drilling;
        // The mean of an acceleration is a change of velocity, so the mean of w' x r needs only the
        // interval's ends.
        let angular_acceleration = (interval.end.rate_rad_s - start.rate_rad_s) / period_s;
        ideal.specific_force_m_s2 += angular_acceleration.cross(&lever_arm_m);
        while truth.shocks.get(next_shock).is_some_and(|s| s.start_s + longest_shock_s <= from_s) {
            next_shock += 1;
        }
        let overlapping = truth.shocks.iter().skip(next_shock).take_while(|s| s.start_s < to_s);
        ideal.specific_force_m_s2 += overlapping.map(|s| s.mean_m_s2(from_s, to_s)).sum::<Vector3<f64>>();

        let q = interval.middle.attitude;
        ideal.field_ut += q.inverse_transform_vector(&disturber.burst_ut(t_s));
        let sensed = disturber.sensed(t_s, &ideal);
        if let Some((_, step_rad_s)) = step.take_if(|(at_s, _)| *at_s <= t_s) {
            sensors.step_bias(&step_rad_s);
        }
        let temperature_c = scenario.temperature.as_ref().map(|it| it.at(t_s, scenario.duration_s));
        let warmer_c = scenario.temperature.as_ref().zip(temperature_c).map_or(0.0, |(it, now_c)| now_c - it.start_c);
        let bias_change_rad_s = disturber.bias_change_rad_s(t_s, warmer_c);
        truth.bias_rad_s.push((sensors.bias_rad_s() + bias_change_rad_s).map(|x| x as f32).into());
        let additions_rad_s =
            disturber.gyro_additions_rad_s((t_s, warmer_c), &ideal, &sensors.scaled_rate(&sensed.rate_rad_s))
                + bias_change_rad_s;
        let mut sample = sensors.read(index * period_us, &sensed, &additions_rad_s);
        if let Some(temperature_c) = temperature_c {
            sample.temperature_c = temperature_c as f32;
            sample.flags.remove(SampleFlags::TEMPERATURE_MISSING);
        }
        disturber.drop_out(&mut sample);
        trace.samples.push(sample);
        trace.reference.push(Some([q.w, q.i, q.j, q.k]));
        true_rate.push(interval.rate_rad_s.into());
        start = interval.end;
        progress(index + 1);
    }
    trace.true_rate = Some(true_rate);
    (trace, truth)
}

/// Gravity, field and rotation of the earth in NED with magnetic north.
struct EarthVectors {
    gravity_m_s2: Vector3<f64>,
    field_ut: Vector3<f64>,
    rate_rad_s: Vector3<f64>,
}

impl EarthVectors {
    fn new(scenario: &Scenario) -> Self {
        let earth = &scenario.earth;
        let (down, north) = libm::sincos(earth.dip_deg.to_radians());
        Self {
            gravity_m_s2: Vector3::new(0.0, 0.0, earth.gravity_m_s2),
            field_ut: Vector3::new(north, 0.0, down) * earth.magnetic_field_ut,
            rate_rad_s: earth_rate_rad_s(scenario),
        }
    }
}

/// Rotation of the earth that the gyro senses, in NED with magnetic north; zero if the scenario gives no
/// latitude.
pub fn earth_rate_rad_s(scenario: &Scenario) -> Vector3<f64> {
    let earth = &scenario.earth;
    earth.latitude_deg.map_or_else(Vector3::zeros, |latitude| {
        let (sine, cosine) = libm::sincos(latitude.to_radians());
        // True north lies at minus the declination from magnetic north.
        let (east, north) = libm::sincos(-earth.magnetic_declination_deg.unwrap_or(0.0).to_radians());
        Vector3::new(cosine * north, cosine * east, -sine) * EARTH_RATE_RAD_S
    })
}

fn keys(scenario: &Scenario, seed: u64, truth: &Truth) -> Keys {
    let earth = &scenario.earth;
    let full_scales = sensors::full_scales(scenario);
    Keys {
        earth_frame: EarthFrame::Ned,
        body_frame: BodyFrame::Tool,
        magnetic_declination_deg: earth.magnetic_declination_deg,
        gravity_m_s2: Some(earth.gravity_m_s2),
        magnetic_field_ut: Some(earth.magnetic_field_ut),
        dip_deg: Some(earth.dip_deg),
        latitude_deg: earth.latitude_deg,
        gyro_full_scale_rad_s: full_scales.gyro_rad_s,
        accel_full_scale_m_s2: full_scales.accel_m_s2,
        mag_full_scale_ut: full_scales.mag_ut,
        motion: Some(Motion::DrillString),
        // As a data sheet states it; a lag that nobody declares comes on top.
        gyro_delay_s: Some(0.0),
        true_gyro_p: Some(p_of(&truth.gyro)),
        source: Some(format!("simulated drilling, seed {seed}; true gyro model: {}", describe(&truth.gyro))),
        ..Keys::default()
    }
}

/// A gyro model as text.
#[must_use]
pub fn describe(model: &GyroModel) -> String {
    let b_deg_s = model.b_rad_s.map(|x| (f64::from(x).to_degrees() * 1e4).round() / 1e4);
    format!("P = {:?}, b = {b_deg_s:?} deg/s", model.p)
}
