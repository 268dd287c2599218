//! Settings of the identification.

use super::{ConfigError, Motion, OptimizerKind, VectorErrors, all_positive, check};

/// Settings of the estimator of the gyro's errors, of the instants at which its results take effect, and of the search
/// of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct IdentificationConfig {
    /// Kind of motion. Default `drill_string`.
    pub motion: Motion,
    /// Errors left by the calibrations of accelerometer and magnetometer. Default: data sheets.
    pub vector_errors: VectorErrors,
    /// Interval between updates of the flown model, seconds. Default 5.
    pub update_s: f32,
    /// Length of a window, which is reported and searched, seconds. Default 50.
    pub window_s: f32,
    /// Interval between the ends of windows, seconds; a window ends with the first update at which it is due.
    /// Default 25.
    pub step_s: f32,
    /// Time from the request of an update, or of a window, to its effect, seconds. Default 1.
    pub latency_s: f32,
    /// Prior standard deviation of the diagonal of P, the gyro's scale and coupling matrix, about the factory's P.
    /// Default 0.06.
    pub prior_sigma_diagonal: f32,
    /// Prior standard deviation of P's off-diagonal elements. Default 0.03.
    pub prior_sigma_off_diagonal: f32,
    /// Prior standard deviation of the bias, rad/s. Default 0.021 (1.2 deg/s).
    pub prior_sigma_bias_rad_s: f32,
    /// Time in which the watch for magnets forgets the gyro errors that it has learnt, seconds: in this time the
    /// variance of each error grows by its prior variance. Default 3,600.
    pub forgetting_s: f32,
    /// Largest gyro deviation on any axis in a second of rest, rad/s. Default 0.5 deg/s.
    pub rest_gyro_deviation_rad_s: f32,
    /// Largest mean rate of an axis that can be a bias, rad/s; a larger one is rotation, however steady, unless gravity
    /// and field both show that nothing turns. Default 0.17 (10 deg/s: the zero-rate level of an LSM6DS33, data sheet
    /// table 3, the widest of the gyros in use).
    pub max_bias_rad_s: f32,
    /// Search method of a window.
    pub optimizer: OptimizerKind,
    /// Largest number of cost evaluations of a search. Default 75: one and a half times as many as IMOA needs from the
    /// least-squares solution of a window.
    pub max_evaluations: u32,
    /// True if gravity and field come from a reference attitude and not from sensors (bench mode). Default false. If
    /// true, no error of a vector sensor can be mistaken for P, and effects are found while P is free.
    pub vectors_from_reference: bool,
}

impl IdentificationConfig {
    /// All-zero settings of a static before it is configured.
    pub(crate) const UNSET: Self = Self {
        motion: Motion::Hand,
        vector_errors: VectorErrors::UNSET,
        update_s: 0.0,
        window_s: 0.0,
        step_s: 0.0,
        latency_s: 0.0,
        prior_sigma_diagonal: 0.0,
        prior_sigma_off_diagonal: 0.0,
        prior_sigma_bias_rad_s: 0.0,
        forgetting_s: 0.0,
        rest_gyro_deviation_rad_s: 0.0,
        max_bias_rad_s: 0.0,
        optimizer: OptimizerKind::Imoa,
        max_evaluations: 0,
        vectors_from_reference: false,
    };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [
                self.update_s,
                self.window_s,
                self.step_s,
                self.latency_s,
                self.prior_sigma_diagonal,
                self.prior_sigma_off_diagonal,
                self.prior_sigma_bias_rad_s,
                self.forgetting_s,
                self.rest_gyro_deviation_rad_s,
                self.max_bias_rad_s,
            ],
            &[
                "identification.update_s",
                "identification.window_s",
                "identification.step_s",
                "identification.latency_s",
                "identification.prior_sigma_diagonal",
                "identification.prior_sigma_off_diagonal",
                "identification.prior_sigma_bias_rad_s",
                "identification.forgetting_s",
                "identification.rest_gyro_deviation_rad_s",
                "identification.max_bias_rad_s",
            ],
        )?;
        self.vector_errors.validate()?;
        let prior_sigmas = [self.prior_sigma_diagonal, self.prior_sigma_off_diagonal, self.prior_sigma_bias_rad_s];
        let within = |sigma: &f32| (1e-6..=1.0).contains(sigma);
        check(prior_sigmas.iter().all(within), "identification.prior_sigma_*", "1e-6 to 1")?;
        check(self.window_s <= 50.0, "identification.window_s", "at most 50, the capacity of the window")?;
        check(self.latency_s <= 5.0, "identification.latency_s", "at most 5, the capacity behind the window")?;
        check(self.update_s >= self.latency_s, "identification.update_s", "at least latency_s")?;
        check(self.step_s >= self.update_s, "identification.step_s", "at least update_s")?;
        check(
            self.optimizer.is_built_in(),
            "identification.optimizer",
            "one that is built in (feature baseline-searches)",
        )?;
        check((1..=100_000).contains(&self.max_evaluations), "identification.max_evaluations", "1 to 100000")
    }
}

impl Default for IdentificationConfig {
    fn default() -> Self {
        Self {
            motion: Motion::DrillString,
            vector_errors: VectorErrors::default(),
            update_s: 5.0,
            window_s: 50.0,
            step_s: 25.0,
            latency_s: 1.0,
            prior_sigma_diagonal: 0.06,
            prior_sigma_off_diagonal: 0.03,
            prior_sigma_bias_rad_s: 0.021,
            forgetting_s: 3_600.0,
            rest_gyro_deviation_rad_s: 0.5_f32.to_radians(),
            max_bias_rad_s: 10.0_f32.to_radians(),
            optimizer: OptimizerKind::Imoa,
            max_evaluations: 75,
            vectors_from_reference: false,
        }
    }
}
