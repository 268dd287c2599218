//! Attitude from the gyro alone: the true one at the start, then nothing but compensated rates.

use meerkat_mwd::compensation::GyroModel;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use testbed::{simulate::earth_rate_rad_s, study::one_window::Run};

/// Between the points at which the attitude is looked at, seconds, as in the paper.
const EVERY_S: f64 = 30.0;

/// Points: six minutes.
const POINTS: usize = 12;

/// Below this inclination the gravity toolface is singular and the magnetic one is scored, rad (the attitude
/// filter's limit).
const NEAR_VERTICAL_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Errors of one flight at its points, degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// Integrated less true inclination.
    pub inclination_deg: Vec<f64>,
    /// Integrated less true toolface, -180 to 180.
    pub toolface_deg: Vec<f64>,
}

impl Drift {
    /// Integrates the run's gyro, compensated by `model`, from the sample on at which the window's result
    /// applies.
    ///
    /// Readings are means over the interval around their times, so the edges of the intervals are stepped
    /// through, with the two-sample coning term (Savage 1998, J. Guid. Control Dyn. 21(1), eq 45: a twelfth
    /// of the cross product of neighbours). The earth's rotation is taken out where the scenario gives a
    /// latitude. `None`: the run is too short.
    #[must_use]
    pub fn of(run: &Run, model: &GyroModel) -> Option<Self> {
        let period_s = f64::from(run.scenario.sample_period_us) * 1e-6;
        let (p, b) = (model.p_matrix().map(f64::from), Vector3::from(model.b_rad_s.map(f64::from)));
        let turned = |index: usize| -> Option<Vector3<f64>> {
            let raw = Vector3::from(run.trace.samples.get(index)?.gyro_rad_s.map(f64::from));
            Some(p * (raw - b) * period_s)
        };
        let truth = |index: usize| -> Option<UnitQuaternion<f64>> {
            let [w, x, y, z] = (*run.trace.reference.get(index)?)?;
            Some(UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
        };
        let earth = UnitQuaternion::from_scaled_axis(-earth_rate_rad_s(&run.scenario) * period_s);
        let every = (EVERY_S / period_s).round() as usize;

        // At the end of the interval around the first sample.
        let mut attitude = truth(run.effect)? * UnitQuaternion::from_scaled_axis(turned(run.effect)? * 0.5);
        let mut before = turned(run.effect)?;
        let mut drift = Self { inclination_deg: Vec::new(), toolface_deg: Vec::new() };
        for step in 1..=POINTS * every {
            let index = run.effect + step;
            let now = turned(index)?;
            if step % every == 0 {
                let there = attitude * UnitQuaternion::from_scaled_axis(now * 0.5);
                let (inclination, toolface) = errors_deg(&there, &truth(index)?);
                drift.inclination_deg.push(inclination);
                drift.toolface_deg.push(toolface);
            }
            attitude = earth * attitude * UnitQuaternion::from_scaled_axis(now + before.cross(&now) / 12.0);
            before = now;
        }
        Some(drift)
    }
}

/// Errors of inclination and toolface, degrees: gravity toolface, and near the vertical magnetic toolface
/// (azimuth plus it).
fn errors_deg(estimate: &UnitQuaternion<f64>, truth: &UnitQuaternion<f64>) -> (f64, f64) {
    let angles = |q: &UnitQuaternion<f64>| {
        let c = q.to_rotation_matrix().into_inner();
        let inclination = c[(2, 0)].hypot(c[(2, 1)]).atan2(c[(2, 2)]);
        let gravity_toolface = c[(2, 1)].atan2(-c[(2, 0)]);
        let magnetic_toolface = (c[(1, 0)] - c[(0, 1)]).atan2(c[(0, 0)] + c[(1, 1)]);
        (inclination, gravity_toolface, magnetic_toolface)
    };
    let (estimate, truth) = (angles(estimate), angles(truth));
    let toolface = if truth.0 < NEAR_VERTICAL_RAD { estimate.2 - truth.2 } else { estimate.1 - truth.1 };
    let wrapped = toolface.sin().atan2(toolface.cos());
    ((estimate.0 - truth.0).to_degrees(), wrapped.to_degrees())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use testbed::simulate::{EarthSettings, Gyro, Hole, Scenario};

    fn noiseless(inclination_deg: f64) -> Run {
        let scenario = Scenario {
            duration_s: 430.0,
            hole: Hole { inclination_deg, ..Hole::default() },
            earth: EarthSettings { latitude_deg: Some(50.0), ..EarthSettings::default() },
            gyro: Gyro { noise_deg_s_rthz: 0.0, bias_walk_deg_s_rts: 0.0, ..Gyro::default() },
            ..Scenario::default()
        };
        Run::simulate(&scenario, 3).unwrap()
    }

    /// Without noise the true parameters integrate to the truth, earth rate (1.5 deg in six minutes) and
    /// coning and all; a bias of 1e-3 deg/s along the tool's axis is 0.36 deg of toolface after six minutes
    /// and none of inclination.
    #[test]
    fn true_parameters_do_not_drift_and_a_bias_along_the_axis_is_toolface() {
        for inclination_deg in [0.0, 45.0] {
            let run = noiseless(inclination_deg);
            let still = Drift::of(&run, &run.true_model()).unwrap();
            assert_eq!(still.inclination_deg.len(), 12);
            assert!(still.inclination_deg.iter().all(|e| e.abs() < 0.05), "{still:?}");
            assert!(still.toolface_deg.iter().all(|e| e.abs() < 0.1), "{still:?}");
            let mut model = run.true_model();
            let along = model.p_matrix().try_inverse().unwrap().column(2) * 1e-3_f32.to_radians();
            for (b, more) in model.b_rad_s.iter_mut().zip(along.iter()) {
                *b += more;
            }
            let drifted = Drift::of(&run, &model).unwrap();
            let (with, without) = (drifted.toolface_deg.last().unwrap(), still.toolface_deg.last().unwrap());
            assert!((with - without + 0.36).abs() < 0.01, "{with} {without}");
            assert!((drifted.inclination_deg.last().unwrap() - still.inclination_deg.last().unwrap()).abs() < 0.01);
        }
    }
}
