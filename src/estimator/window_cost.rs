use crate::{
    compensation::GyroModel,
    optimizer::{Cost, LeastSquaresCost, Packed},
};
use core::marker::PhantomData;

/// What the search of a window minimises, as a function of the change of (P row-major, b) from the posterior's mean, in whitened
/// coordinates. Dimensionless: half the robust sum of squares, prior included.
pub struct WindowCost<'a> {
    rows: PhantomData<&'a ()>,
}

impl WindowCost<'_> {
    /// The model that lies `y` from the posterior's mean, in posterior deviations.
    #[must_use]
    pub const fn model(&self, _y: &[f32; 12]) -> GyroModel {
        GyroModel::IDENTITY
    }
}

impl Cost<12> for WindowCost<'_> {
    fn evaluate(&self, _y: &[f32; 12]) -> f32 {
        let Self { rows: PhantomData } = self;
        f32::NAN
    }
}

impl LeastSquaresCost<12, 78> for WindowCost<'_> {
    fn normal_equations(&self, _y: &[f32; 12], _normal: &mut Packed<12, 78>, _descent: &mut [f32; 12]) {}
}
