//! Limits that a stored model has to keep before it may fly, so that a damaged or foreign one never does.

use super::{StoredModel, fingerprint};
use crate::{
    compensation::{Effect, GyroModel},
    config::Config,
    sample::TEMPERATURES_C,
};
use nalgebra::Vector3;

/// Largest distance of a parameter from the factory's, in deviations of the prior. With the default prior these are
/// 30 % of scale, 15 % of coupling and 6 deg/s of bias. A common part's data sheet allows 3 %, 2 % and 5 deg/s
/// (MPU-9250 product specification PS-MPU-9250A-01, section 3.1), so a larger distance is not wear.
const PLAUSIBLE_SIGMAS: f32 = 5.0;

/// Limits for a stored model.
#[derive(Clone, Copy)]
pub struct Limits {
    factory: GyroModel,
    /// Limit of P's diagonal, dimensionless.
    scale: f32,
    /// Limit of P's other elements, dimensionless.
    coupling: f32,
    /// Limit of the product P b, the bias at the output, rad/s.
    bias_rad_s: f32,
    library: &'static [&'static dyn Effect],
    pub(super) fingerprint: u32,
}

/// Reason for which a stored model may not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// A number is infinite or NaN, or P cannot be inverted.
    NotAModel,
    /// An element of P is too far from the factory's.
    P {
        /// Row.
        row: u8,
        /// Column.
        column: u8,
        /// Distance.
        off: f32,
        /// Largest distance allowed.
        limit: f32,
    },
    /// The bias is too far from the factory's.
    Bias {
        /// Axis.
        axis: u8,
        /// Distance, rad/s.
        off_rad_s: f32,
        /// Largest distance allowed, rad/s.
        limit_rad_s: f32,
    },
    /// A deviation is negative or larger than the limit of its parameter.
    Sigma {
        /// Index of the parameter, of twelve.
        index: u8,
    },
    /// The temperatures are not a range, or no electronics works there.
    Temperature,
    /// The model's effects are numbered in another library than this firmware's, or are relative to another calibration
    /// or latency than the configuration's.
    OtherLibrary,
    /// An effect is not in the library, is there twice, or has an implausible parameter.
    Effect {
        /// Place of the effect in the library.
        index: u8,
        /// Parameter; `None` for the effect itself.
        parameter: Option<u8>,
    },
}

impl Implausible {
    /// Returns true if a model that may not fly for this reason may fly with another configuration.
    pub(super) const fn is_of_the_configuration(self) -> bool {
        matches!(self, Self::OtherLibrary | Self::P { .. } | Self::Bias { .. } | Self::Sigma { .. })
    }
}

impl Limits {
    /// Limits of a valid configuration, with the library of effects.
    #[must_use]
    pub fn new(config: &Config, library: &'static [&'static dyn Effect]) -> Self {
        let prior = &config.identification;
        Self {
            factory: config.gyro,
            scale: PLAUSIBLE_SIGMAS * prior.prior_sigma_diagonal,
            coupling: PLAUSIBLE_SIGMAS * prior.prior_sigma_off_diagonal,
            bias_rad_s: PLAUSIBLE_SIGMAS * prior.prior_sigma_bias_rad_s,
            library,
            fingerprint: fingerprint(library, config),
        }
    }

    /// Returns true if both allow the same models.
    pub(super) fn are(&self, other: &Self) -> bool {
        let of =
            |limits: &Self| (limits.factory, [limits.scale, limits.coupling, limits.bias_rad_s], limits.fingerprint);
        of(self) == of(other)
    }

    /// Checks that a model may fly.
    ///
    /// # Errors
    /// Names the first violation.
    pub fn check(&self, model: &StoredModel) -> Result<(), Implausible> {
        if !model.gyro.is_valid() {
            return Err(Implausible::NotAModel);
        }
        let in_row = |row: u8| {
            model
                .gyro
                .p
                .iter()
                .zip(&self.factory.p)
                .nth(usize::from(row))
                .into_iter()
                .flat_map(|(p, f)| p.iter().zip(f))
        };
        for row in 0..3 {
            for (column, (p, factory)) in (0..3).zip(in_row(row)) {
                let (off, limit) = (libm::fabsf(p - factory), if row == column { self.scale } else { self.coupling });
                if off > limit {
                    return Err(Implausible::P { row, column, off, limit });
                }
            }
        }
        let of = |model: &GyroModel| model.p_matrix() * Vector3::from(model.b_rad_s);
        for (axis, off) in (0..3).zip((of(&model.gyro) - of(&self.factory)).iter()) {
            let off_rad_s = libm::fabsf(*off);
            // The product of finite numbers need not be finite.
            if off_rad_s > self.bias_rad_s || !off_rad_s.is_finite() {
                return Err(Implausible::Bias { axis, off_rad_s, limit_rad_s: self.bias_rad_s });
            }
        }
        for (index, sigma) in (0..12).zip(&model.sigma) {
            let most = if index < 9 { self.scale } else { self.bias_rad_s };
            if !(0.0..=most).contains(sigma) {
                return Err(Implausible::Sigma { index });
            }
        }
        let [coldest, hottest] = TEMPERATURES_C;
        if model.temperature_c.is_some_and(|[low, high]| !(coldest <= low && low <= high && high <= hottest)) {
            return Err(Implausible::Temperature);
        }
        self.check_effects(model)
    }

    fn check_effects(&self, model: &StoredModel) -> Result<(), Implausible> {
        if model.effects.is_empty() {
            return Ok(());
        }
        if model.library != self.fingerprint {
            return Err(Implausible::OtherLibrary);
        }
        for found in model.effects.iter() {
            let index = found.index;
            let twice = model.effects.iter().filter(|other| other.index == index).count() > 1;
            let effect = self.library.get(usize::from(index)).filter(|_| !twice);
            let Some(effect) = effect else { return Err(Implausible::Effect { index, parameter: None }) };
            for (k, (value, sigma)) in (0..).zip(found.parameters.iter().zip(&found.sigma)) {
                let believed = match effect.parameters().get(usize::from(k)) {
                    Some(parameter) => parameter.believes(*value) && sigma.is_finite() && *sigma >= 0.0,
                    None => *value == 0.0 && *sigma == 0.0,
                };
                if !believed {
                    return Err(Implausible::Effect { index, parameter: Some(k) });
                }
            }
        }
        Ok(())
    }
}
