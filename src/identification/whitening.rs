use crate::{algebra::Cholesky, optimizer::Cost};

/// A cost in whitened coordinates: x = radius L^-T y, L the Cholesky factor of the normal matrix at the least-squares point
/// (the prior inside), so that near it the cost is a round bowl and y of length 1 / radius is one posterior deviation.
pub(crate) struct Whitened<'a, C> {
    pub cost: &'a C,
    pub factor: &'a Cholesky<12, 78>,
    pub radius: f32,
}

impl<C: Cost<12>> Cost<12> for Whitened<'_, C> {
    /// Not inlined: one copy on the chip, whichever optimiser calls it.
    #[inline(never)]
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        self.cost.evaluate(&self.factor.solve_upper(&y.map(|y| self.radius * y)))
    }
}
