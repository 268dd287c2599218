#![allow(clippy::indexing_slicing)] // Twelve parameters; every index is bounded by the loops around it.

use crate::{
    algebra::{add_scaled, dot},
    compensation::GyroModel,
    estimator::WindowCost,
};

/// Deviations at which the way from coordinates to a model, which is linear, is read: as far as a search goes, where the steps of a P of f32
/// count least.
const STEP: f32 = 8.0;

/// Where a model lies in the whitened coordinates of a cost, posterior deviations from the mean. `None` where the coordinates do not tell.
#[inline(never)]
pub(super) fn coordinates(cost: &WindowCost<'_>, model: &GyroModel) -> Option<[f32; 12]> {
    solved(&|y| cost.model(y), model)
}

/// The way to a model is linear: its columns are read one by one, orthogonalised (modified Gram-Schmidt, Golub and Van Loan, Matrix
/// Computations, section 5.2.8) with each parameter in units of its own deviation, and gone back.
fn solved(model_at: &impl Fn(&[f32; 12]) -> GyroModel, model: &GyroModel) -> Option<[f32; 12]> {
    let mean = parameters(&model_at(&[0.0; 12]));
    let mut columns = [[0.0; 12]; 12];
    for (i, column) in columns.iter_mut().enumerate() {
        let mut y = [0.0; 12];
        y[i] = STEP;
        let moved = parameters(&model_at(&y));
        *column = core::array::from_fn(|row| (moved[row] - mean[row]) / STEP);
    }
    let per_sigma: [f32; 12] = core::array::from_fn(|row| {
        let variance = columns.iter().fold(0.0, |sum, column| sum + column[row] * column[row]);
        1.0 / libm::sqrtf(variance)
    });
    let in_sigmas = |values: &[f32; 12]| core::array::from_fn(|row| values[row] * per_sigma[row]);
    columns = columns.map(|column| in_sigmas(&column));
    let to = parameters(model);
    let mut rest: [f32; 12] = in_sigmas(&core::array::from_fn(|row| to[row] - mean[row]));
    let mut triangle = [[0.0; 12]; 12];
    let mut y = [0.0; 12];
    for i in 0..12 {
        let column = columns[i];
        let per_square = 1.0 / dot(&column, &column);
        y[i] = dot(&column, &rest) * per_square;
        add_scaled(&mut rest, &column, -y[i]);
        for j in i + 1..12 {
            triangle[i][j] = dot(&column, &columns[j]) * per_square;
            add_scaled(&mut columns[j], &column, -triangle[i][j]);
        }
    }
    for i in (0..12).rev() {
        y[i] -= (i + 1..12).fold(0.0, |sum, j| sum + triangle[i][j] * y[j]);
    }
    y.iter().all(|y| y.is_finite()).then_some(y)
}

/// P row-major, then b.
fn parameters(model: &GyroModel) -> [f32; 12] {
    let [p, q, r] = model.p;
    core::array::from_fn(|i| if i < 9 { [p, q, r][i / 3][i % 3] } else { model.b_rad_s[i - 9] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviations as of a posterior, each parameter correlated with the one before.
    fn model_at(correlation: f32, y: &[f32; 12]) -> GyroModel {
        let mut model = GyroModel { b_rad_s: [0.01, -0.02, 0.03], ..GyroModel::IDENTITY };
        let own = libm::sqrtf(1.0 - correlation * correlation);
        let mut before = 0.0;
        for (i, value) in model.p.iter_mut().flatten().chain(&mut model.b_rad_s).enumerate() {
            before = if i == 0 { y[i] } else { correlation * before + own * y[i] };
            *value += before * if i < 9 { 2e-3 * (1.0 + i as f32) } else { 1e-4 };
        }
        model
    }

    #[test]
    fn the_way_to_a_model_is_gone_back() {
        for (correlation, bound) in [(0.0, 1e-3), (0.95, 5e-3), (0.999, 3e-2)] {
            for seed in 0..20 {
                let y: [f32; 12] = core::array::from_fn(|i| libm::sinf((seed * 12 + i) as f32 * 1.7) * 5.0);
                let found = solved(&|y| model_at(correlation, y), &model_at(correlation, &y)).unwrap();
                for (found, y) in found.iter().zip(y) {
                    assert!((found - y).abs() < bound, "{correlation}: {found} {y}");
                }
            }
        }
    }

    #[test]
    fn coordinates_that_do_not_move_the_model_tell_nothing() {
        assert!(solved(&|_| GyroModel::IDENTITY, &GyroModel::IDENTITY).is_none());
    }
}
