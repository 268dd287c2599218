/// How the population search, or what takes its place, is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum OptimizerKind {
    /// Improved meerkat optimisation algorithm (the paper's, in our reading, whitened).
    #[default]
    Imoa,
    /// The same equations as printed; a baseline.
    ImoaLiteral,
    /// Meerkat optimisation algorithm; a baseline.
    Moa,
    /// Particle swarm with constriction.
    Pso,
    /// Differential evolution, DE/rand/1/bin.
    De,
    /// Random search; the floor of every comparison.
    Random,
    /// Levenberg-Marquardt.
    Lm,
    /// The closed-form least-squares point itself; no search.
    Ls,
}
