use crate::optimizer::OptimizerError;

/// How members exchange what they know in each variable (eq 20 to 23).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Reward {
    /// Not at all.
    Off,
    /// In each variable the member nearer to the start wins; costs no evaluation. In whitened coordinates about the least-squares
    /// point that is "nearer to the least-squares estimate in the information metric".
    Free,
    /// In each variable the lower of two costs wins, that of the best point with the member's value in it and with the partner's
    /// (eq 23). 2 D evaluations, and of their costs only the order is used.
    Points,
    /// The same 2 D evaluations, a step (eq 18) to either side of the best point, and all of their costs: the candidate lies in
    /// each variable where the parabola through the three costs is lowest. One more evaluation where the candidate's cost tells that
    /// it lies too far or too near.
    Values,
}

/// Settings of [`super::Imoa`]. The defaults are those that reached the optimum with the fewest evaluations on simulated windows
/// (seeds 0 to 19); refraction, off by default, makes next to no difference there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImoaSettings {
    /// Most cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// a_h of eq 16, relative error of the norm of specific force, 0 on. The caller's measure of how disturbed the data are: it
    /// lengthens the step (eq 18), at 1 and beyond to twice. Must be finite and not negative. Default 0.
    pub disturbance: f32,
    /// Step of the exchange from the spread of the members (eq 17 and 18); otherwise the first population's deviation. Default on.
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
    /// The defaults.
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

    /// # Errors
    /// A disturbance that is negative or not finite, or neither of the two moves.
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
