//! A second simulator of drilling, which shares no motion, no vibration and no sensor with the first: what is found in
//! its traces is found in physics that the estimator was not written with.
//!
//! Speed follows a driller's plan and a torsional mode of the string, the tool shakes in lightly damped modes, and all
//! is stepped at 4 kHz. Readings are means of these steps over the sample interval. Every sensor has errors within its
//! data sheet, beside the effect that a case adds.

mod motion;
mod resonator;
mod sensors;

pub use sensors::{Added, Sensors};

use meerkat_mwd::config::Motion as MotionKind;
use motion::Motion;
use nalgebra::Vector3;
use testbed::{
    simulate::Random,
    trace::{BodyFrame, EarthFrame, Keys, Trace},
};

/// Steps in a second.
const STEPS_HZ: u32 = 4_000;
/// Length of a step, seconds.
const STEP_S: f64 = 1.0 / STEPS_HZ as f64;

/// Settings by which a run is drawn, beyond its seed.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Length, seconds.
    pub duration_s: f64,
    /// Range of the hole's inclination, degrees.
    pub inclination_deg: [f64; 2],
    /// True for a string that turns back now and then.
    pub reverses: bool,
    /// Temperature at the start, and how much warmer it is at the end, degrees Celsius; `None` where none is read.
    pub temperature: Option<[f64; 2]>,
    /// Time of a shock that always comes, seconds.
    pub shock_s: Option<f64>,
}

/// Simulates a run.
#[must_use]
pub fn simulate(plan: &Plan, added: &Added, seed: u64) -> Trace {
    let mut streams = Random::new(seed ^ 0x0dd5_eed5);
    let [mut place, mut moving, mut drawn, noise] = std::array::from_fn(|_| streams.split());
    let every = [20, 32, 40][(3.0 * place.uniform()) as usize];
    let (dip_deg, field_ut) = (place.sign() * place.between(35.0, 75.0), place.between(28.0, 62.0));
    let gravity_m_s2 = place.between(9.78, 9.83);
    let (down, north) = dip_deg.to_radians().sin_cos();
    let field = Vector3::new(north, 0.0, down) * field_ut;
    let mut motion = Motion::new(plan, &mut place, &mut moving);
    let mut sensors = Sensors::new(added, &mut drawn, noise);
    let mut trace = Trace {
        keys: Keys {
            earth_frame: EarthFrame::Ned,
            body_frame: BodyFrame::Tool,
            gravity_m_s2: Some(gravity_m_s2),
            // A reference errs by 130 nT and 0.2 deg (MFI and MDI of the ISCWSA model).
            magnetic_field_ut: Some(field_ut + 0.13 * place.normal()),
            dip_deg: Some(dip_deg + 0.2 * place.normal()),
            motion: Some(MotionKind::DrillString),
            // As a data sheet states it; a lag that nobody declares comes on top.
            gyro_delay_s: Some(0.0),
            source: Some(format!("second simulator, seed {seed}")),
            ..Keys::default()
        },
        ..Trace::default()
    };
    let samples = (plan.duration_s * f64::from(STEPS_HZ)) as u32 / every;
    for index in 0..samples {
        let mut middle = motion.attitude();
        for step in 0..every {
            let t_s = f64::from(index * every + step) * STEP_S;
            if step == every / 2 {
                middle = motion.attitude();
            }
            let moved = motion.step(t_s, &mut moving);
            let to_body = |v: &Vector3<f64>| moved.attitude.inverse_transform_vector(v);
            let arm = Vector3::from(added.lever_arm_m);
            let turning = moved.rate_rad_s.cross(&moved.rate_rad_s.cross(&arm)) + moved.change_rad_s2.cross(&arm);
            let accelerated = moved.acceleration_m_s2 + turning;
            let gravity = to_body(&Vector3::new(0.0, 0.0, gravity_m_s2));
            let warmer_k = plan.temperature.map_or(0.0, |[_, by]| by * t_s / plan.duration_s);
            sensors.step(&sensors::Moment {
                t_s,
                warmer_k,
                rate_rad_s: moved.rate_rad_s,
                accelerated_m_s2: accelerated,
                force_m_s2: accelerated - gravity,
                field_ut: to_body(&field),
            });
        }
        // The middle of the interval, as the readings are.
        let t_us = u64::from(index) * u64::from(every) * 1_000_000 / u64::from(STEPS_HZ);
        let warm_c = plan.temperature.map(|[from, by]| from + by * t_us as f64 * 1e-6 / plan.duration_s);
        trace.samples.push(sensors.read(t_us, every, warm_c));
        trace.reference.push(Some([middle.w, middle.i, middle.j, middle.k]));
    }
    trace
}
