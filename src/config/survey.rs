//! Settings of surveys.

use super::{ConfigError, DynamicsConfig, SurveyErrors, SurveyLimits, all_positive, check};
use core::f32::consts::TAU;

/// Settings of surveys and of their quality checks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SurveyConfig {
    /// Time at rest before averaging begins, seconds, in which the drill string untwists. Default 5.
    pub settle_s: f32,
    /// Averaging time of force and field, seconds. Default 10: it leaves 0.03 mg of an accelerometer's noise of 0.15 mg
    /// per root hertz, under a tenth of its bias (ABXY, 0.4 mg).
    pub average_s: f32,
    /// Turn of gravity or field since the average began that restarts a survey, radians. Default 0.5 deg: the average
    /// direction in a steady turn is then within a quarter of a degree of the first and the last.
    pub max_turn_rad: f32,
    /// Axial rate at which the tool counts as rotating, rad/s; it stops counting below half of it. Default 5
    /// rpm: a choice, well below the speeds of rotary drilling.
    pub rotating_rad_s: f32,
    /// Whole turns in one rotating survey. Default 10.
    pub rotating_turns: u16,
    /// Inclination below which the magnetic toolface applies, radians. Default 5 deg.
    pub near_vertical_rad: f32,
    /// Hysteresis of `near_vertical_rad`, radians: the gravity toolface applies again above the sum of both. Default
    /// 0.5 deg.
    pub near_vertical_hysteresis_rad: f32,
    /// Angle from the probe's highside (x axis) to the motor's scribe line, by which one steers, radians
    /// clockwise looking down-hole. It is added to both toolfaces. Default 0.
    pub toolface_offset_rad: f32,
    /// Grid convergence, radians, grid north east of true north: grid azimuth is true azimuth less this.
    /// Default `None`: no grid azimuth.
    pub grid_convergence_rad: Option<f32>,
    /// Errors left in the sensors and in the reference field.
    pub errors: SurveyErrors,
    /// Limits of a good survey.
    pub limits: SurveyLimits,
    /// Settings of vibration, shocks and stick-slip.
    pub dynamics: DynamicsConfig,
}

impl SurveyConfig {
    /// All-zero settings of a static before it is configured.
    pub(super) const UNSET: Self = Self {
        settle_s: 0.0,
        average_s: 0.0,
        max_turn_rad: 0.0,
        rotating_rad_s: 0.0,
        rotating_turns: 0,
        near_vertical_rad: 0.0,
        near_vertical_hysteresis_rad: 0.0,
        toolface_offset_rad: 0.0,
        grid_convergence_rad: None,
        errors: SurveyErrors::UNSET,
        limits: SurveyLimits::UNSET,
        dynamics: DynamicsConfig::UNSET,
    };

    /// Checks every field.
    ///
    /// # Errors
    /// Names the first field that cannot be used.
    pub fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [
                self.settle_s,
                self.average_s,
                self.max_turn_rad,
                self.rotating_rad_s,
                self.near_vertical_rad,
                self.near_vertical_hysteresis_rad,
            ],
            &[
                "survey.settle_s",
                "survey.average_s",
                "survey.max_turn_rad",
                "survey.rotating_rad_s",
                "survey.near_vertical_rad",
                "survey.near_vertical_hysteresis_rad",
            ],
        )?;
        check((0.5..=600.0).contains(&self.average_s), "survey.average_s", "0.5 to 600")?;
        // Their scatter gives the noise, in at least two degrees of freedom.
        check((3..=1_000).contains(&self.rotating_turns), "survey.rotating_turns", "3 to 1000")?;
        let angle = |x: f32| (-TAU..=TAU).contains(&x);
        check(angle(self.toolface_offset_rad), "survey.toolface_offset_rad", "within a whole turn")?;
        check(self.grid_convergence_rad.is_none_or(angle), "survey.grid_convergence_rad", "within a whole turn")?;
        self.errors.validate()?;
        self.limits.validate()?;
        self.dynamics.validate()
    }
}

impl Default for SurveyConfig {
    fn default() -> Self {
        Self {
            settle_s: 5.0,
            average_s: 10.0,
            max_turn_rad: 0.5_f32.to_radians(),
            rotating_rad_s: 5.0 * TAU / 60.0,
            rotating_turns: 10,
            near_vertical_rad: 5.0_f32.to_radians(),
            near_vertical_hysteresis_rad: 0.5_f32.to_radians(),
            toolface_offset_rad: 0.0,
            grid_convergence_rad: None,
            errors: SurveyErrors::default(),
            limits: SurveyLimits::default(),
            dynamics: DynamicsConfig::default(),
        }
    }
}

#[cfg(test)]
mod tests;
