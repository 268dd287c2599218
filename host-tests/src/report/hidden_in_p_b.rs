//! Effects of the gyro that, in the motion of a recording, act as its P and b do, so that nobody can tell them from
//! these.

use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::{
        effect::{Effect, REFERENCE_TEMPERATURE_C, Sensor, Snapshot},
        effects::LIBRARY,
    },
};
use nalgebra::{Matrix4, Vector3, Vector4};

use crate::diagnosis::Diagnosed;
use testbed::{flight::Flight, trace::Trace};

/// Share of a term's mean square that P and b leave, below which it is theirs: a tenth of its size.
const LEFT: f64 = 0.01;
/// Time over which readings and terms are averaged, seconds.
const MEAN_S: f64 = 0.2;

/// Effects that are hidden, in a sentence; `None` if none is. An effect that was found is not hidden.
#[must_use]
pub fn hidden_text(trace: &Trace, flight: &Flight, diagnosed: &Diagnosed) -> Option<String> {
    let snapshots = snapshots(trace, flight);
    let is_found = |effect: &dyn Effect| diagnosed.effects.iter().any(|found| found.effect.name() == effect.name());
    let names: Vec<&str> = LIBRARY
        .iter()
        .filter(|effect| effect.sensor() == Sensor::Gyro && !effect.is_bias_step() && !is_found(**effect))
        .filter(|effect| left(**effect, &snapshots).is_some_and(|left| left < LEFT))
        .map(|effect| effect.name())
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "in this motion a bias or a scale of the gyro looks like {}: P and b hold what there is of it. Another \
             inclination, speed or temperature would show it",
            names.join(", ")
        )
    })
}

/// Share of the mean square of an effect's terms that the best bias and scale leave; `None` where the terms are zero.
fn left(effect: &dyn Effect, snapshots: &[Snapshot]) -> Option<f64> {
    let regressors = |snapshot: &Snapshot| snapshot.rate_rad_s.map(f64::from).insert_row(0, 1.0);
    let normal: Matrix4<f64> = snapshots.iter().map(regressors).map(|x: Vector4<f64>| x * x.transpose()).sum();
    // A rate that never was counts for nothing.
    let inverse = (normal + Matrix4::identity() * (1e-9 * normal.trace())).try_inverse()?;
    let (mut all, mut left) = (0.0, 0.0);
    for k in 0..effect.parameters().len() {
        let terms: Vec<Vector3<f64>> =
            snapshots.iter().map(|snapshot| effect.term(k, snapshot).map(f64::from)).collect();
        for axis in 0..3 {
            let square: f64 = terms.iter().map(|term| term[axis] * term[axis]).sum();
            let along: Vector4<f64> = snapshots.iter().zip(&terms).map(|(s, term)| regressors(s) * term[axis]).sum();
            all += square;
            left += square - along.dot(&(inverse * along));
        }
    }
    (all > 0.0).then(|| left / all)
}

/// Means of the readings, as the terms take them.
fn snapshots(trace: &Trace, flight: &Flight) -> Vec<Snapshot> {
    let mut means = Vec::new();
    let (mut sum, mut squares, mut count) = ([Vector3::<f32>::zeros(); 3], 0.0_f32, 0.0_f32);
    let mut warming = 0.0;
    let mut since_us = trace.first_us();
    let mut last_rate: Option<Vector3<f32>> = None;
    let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING;
    for (sample, output) in trace.samples().zip(flight.by_sample()) {
        let Sample { t_us, accel_m_s2, mag_ut, temperature_c, flags, .. } = sample;
        let Some(output) = output.filter(|_| !flags.intersects(missing)) else { continue };
        let force = Vector3::from(accel_m_s2);
        sum[0] += Vector3::from(output.rate_rad_s);
        sum[1] += force;
        sum[2] += Vector3::from(mag_ut);
        squares += force.norm_squared();
        count += 1.0;
        if !flags.contains(SampleFlags::TEMPERATURE_MISSING) {
            warming = temperature_c - REFERENCE_TEMPERATURE_C;
        }
        let passed_s = t_us.saturating_sub(since_us) as f64 * 1e-6;
        if passed_s >= MEAN_S {
            let [rate_rad_s, force_m_s2, field_ut] = sum.map(|sum| sum / count);
            let before = last_rate.replace(rate_rad_s).unwrap_or(rate_rad_s);
            means.push(Snapshot {
                rate_rad_s,
                acceleration_rad_s2: (rate_rad_s - before) / passed_s as f32,
                force_m_s2,
                square_force_m2_s4: squares / count,
                field_ut,
                warming_k: warming,
            });
            (sum, squares, count, since_us) = ([Vector3::zeros(); 3], 0.0, 0.0, t_us);
        }
    }
    means
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use testbed::{
        flight::{configuration::of_trace, fly_with},
        simulate::{Hole, Rotation, Scenario, simulate},
    };

    fn hidden(inclination_deg: f64, stick_slip: f64) -> Vec<&'static str> {
        let scenario = Scenario {
            duration_s: 60.0,
            hole: Hole { inclination_deg, ..Hole::default() },
            rotation: Rotation { mean_rpm: 30.0, stick_slip, ..Rotation::default() },
            ..Scenario::default()
        };
        let (trace, _) = simulate(&scenario, 5);
        let flight = fly_with(&LIBRARY, &of_trace(&trace), None, &trace.samples).unwrap();
        let snapshots = snapshots(&trace, &flight);
        let is_hidden = |effect: &&&dyn Effect| left(**effect, &snapshots).is_some_and(|left| left < LEFT);
        LIBRARY.iter().filter(|effect| effect.sensor() == Sensor::Gyro).filter(is_hidden).map(|e| e.name()).collect()
    }

    #[test]
    fn g_sensitivity_hides_in_a_vertical_hole_and_a_bent_scale_in_steady_rotation() {
        let vertical = hidden(0.0, 0.9);
        assert!(vertical.contains(&"g_sensitivity") && !vertical.contains(&"gyro_scale_nonlinearity"), "{vertical:?}");
        let steady = hidden(60.0, 0.0);
        assert!(steady.contains(&"gyro_scale_nonlinearity") && !steady.contains(&"g_sensitivity"), "{steady:?}");
        let swinging = hidden(60.0, 0.9);
        assert!(!swinging.iter().any(|name| ["g_sensitivity", "gyro_scale_nonlinearity", "gyro_lag"].contains(name)));
    }
}
