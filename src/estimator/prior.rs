//! Prior of the globals: their widths, and the centre of P, which is the factory's P or a stored model's.

use super::{
    Settings,
    columns::{GLOBALS, P},
    drift::P_DRIFT,
    real::{M3, Real, zero33},
};
use crate::compensation::{GyroModel, Theta};

#[derive(Clone, Copy)]
pub(super) struct Prior<T> {
    /// Widths, in the globals' units.
    pub sigma: [T; GLOBALS],
    /// Centre of P.
    pub p: M3<T>,
    /// True if P's prior is about a stored model.
    pub is_restored: bool,
    /// Deviations that were stored with the model's P, row-major, in units of the widths; 0: no stored model.
    pub stored_sigma: [T; 9],
}

impl<T: Real> Prior<T> {
    pub const fn zero() -> Self {
        Self { sigma: [T::ZERO; GLOBALS], p: zero33(), is_restored: false, stored_sigma: [T::ZERO; 9] }
    }

    /// The prior about the factory's model.
    pub fn of(settings: &Settings) -> Self {
        Self { sigma: settings.sigma.map(T::of), p: matrix(&settings.factory), ..Self::zero() }
    }

    /// Puts P's prior about a stored model, as wide as its P was known and may have drifted.
    pub fn restore(&mut self, model: &GyroModel, deviations: &Theta) {
        self.p = matrix(model);
        self.is_restored = true;
        for ((column, deviation), stored) in P.columns().zip(deviations).zip(&mut self.stored_sigma) {
            let width = T::of(libm::sqrtf(deviation * deviation + P_DRIFT * P_DRIFT));
            let Some(sigma) = self.sigma.get_mut(column).filter(|sigma| **sigma > T::ZERO) else { continue };
            if *sigma > width {
                *sigma = width;
            }
            *stored = T::of(*deviation) / *sigma;
        }
    }
}

fn matrix<T: Real>(model: &GyroModel) -> M3<T> {
    let p = model.p_matrix();
    M3::from_fn(|i, j| p.get((i, j)).map_or(T::ZERO, |x| T::of(*x)))
}
