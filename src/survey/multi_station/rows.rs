//! Rows of one station: three residuals and their derivatives by the errors.

use super::{
    MultiStationSettings, PARAMETERS, Station,
    parameters::{GROWTH, REFERENCES},
};
use crate::survey::station_axes::{Axes, Gradient};
use nalgebra::Vector3;

/// Errors in units of their priors' standard deviations.
pub(super) type Whitened = [f32; PARAMETERS];

/// Standard deviations by which errors and residuals are scaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    /// Priors of the errors.
    pub(super) prior: [f32; PARAMETERS],
    pub(super) settings: MultiStationSettings,
    /// Factor of the noise's standard deviation.
    pub(super) noise: f32,
    /// Depth of the first station and distance to the last, in the unit of `depth_m`.
    pub(super) run: [f32; 2],
}

/// Residuals of |G|, |B| and dip (measured less reference), and their derivatives by the errors, all divided by the
/// noise's standard deviations.
pub(super) struct Rows {
    pub(super) residual: [f32; 3],
    pub(super) derivative: [Whitened; 3],
}

/// Vectors of a station with the errors taken out, and the values needed for derivatives by the errors.
pub(super) struct Freed {
    pub(super) axes: Axes,
    force: Vector3<f32>,
    field: Vector3<f32>,
    /// 1 + scale factors.
    force_scale: Vector3<f32>,
    field_scale: Vector3<f32>,
    /// Share of the axial growth at this station.
    grown: f32,
}

impl Scales {
    fn value(&self, x: &Whitened, k: usize) -> f32 {
        match (x.get(k), self.prior.get(k)) {
            (Some(x), Some(sigma)) => x * sigma,
            _ => 0.0,
        }
    }

    fn three(&self, x: &Whitened, first: usize) -> Vector3<f32> {
        Vector3::new(self.value(x, first), self.value(x, first + 1), self.value(x, first + 2))
    }

    /// Place of a station along the run: 0 at the first, 1 at the last, beyond 1 after it.
    fn grown(&self, station: &Station) -> f32 {
        let [first, length] = self.run;
        if length > 0.0 { (station.depth_m - first) / length } else { 0.0 }
    }

    /// Takes the errors out of a station's vectors.
    pub(super) fn freed(&self, station: &Station, x: &Whitened) -> Option<Freed> {
        let ones = Vector3::new(1.0, 1.0, 1.0);
        let (force_scale, field_scale) = (ones + self.three(x, 3), ones + self.three(x, 9));
        let grown = self.grown(station);
        let axial = Vector3::new(0.0, 0.0, grown * self.value(x, GROWTH));
        let force = (Vector3::from(station.force_m_s2) - self.three(x, 0)).component_div(&force_scale);
        let field = (Vector3::from(station.field_ut) - self.three(x, 6) - axial).component_div(&field_scale);
        Axes::of(&force, &field).map(|axes| Freed { axes, force, field, force_scale, field_scale, grown })
    }

    /// Standard deviations of |G|, |B| and dip at a station.
    fn noise(&self, axes: &Axes) -> [f32; 3] {
        let MultiStationSettings { force_noise_m_s2, field_noise_ut, total_field_noise_ut, dip_noise_rad, .. } =
            self.settings;
        let of_sensors = libm::hypotf(force_noise_m_s2 / axes.gravity_m_s2, field_noise_ut / axes.field_ut);
        [force_noise_m_s2, libm::hypotf(field_noise_ut, total_field_noise_ut), libm::hypotf(of_sensors, dip_noise_rad)]
            .map(|sigma| sigma * self.noise)
    }

    /// Variance of an angle by the sensors' noise at one station.
    pub(super) fn noise_variance(&self, gradient: &Gradient) -> f32 {
        let [force, field] = [self.settings.force_noise_m_s2, self.settings.field_noise_ut].map(|x| x * self.noise);
        force * force * gradient.force.norm_squared() + field * field * gradient.field.norm_squared()
    }

    /// Derivative of an angle by the errors.
    pub(super) fn by_errors(&self, freed: &Freed, gradient: &Gradient) -> Whitened {
        let by_bias = gradient.force.component_div(&freed.force_scale);
        let by_field_bias = gradient.field.component_div(&freed.field_scale);
        let by_scale = by_bias.component_mul(&freed.force);
        let by_field_scale = by_field_bias.component_mul(&freed.field);
        let parts = [by_bias, by_scale, by_field_bias, by_field_scale];
        let sensors = parts.iter().flat_map(|v| v.iter()).copied().chain([by_field_bias.z * freed.grown]);
        let mut derivative = [0.0; PARAMETERS];
        for ((out, value), sigma) in derivative.iter_mut().zip(sensors).zip(&self.prior) {
            *out = -value * sigma;
        }
        derivative
    }

    /// Residuals and derivatives of a station with the errors `x`.
    pub(super) fn rows(&self, station: &Station, x: &Whitened) -> Option<Rows> {
        let freed = self.freed(station, x)?;
        let axes = &freed.axes;
        let reference = station.reference;
        let gravity = Gradient { force: freed.force / axes.gravity_m_s2, field: Vector3::zeros() };
        let field = Gradient { force: Vector3::zeros(), field: freed.field / axes.field_ut };
        let measured = [
            (axes.gravity_m_s2 - reference.gravity_m_s2, gravity),
            (axes.field_ut - reference.field_ut, field),
            (axes.dip_rad - reference.dip_rad, axes.dip_gradient()),
        ];
        let mut rows = Rows { residual: [0.0; 3], derivative: [[0.0; PARAMETERS]; 3] };
        let noise = self.noise(axes);
        for (k, ((difference, gradient), sigma)) in measured.into_iter().zip(noise).enumerate() {
            let mut derivative = self.by_errors(&freed, &gradient);
            if let (Some(by_reference), Some(prior)) =
                (derivative.get_mut(REFERENCES + k), self.prior.get(REFERENCES + k))
            {
                *by_reference = -prior;
            }
            let residual = (difference - self.value(x, REFERENCES + k)) / sigma;
            if let (Some(to), Some(row)) = (rows.residual.get_mut(k), rows.derivative.get_mut(k)) {
                *to = residual;
                *row = derivative.map(|value| value / sigma);
            }
        }
        Some(rows)
    }
}
