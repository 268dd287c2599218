use super::{ConfigError, OptimizerKind, all_positive};

/// The identification window, its prior, its search and its gate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct IdentificationConfig {
    /// Length of a window, seconds. Default 50 (the rate error falls as 0.12, 0.039, 0.026, 0.018 deg/s at 10, 25, 50, 100 s).
    pub window_s: f32,
    /// From the close of one window to the next, seconds. Default 25.
    pub step_s: f32,
    /// The shortest window that is identified, seconds. Default 20.
    pub min_window_s: f32,
    /// A window's result takes effect this long after the window closed, seconds. Default 5.
    pub latency_s: f32,
    /// Prior standard deviation of P's diagonal about the factory's. Default 0.06.
    pub prior_sigma_diagonal: f32,
    /// Prior standard deviation of P's off-diagonal. Default 0.03.
    pub prior_sigma_off_diagonal: f32,
    /// Prior standard deviation of the bias, rad/s. Default 0.021 (1.2 deg/s).
    pub prior_sigma_bias_rad_s: f32,
    /// Time in which what earlier windows have taught falls to 1/e, seconds; it goes into a window's prior, as long as the window does
    /// not contradict it. Default 3,600.
    pub forgetting_s: f32,
    /// A second whose gyro deviates less than this on every axis is a candidate for rest, rad/s. Default 0.5 deg/s.
    pub rest_gyro_deviation_rad_s: f32,
    /// A mean rate above this is rotation, not bias, however steady, rad/s. Default 0.087 (5 deg/s: the zero-rate output that
    /// MEMS data sheets allow after soldering).
    pub max_bias_rad_s: f32,
    /// What searches.
    pub optimizer: OptimizerKind,
    /// Most cost evaluations of a search. Default 75, half as many again as IMOA needs from the least-squares point.
    pub max_evaluations: u32,
    /// Gravity and field come from a reference attitude, not from sensors (bench mode). Default false. Then there are no errors of vector
    /// sensors that P could be taken for: a P that wins beyond chance flies though it leaves much of the misfit, effects are found beside a P
    /// that is free, and no test window loses its weight.
    pub vectors_from_reference: bool,
}

impl IdentificationConfig {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self {
        window_s: 0.0,
        step_s: 0.0,
        min_window_s: 0.0,
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
                self.window_s,
                self.step_s,
                self.min_window_s,
                self.latency_s,
                self.prior_sigma_diagonal,
                self.prior_sigma_off_diagonal,
                self.prior_sigma_bias_rad_s,
                self.forgetting_s,
                self.rest_gyro_deviation_rad_s,
                self.max_bias_rad_s,
            ],
            &[
                "identification.window_s",
                "identification.step_s",
                "identification.min_window_s",
                "identification.latency_s",
                "identification.prior_sigma_diagonal",
                "identification.prior_sigma_off_diagonal",
                "identification.prior_sigma_bias_rad_s",
                "identification.forgetting_s",
                "identification.rest_gyro_deviation_rad_s",
                "identification.max_bias_rad_s",
            ],
        )?;
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ConfigError { field, must_be }) };
        check(self.window_s <= 50.0, "identification.window_s", "at most 50, the capacity of the window")?;
        check(self.min_window_s >= 20.0, "identification.min_window_s", "at least 20")?;
        check(self.min_window_s <= self.window_s, "identification.min_window_s", "at most window_s")?;
        check(self.latency_s <= 5.0, "identification.latency_s", "at most 5, the capacity behind the window")?;
        check(self.step_s >= self.latency_s, "identification.step_s", "at least latency_s")?;
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
            window_s: 50.0,
            step_s: 25.0,
            min_window_s: 20.0,
            latency_s: 5.0,
            prior_sigma_diagonal: 0.06,
            prior_sigma_off_diagonal: 0.03,
            prior_sigma_bias_rad_s: 0.021,
            forgetting_s: 3_600.0,
            rest_gyro_deviation_rad_s: 0.5_f32.to_radians(),
            max_bias_rad_s: 5.0_f32.to_radians(),
            optimizer: OptimizerKind::Imoa,
            max_evaluations: 75,
            vectors_from_reference: false,
        }
    }
}
