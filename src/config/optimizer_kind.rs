//! Search methods.

/// Search method of a window. All but `Imoa`, `Lm` and `Ls` need the feature `baseline-searches`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum OptimizerKind {
    /// Improved meerkat optimisation algorithm (the paper's, in our reading, whitened).
    #[default]
    Imoa,
    /// IMOA with the equations as printed; a baseline.
    ImoaLiteral,
    /// Meerkat optimisation algorithm; a baseline.
    Moa,
    /// Particle swarm with constriction.
    Pso,
    /// Differential evolution, DE/rand/1/bin.
    De,
    /// Random search, which every method has to beat; a baseline.
    Random,
    /// Levenberg-Marquardt.
    Lm,
    /// Least squares: the estimator's mean itself, without a search.
    Ls,
}

impl OptimizerKind {
    /// Returns true if this build has the method.
    #[must_use]
    pub const fn is_built_in(self) -> bool {
        cfg!(feature = "baseline-searches") || matches!(self, Self::Imoa | Self::Lm | Self::Ls)
    }
}
