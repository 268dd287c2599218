//! Continuous survey: one at every sample, from the attitude filter's output.

use super::{
    Survey, SurveyInput, SurveyKind, Uncertain,
    record::{Angles, ToolfaceSwitch},
    sensor_errors,
    stationary::OLDEST_EVIDENCE_US,
};
use crate::{
    attitude::{Attitude, AttitudeFlags, ToolAngleSigmas, ToolAngles, positive_angle},
    config::{Earth, SurveyConfig},
    rotation::{rotate, sine_and_cosine},
};
use core::f32::consts::{PI, TAU};
use nalgebra::{Quaternion, Vector3};

/// Time constant that smooths |G|, |B| and dip, seconds: over the periods of vibration, and as fast as an eye reads.
const SMOOTHING_S: f32 = 1.0;
/// Age of the last reading from which on |G|, |B| and dip are not known, seconds.
const OLDEST_S: f32 = OLDEST_EVIDENCE_US as f32 * 1e-6;

/// Latest attitude, with smoothed |G|, |B| and dip.
pub(crate) struct Continuous {
    last: Option<(u64, Attitude)>,
    gravity: Smooth,
    field: Smooth,
    dip: Smooth,
    /// Latest force and field, tool axes, for the sensors' part of the sigmas.
    force_m_s2: Vector3<f32>,
    field_ut: Vector3<f32>,
    temperature_c: Option<f32>,
}

impl Continuous {
    pub(crate) const fn new() -> Self {
        Self {
            last: None,
            gravity: Smooth::NONE,
            field: Smooth::NONE,
            dip: Smooth::NONE,
            force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            field_ut: Vector3::new(0.0, 0.0, 0.0),
            temperature_c: None,
        }
    }

    pub(crate) fn push(&mut self, input: &SurveyInput, step_s: f32) {
        [&mut self.gravity, &mut self.field, &mut self.dip].into_iter().for_each(|smooth| smooth.unread_s += step_s);
        self.last = input.attitude.map(|attitude| (input.t_us, attitude));
        self.temperature_c = input.temperature_c;
        if let Some(force) = input.force_m_s2 {
            self.force_m_s2 = force.into();
            self.gravity.add(libm::sqrtf(self.force_m_s2.norm_squared()));
        }
        if let (Some(field), Some(attitude)) = (input.field_ut, &input.attitude) {
            self.field_ut = field.into();
            self.field.add(libm::sqrtf(self.field_ut.norm_squared()));
            let [w, x, y, z] = attitude.q;
            let ned = rotate(&Quaternion::new(w, x, y, z), &self.field_ut);
            self.dip.add(libm::atan2f(ned.z, libm::sqrtf(ned.x * ned.x + ned.y * ned.y)));
        }
    }

    /// Returns the survey at the last sample; `None` if it had no attitude.
    pub(crate) fn survey(
        &self,
        mut toolface: ToolfaceSwitch,
        rotating: bool,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<Survey> {
        let (t_us, attitude) = self.last.as_ref()?;
        let field = self.field.value();
        let dip = self.dip.value();
        let horizontal_ut = match (field, dip, earth.magnetic_field_ut, earth.dip_rad) {
            (Some(total), Some(dip), ..) | (.., Some(total), Some(dip)) => total * sine_and_cosine(dip).1,
            _ => 0.0,
        };
        let known = angles(attitude, horizontal_ut, earth);
        let settings = (earth, config);
        let mut survey = Survey::of_angles(SurveyKind::Continuous, [*t_us, *t_us], &known, &mut toolface, settings);
        let errors = &config.errors;
        let of_force = sensor_errors::gravity_covariance(&self.force_m_s2, errors);
        let of_field = sensor_errors::field_covariance(&self.field_ut, errors);
        let along = |v: &Vector3<f32>, variance: f32| {
            let squared = v.norm_squared();
            if squared > 0.0 { variance / squared } else { 0.0 }
        };
        let [of_gravity, of_total] = [(&self.force_m_s2, of_force), (&self.field_ut, of_field)]
            .map(|(v, covariance)| along(v, v.dot(&(covariance * v))));
        survey.gravity_m_s2 = self.gravity.uncertain(of_gravity);
        survey.field_ut = self.field.uncertain(of_total);
        // Both directions across the field are equally uncertain, and so are horizon and inclination.
        let across = along(&self.field_ut, of_field.trace() / 3.0);
        let tilt = attitude.sigma_inclination_rad * attitude.sigma_inclination_rad;
        survey.dip_rad = self.dip.uncertain(across + tilt);
        survey.temperature_c = self.temperature_c;
        survey.rotating = rotating;
        Some(survey)
    }
}

/// Converts the filter's angles to angles from magnetic north. The filter states a sigma for one toolface;
/// the other's follows from those of inclination and azimuth, with equal tilt in both directions: gravity
/// toolface sigma_I / sin I; magnetic toolface that of the heading, sigma_A^2 - (sigma_I / tan I)^2, plus
/// (sigma_I tan(I / 2))^2.
fn angles(attitude: &Attitude, horizontal_ut: f32, earth: &Earth) -> Angles {
    let declination = earth.declination_rad.unwrap_or(0.0);
    let from_magnetic = |angle: f32| positive_angle(libm::remainderf(angle - declination, TAU));
    let (inclination, azimuth) = (attitude.sigma_inclination_rad, attitude.sigma_azimuth_rad);
    let (s, c) = sine_and_cosine(attitude.inclination_rad);
    let sine = if s > 1e-6 { s } else { 1e-6 };
    let capped = |sigma: f32| if sigma < PI { sigma } else { PI };
    let near_vertical = attitude.flags.contains(AttitudeFlags::NEAR_VERTICAL);
    let gravity_toolface_rad = if near_vertical { capped(inclination / sine) } else { attitude.sigma_toolface_rad };
    let magnetic_toolface_rad = if near_vertical {
        attitude.sigma_toolface_rad
    } else {
        let of_tilt = inclination * c / sine;
        let without_tilt = azimuth * azimuth - of_tilt * of_tilt;
        // The tilt is not equal in both directions; the azimuth's includes the heading's in any case.
        let heading = if without_tilt > 0.0 { without_tilt } else { azimuth * azimuth };
        let cosine_plus_one = if c > -1.0 + 1e-6 { 1.0 + c } else { 1e-6 };
        let tilted = inclination * s / cosine_plus_one;
        capped(libm::sqrtf(heading + tilted * tilted))
    };
    Angles {
        angles: ToolAngles {
            inclination_rad: attitude.inclination_rad,
            azimuth_rad: from_magnetic(attitude.azimuth_rad),
            gravity_toolface_rad: attitude.gravity_toolface_rad,
            magnetic_toolface_rad: from_magnetic(attitude.magnetic_toolface_rad),
        },
        sigmas: ToolAngleSigmas {
            inclination_rad: inclination,
            azimuth_rad: azimuth,
            gravity_toolface_rad,
            magnetic_toolface_rad,
        },
        north_known: !attitude.flags.contains(AttitudeFlags::NO_HEADING),
        horizontal_ut,
    }
}

/// Exponential mean and variance of a number, as long as it is read.
#[derive(Clone, Copy)]
struct Smooth {
    mean: f32,
    variance: f32,
    /// Time that the mean spans, at most some [`SMOOTHING_S`], seconds; negative before the first reading.
    age_s: f32,
    /// Time since the last reading, seconds.
    unread_s: f32,
}

impl Smooth {
    const NONE: Self = Self { mean: 0.0, variance: 0.0, age_s: -1.0, unread_s: 0.0 };

    fn add(&mut self, x: f32) {
        if !self.is_known() {
            *self = Self { mean: x, variance: 0.0, age_s: 0.0, unread_s: 0.0 };
            return;
        }
        let step_s = core::mem::replace(&mut self.unread_s, 0.0);
        // Until one time constant has passed, `mean` is the mean of all values.
        self.age_s += if self.age_s < SMOOTHING_S { step_s } else { 0.0 };
        let k = if self.age_s + step_s > 0.0 { step_s / (self.age_s + step_s) } else { 0.5 };
        let d = x - self.mean;
        self.mean += k * d;
        self.variance = (1.0 - k) * (self.variance + k * d * d);
    }

    const fn is_known(&self) -> bool {
        self.age_s >= 0.0 && self.unread_s < OLDEST_S
    }

    fn value(&self) -> Option<f32> {
        self.is_known().then_some(self.mean)
    }

    /// Returns the mean; its sigma combines the scatter of single readings with the sensors' `variance`.
    fn uncertain(&self, variance: f32) -> Option<Uncertain> {
        self.value().map(|value| Uncertain { value, sigma: libm::sqrtf(self.variance + variance) })
    }
}

#[cfg(test)]
mod tests;
