//! Settings of IMOA.

use crate::optimizer::OptimizerError;

/// Exchange of members in each variable (eq 20 to 23).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Reward {
    /// No exchange.
    Off,
    /// The member nearer to the start wins each variable; costs no evaluation. In whitened coordinates about
    /// the least-squares point that means nearer to the least-squares estimate in the information metric.
    Free,
    /// The lower of two costs wins each variable: that of the best point with the member's value in it, or
    /// with the partner's (eq 23). Takes 2 D evaluations, of whose costs only the order is used.
    Points,
    /// The bottom of a parabola wins each variable, through the costs of the best point and of a step (eq 18)
    /// to either side. Takes the same 2 D evaluations, and one more if the candidate's cost tells that it
    /// lies too far or too near.
    Values,
}

/// Settings of [`super::Imoa`]. The defaults reached the optimum with the fewest evaluations on simulated
/// windows (seeds 0 to 19); refraction, off by default, makes next to no difference there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImoaSettings {
    /// Largest number of cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// Disturbance of the data, a_h of eq 16: the relative error of the specific force's norm. It lengthens
    /// the step (eq 18), to twice at 1 and beyond. Must be finite and not negative. Default 0.
    pub disturbance: f32,
    /// Takes the exchange's step from the spread of the members (eq 17 and 18); if off, from the first
    /// population's deviation. Default on.
    pub adaptive_step: bool,
    /// Guided spiral (eq 19), the move of the global phase. Default on.
    pub spiral: bool,
    /// Exchange by rewards (eq 20 to 23). Default [`Reward::Values`].
    pub reward: Reward,
    /// Migration (eq 24 and 25), the move of the local phase. Default on.
    pub migration: bool,
    /// Per-dimension refraction (eq 26 to 29). Default off.
    pub refraction: bool,
}

impl ImoaSettings {
    /// Creates settings with the defaults.
    #[must_use]
    pub const fn new(max_evaluations: u32) -> Self {
        Self {
            max_evaluations,
            disturbance: 0.0,
            adaptive_step: true,
            spiral: true,
            reward: Reward::Values,
            migration: true,
            refraction: false,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Rejects a disturbance that is negative or not finite, and settings without either move.
    pub(super) fn check(&self) -> Result<(), OptimizerError> {
        if !(self.disturbance.is_finite() && self.disturbance >= 0.0) {
            return Err(OptimizerError::Setting("disturbance"));
        }
        if !(self.spiral || self.migration) {
            return Err(OptimizerError::Setting("spiral or migration"));
        }
        Ok(())
    }
}
