//! Axial interference at one station: the field along the tool axis from the reference instead of from the
//! magnetometer that the drill string disturbs (short-collar correction).
//!
//! The axial magnetometer reading is not used. Total field and dip of the reference determine the axial field: the
//! first in a circle about the transverse field, the second in a plane across gravity (ISCWSA, Introduction to wellbore
//! positioning, appendix D6). Both are weighted by their certainty at this attitude. In a level hole to the east or
//! west neither of them depends on the azimuth, and the correction is worse than the interference: its no-go zone.

use super::{
    Uncertain,
    multi_station::Station,
    station_axes::{Axes, Gradient},
};
use crate::{attitude::positive_angle, config::SurveyErrors};
use core::f32::consts::{PI, TAU};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Largest number of Gauss-Newton steps.
const STEPS: usize = 20;
/// Step of the axial field below which the iteration ends, microtesla: a tenth of a nanotesla.
const LAST_STEP_UT: f32 = 1e-4;
/// Size of the last step from which the axial field counts as not determined, microtesla: where total field and dip
/// hardly change with it, the steps alternate without converging.
const FLAT_UT: f32 = 0.01;
/// Largest axial interference that is looked for, microtesla.
const LARGEST_UT: f32 = 20.0;

/// Short-collar correction of one station.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxialCorrection {
    /// Axial interference: measured less corrected axial field, microtesla; its sigma is the correction's.
    pub interference_ut: Uncertain,
    /// Azimuth with the corrected axial field, from magnetic north, radians, 0 to 2 pi.
    pub magnetic_azimuth_rad: Uncertain,
    /// Azimuth as measured; its sigma includes the drill string's field of the error model.
    pub measured_azimuth_rad: Uncertain,
    /// True in the no-go zone: the corrected azimuth is less certain than the measured one.
    pub no_go: bool,
    /// Sine of the inclination times the cosine of the angle from magnetic east or west: 1 level to the east, where
    /// the correction fails, 0 in the meridian.
    pub eastward: f32,
}

/// Variances of the readings and references that an azimuth is computed from.
struct Variances {
    force: Vector3<f32>,
    field: Vector3<f32>,
    /// Total field and dip of the reference.
    reference: Vector2<f32>,
}

impl Variances {
    fn of(force: &Vector3<f32>, field: &Vector3<f32>, errors: &SurveyErrors) -> Self {
        let by_axis = |v: &Vector3<f32>, bias: f32, scale: f32| v.map(|x| bias * bias + scale * scale * x * x);
        let [total, dip] = [errors.total_field_ut, errors.dip_rad];
        Self {
            force: by_axis(force, errors.accel_bias_m_s2, errors.accel_scale),
            field: by_axis(field, errors.mag_bias_ut, errors.mag_scale),
            reference: Vector2::new(total * total, dip * dip),
        }
    }

    fn of_gradient(&self, gradient: &Gradient) -> f32 {
        weighed(&gradient.force, &self.force) + weighed(&gradient.field, &self.field)
    }
}

impl AxialCorrection {
    /// Corrects a station; `None` if it is not usable, or if no axial field within 20 microtesla of the measured one
    /// agrees with the reference.
    #[must_use]
    pub fn of(station: &Station, errors: &SurveyErrors) -> Option<Self> {
        let (force, measured) = (Vector3::from(station.force_m_s2), Vector3::from(station.field_ut));
        let before = Axes::of(&force, &measured)?;
        let mut field = measured;
        let mut gain = Vector2::zeros();
        let mut step = f32::INFINITY;
        for _ in 0..STEPS {
            let axes = Axes::of(&force, &field)?;
            let slope = Vector2::new(field.z / axes.field_ut, axes.dip_gradient().field.z);
            let inverse = covariance(&axes, &force, &field, errors).try_inverse()?;
            let weights = inverse * slope;
            let information = weights.dot(&slope);
            gain = if information > 0.0 { weights / information } else { return None };
            let residual =
                Vector2::new(axes.field_ut - station.reference.field_ut, axes.dip_rad - station.reference.dip_rad);
            step = gain.dot(&residual);
            field.z -= step;
            // A NaN is not within the limit either.
            let plausible = libm::fabsf(field.z - measured.z) < LARGEST_UT;
            if !plausible {
                return None;
            }
            if libm::fabsf(step) < LAST_STEP_UT {
                break;
            }
        }
        let after = Axes::of(&force, &field)?;
        let (z_variance, azimuth_variance) = corrected_variances(&after, &force, &field, &gain, errors);
        let interference = errors.axial_interference_ut * before.azimuth_gradient().field.z;
        let uncorrected = Variances::of(&force, &measured, errors).of_gradient(&before.azimuth_gradient())
            + interference * interference;
        let (better, ended) = (azimuth_variance < uncorrected, libm::fabsf(step) < FLAT_UT);
        Some(Self {
            interference_ut: Uncertain { value: measured.z - field.z, sigma: libm::sqrtf(z_variance) },
            magnetic_azimuth_rad: angle(after.azimuth_rad(), azimuth_variance),
            measured_azimuth_rad: angle(before.azimuth_rad(), uncorrected),
            no_go: !(better && ended),
            eastward: libm::fabsf(after.east.z),
        })
    }
}

/// Gradients of total field and dip by all readings but the axial field.
fn transverse_gradients(axes: &Axes, field: &Vector3<f32>) -> [Gradient; 2] {
    let total = Gradient { force: Vector3::zeros(), field: field / axes.field_ut };
    [total, axes.dip_gradient()]
        .map(|gradient| Gradient { field: Vector3::new(gradient.field.x, gradient.field.y, 0.0), ..gradient })
}

/// Covariance of measured less reference total field and dip, the axial field being free.
fn covariance(axes: &Axes, force: &Vector3<f32>, field: &Vector3<f32>, errors: &SurveyErrors) -> Matrix2<f32> {
    let variances = Variances::of(force, field, errors);
    let [total, dip] = transverse_gradients(axes, field);
    let both = weighed_pair(&total.force, &dip.force, &variances.force)
        + weighed_pair(&total.field, &dip.field, &variances.field);
    Matrix2::new(
        variances.of_gradient(&total) + variances.reference.x,
        both,
        both,
        variances.of_gradient(&dip) + variances.reference.y,
    )
}

/// Variances of the corrected axial field and of the azimuth with it: readings and reference enter the azimuth
/// directly and through the axial field, z = -gain (total, dip).
fn corrected_variances(
    axes: &Axes,
    force: &Vector3<f32>,
    field: &Vector3<f32>,
    gain: &Vector2<f32>,
    errors: &SurveyErrors,
) -> (f32, f32) {
    let variances = Variances::of(force, field, errors);
    let [total, dip] = transverse_gradients(axes, field);
    let axial = Gradient {
        force: -(total.force * gain.x + dip.force * gain.y),
        field: -(total.field * gain.x + dip.field * gain.y),
    };
    let of_reference = weighed_2(gain, &variances.reference);
    let azimuth = axes.azimuth_gradient();
    let by_axial = azimuth.field.z;
    let transverse = Vector3::new(azimuth.field.x, azimuth.field.y, 0.0);
    let whole = Gradient { force: azimuth.force + axial.force * by_axial, field: transverse + axial.field * by_axial };
    let axial_variance = variances.of_gradient(&axial) + of_reference;
    (axial_variance, variances.of_gradient(&whole) + by_axial * by_axial * of_reference)
}

fn weighed(v: &Vector3<f32>, variances: &Vector3<f32>) -> f32 {
    weighed_pair(v, v, variances)
}

fn weighed_pair(a: &Vector3<f32>, b: &Vector3<f32>, variances: &Vector3<f32>) -> f32 {
    a.component_mul(b).dot(variances)
}

fn weighed_2(v: &Vector2<f32>, variances: &Vector2<f32>) -> f32 {
    v.x * v.x * variances.x + v.y * v.y * variances.y
}

fn angle(value: f32, variance: f32) -> Uncertain {
    let sigma = if variance < PI * PI { libm::sqrtf(variance) } else { PI };
    Uncertain { value: positive_angle(libm::remainderf(value, TAU)), sigma }
}

#[cfg(test)]
mod tests;
