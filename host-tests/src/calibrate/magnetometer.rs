//! Calibration of the magnetometer from turns: in any orientation it must read the field's strength. Hard
//! iron shifts the sphere of its readings, soft iron makes it an ellipsoid.

use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::{
        Effect, VectorModel,
        effects::{HardIron, SoftIron},
    },
};
use nalgebra::{Matrix4, Vector3, Vector4};

use super::{
    held_out::HeldOut,
    model::{Covariance, Model, NAMES, Parameters},
    norm_fit::{Observation, Problem},
    sensor::SensorCalibration,
    verdict::{Bounds, Standard, TOO_FEW_TURNS, Verdict, is_beyond_figures},
};
use crate::surveys::settings_file::FIELDS_NT;

/// Distance, as a share of the field, within which readings make one observation (2 deg). The chord of their
/// arc is then too short by at most 5e-5 of the field.
const TOGETHER: f64 = 0.035;

/// Mean readings of a turn in order, one for each two degrees or so; a rest makes one. Readings at full scale
/// are left out.
#[must_use]
pub fn turn(samples: &[Sample]) -> Vec<Vector3<f64>> {
    let unusable = SampleFlags::MAG_MISSING | SampleFlags::MAG_CLIPPED | SampleFlags::FAULT;
    let read = samples.iter().filter(|sample| !sample.flags.intersects(unusable));
    let readings: Vec<Vector3<f64>> = read.map(|sample| Vector3::from(sample.mag_ut).map(f64::from)).collect();
    let extent = |axis: usize| {
        let (low, high) =
            readings.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v[axis]), high.max(v[axis])));
        high - low
    };
    let reach = TOGETHER * 0.5 * (0..3).map(extent).fold(0.0, f64::max);
    let mut means = Vec::new();
    let mut rest = readings.as_slice();
    while let Some(&first) = rest.first() {
        let count = rest.iter().take_while(|v| (*v - first).norm() <= reach).count().max(1);
        means.push(rest[..count].iter().sum::<Vector3<f64>>() / count as f64);
        rest = &rest[count..];
    }
    means
}

/// Prior of a magnetometer without a calibration: the largest soft and hard iron that the library believes.
#[must_use]
pub fn prior() -> Parameters {
    let largest = |effect: &dyn Effect| effect.parameters().first().map_or(1.0, |first| f64::from(first.largest));
    let (soft, hard_ut) = (largest(&SoftIron), largest(&HardIron));
    Parameters::from_fn(|k, _| if k < 6 { soft } else { hard_ut })
}

/// A reading of a turn, and the field of its place where that is stated, microtesla.
pub type Turned = (Vector3<f64>, Option<f64>);

/// Fits nine parameters to the readings of turns, each with the field of its place. Where some state none, one field is
/// taken for all of them, its strength is fitted, and the mean of the three scales stays. `None` without readings.
#[must_use]
pub fn calibrate(turns: &[Turned], record: VectorModel) -> Option<SensorCalibration> {
    let old = Model::from(record);
    let fields = stated(turns);
    let (known, differ) = (fields.len() == turns.len(), fields_differ(turns));
    let norm = match fields.first() {
        Some(first) if known && !differ => *first,
        Some(_) if known => fields.iter().sum::<f64>() / fields.len() as f64,
        _ => sphere_radius(turns, &old)?,
    };
    let observations: Vec<Observation> = observations(turns, known, norm).collect();
    let problem = Problem { observations: &observations, record: old, prior: prior(), correlated: true };
    let found = SensorCalibration::of(&problem, norm, record != VectorModel::IDENTITY, Standard::ClearlyBetter);
    if known {
        return Some(found);
    }
    let mut found = at_mean_scale(found);
    let [least, most] = FIELDS_NT.map(|field_nt| 1e-3 * field_nt);
    let is_earths = (least..=most).contains(&found.norm);
    if differ {
        found.verdict = Verdict::Kept(
            "traces are from places with different fields, and one states none: give it magnetic_field_ut, or leave it out"
                .into(),
        );
    } else if is_beyond_figures(&found.fit) || (!is_earths && found.fit.rank < NAMES.len()) {
        // A field that the turns do not determine says nothing of the unit.
        found.verdict = Verdict::Kept(TOO_FEW_TURNS.into());
    } else if !is_earths {
        found.verdict = Verdict::Kept(format!(
            "the field that fits is {:.2} uT, and the earth's is {least:.0} to {most:.0}: check the magnetometer's unit",
            found.norm
        ));
    }
    Some(found)
}

fn stated(turns: &[Turned]) -> Vec<f64> {
    turns.iter().filter_map(|(_, field_ut)| *field_ut).collect()
}

/// Returns true if the readings are from places with different fields.
pub fn fields_differ(turns: &[Turned]) -> bool {
    stated(turns).windows(2).any(|pair| pair[0] != pair[1])
}

/// The readings with the norm that is required of them: the field of their place if all are `known`, else `norm`. Equal
/// weights: the place's field disturbs, not the sensor's noise. Its sigma is at least a thousandth of the field, about
/// the change of the earth's field in a day.
pub fn observations(turns: &[Turned], known: bool, norm: f64) -> impl Iterator<Item = Observation> {
    turns.iter().map(move |&(raw, field_ut)| {
        let norm = field_ut.filter(|_| known).unwrap_or(norm);
        Observation { raw, norm, sigma: 1e-3 * norm }
    })
}

/// The same calibration with the recorded mean scale and a changed field strength instead.
fn at_mean_scale(mut found: SensorCalibration) -> SensorCalibration {
    let x = found.fit.x;
    let mean = 1.0 + (x[0] + x[1] + x[2]) / 3.0;
    let scale = 1.0 / mean;
    // Derivative of (I + S) / mean: the scale itself, minus a third of each scale through the mean.
    let change = Covariance::from_fn(|row, column| {
        let own = if row == column { if row < 6 { scale } else { 1.0 } } else { 0.0 };
        let value = if row < 3 { 1.0 + x[row] } else { x[row] };
        let through_mean = if row < 6 && column < 3 { value * scale * scale / 3.0 } else { 0.0 };
        own - through_mean
    });
    found.fit.covariance = change * found.fit.covariance * change.transpose();
    for k in 0..6 {
        let one = if k < 3 { 1.0 } else { 0.0 };
        found.fit.x[k] = (one + x[k]) * scale - one;
    }
    found.fit.model = found.record.corrected(&found.fit.x);
    found.fit.residuals.iter_mut().for_each(|residual| *residual *= scale);
    found.norm *= scale;
    found.observations.iter_mut().for_each(|observation| observation.norm *= scale);
    let before = scatter(&found.record, &found.observations);
    found.held_out = found.held_out.map(|h| HeldOut {
        before,
        after: h.after * scale,
        noise: h.noise * scale,
        largest: h.largest * scale,
        ..h
    });
    found.bounds = Bounds::of(&found.fit, &found.record, found.norm);
    found.norm_known = false;
    found
}

/// Error of values in a field of unknown strength: they have no norm to compare with but their own mean, so it is the
/// scatter about that.
pub fn scatter(model: &Model, observations: &[Observation]) -> f64 {
    let norms: Vec<f64> = observations.iter().map(|o| model.calibrate(&o.raw).norm()).collect();
    let own = norms.iter().sum::<f64>() / norms.len().max(1) as f64;
    (norms.iter().map(|norm| (norm - own).powi(2)).sum::<f64>() / norms.len().max(1) as f64).sqrt()
}

/// Radius of a sphere through the readings, by linear least squares (|m|^2 = 2 m.c + r^2 - |c|^2).
fn sphere_radius(turns: &[Turned], record: &Model) -> Option<f64> {
    let vectors: Vec<Vector3<f64>> = turns.iter().map(|(raw, _)| record.calibrate(raw)).collect();
    let (mut normal, mut right, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for vector in &vectors {
        let row = Vector4::new(2.0 * vector.x, 2.0 * vector.y, 2.0 * vector.z, 1.0);
        normal += row * row.transpose();
        right += row * vector.norm_squared();
        squares += vector.norm_squared();
    }
    let mean = (squares / vectors.len().max(1) as f64).sqrt();
    let solved = normal.cholesky().map(|cholesky| cholesky.solve(&right));
    let radius = solved.map(|c| (c[3] + c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt());
    // Readings in a plane fit any radius: the largest reading bounds what is plausible.
    let plausible = radius.filter(|r| r.is_finite() && *r > 0.0 && *r < 10.0 * mean);
    plausible.or_else(|| (mean > 0.0).then_some(mean))
}
