//! The gyro's twelve parameters at the end of a flight, for the JSON and the summary.

use meerkat_mwd::{Config, compensation::GyroModel};
use serde::Serialize;

use testbed::flight::Flight;

/// A gyro model with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// P, row-major, dimensionless.
    #[serde(rename = "P")]
    pub p: [f32; 9],
    /// b, rad/s.
    pub b_rad_s: [f32; 3],
    /// 1-sigma of P then b.
    pub sigma: [f32; 12],
    /// Which of the 12 the data observe.
    pub observable: [bool; 12],
    /// Number of independent directions that the data observe.
    pub rank: u8,
    /// True if `sigma` is the prior's: no window was accepted.
    #[serde(skip)]
    pub is_prior: bool,
}

impl Parameters {
    pub(super) fn new(model: &GyroModel, sigma: [f32; 12], observable: [bool; 12], rank: u8) -> Self {
        let [r0, r1, r2] = model.p;
        let p = [r0[0], r0[1], r0[2], r1[0], r1[1], r1[2], r2[0], r2[1], r2[2]];
        Self { p, b_rad_s: model.b_rad_s, sigma, observable, rank, is_prior: false }
    }

    /// The model that flies at the end. Its uncertainty is that of the last accepted window; the prior's if none was,
    /// and then the model comes from updates between windows, from a stored model or from the factory.
    #[must_use]
    pub fn at_the_end(config: &Config, flight: &Flight) -> Self {
        let model = flight.last_model().unwrap_or(&config.gyro);
        match flight.standing() {
            Some(report) => Self::new(model, report.sigma, report.observable, report.rank),
            None => Self { is_prior: true, ..Self::new(model, prior_sigma(config), [false; 12], 0) },
        }
    }
}

fn prior_sigma(config: &Config) -> [f32; 12] {
    let prior = &config.identification;
    let (diagonal, off) = (prior.prior_sigma_diagonal, prior.prior_sigma_off_diagonal);
    let bias = prior.prior_sigma_bias_rad_s;
    [diagonal, off, off, off, diagonal, off, off, off, diagonal, bias, bias, bias]
}

/// Microseconds to seconds. Divides, because then the shortest decimal is exact.
pub(super) fn in_seconds(t_us: u64) -> f64 {
    t_us as f64 / 1e6
}
