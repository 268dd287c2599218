use crate::{
    algebra::{Cholesky, Packed},
    objective::Innovations,
    optimizer::{Cost, LeastSquaresCost},
};

/// What the search of a window minimises, as a function of the change of theta = (P row-major, c = P b) from the window's
/// least-squares point, which is at 0. Dimensionless: half the robust sum of squares, prior included.
pub struct WindowCost<'a> {
    pub(super) objective: Innovations<'a>,
    pub(super) factor: &'a Cholesky<12, 78>,
}

impl<'a> WindowCost<'a> {
    /// The same cost in whitened coordinates, in which the search works: the box [-1, 1]^12 reaches `radius` posterior deviations
    /// in each of them.
    #[must_use]
    pub const fn whitened(&self, radius: f32) -> WhitenedCost<'_, 'a> {
        WhitenedCost { cost: self, radius }
    }

    /// The change of theta that lies `deviations` away in whitened coordinates: L^-T times it, L the Cholesky factor of the normal
    /// matrix at the least-squares point, prior inside.
    #[must_use]
    pub fn change(&self, deviations: &[f32; 12]) -> [f32; 12] {
        self.factor.solve_upper(deviations)
    }
}

impl Cost<12> for WindowCost<'_> {
    fn evaluate(&self, change: &[f32; 12]) -> f32 {
        self.objective.evaluate(change)
    }
}

impl LeastSquaresCost<12, 78> for WindowCost<'_> {
    fn normal_equations(&self, change: &[f32; 12], normal: &mut Packed<12, 78>, descent: &mut [f32; 12]) {
        self.objective.normal_equations(change, normal, descent);
    }
}

/// [`WindowCost`] in whitened coordinates: near 0 a round bowl, of curvature `radius` squared in every direction.
pub struct WhitenedCost<'b, 'a> {
    cost: &'b WindowCost<'a>,
    radius: f32,
}

impl Cost<12> for WhitenedCost<'_, '_> {
    /// Not inlined: one copy on the chip, whichever optimiser calls it.
    #[inline(never)]
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        self.cost.evaluate(&self.cost.change(&y.map(|y| self.radius * y)))
    }
}
