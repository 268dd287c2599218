use super::weak_columns::COLUMNS;
use crate::algebra::{add_outers, factorise, solve_lower, solve_upper};

/// Most columns of one model: the gyro's 12 and those of a few effects.
pub(super) const MAX_COLUMNS: usize = 36;

/// Elements of its triangle.
const TRIANGLE: usize = MAX_COLUMNS * (MAX_COLUMNS + 1) / 2;

/// Symmetric matrix of all columns, lower triangle row by row.
pub(super) struct Normal([f32; COLUMNS * (COLUMNS + 1) / 2]);

impl Normal {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self([0.0; COLUMNS * (COLUMNS + 1) / 2])
    }

    pub fn clear(&mut self) {
        self.0.fill(0.0);
    }

    pub fn get(&self, i: usize, j: usize) -> f32 {
        let (i, j) = if j <= i { (i, j) } else { (j, i) };
        self.0.get(i * (i + 1) / 2 + j).copied().unwrap_or(0.0)
    }

    /// Adds the weighted outer products of three rows, of the first `columns` columns.
    pub fn add(&mut self, rows: &[[f32; COLUMNS]; 3], columns: usize, weight: f32) {
        add_outers(&mut self.0, rows.each_ref().map(|row| row.get(..columns).unwrap_or_default()), weight);
    }
}

/// The columns of a model, by number.
pub(super) type Model = heapless::Vec<u8, MAX_COLUMNS>;

/// What is known of a column before a window: the information, and the value.
#[derive(Clone, Copy)]
pub(super) struct Prior {
    pub information: f32,
    pub mean: f32,
}

impl Prior {
    /// Of deviation 1 about zero.
    pub const UNIT: Self = Self { information: 1.0, mean: 0.0 };
}

/// Cholesky factor of a model's part of the normal matrix, with the prior of every column added.
pub(super) struct Factor {
    elements: [f32; TRIANGLE],
    size: usize,
}

impl Factor {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { elements: [0.0; TRIANGLE], size: 0 }
    }

    /// Its memory, for other use as long as there is nothing to factorise.
    pub const fn scratch(&mut self) -> &mut [f32] {
        &mut self.elements
    }

    /// Factorises; `None` when it is not positive definite, or not finite.
    pub fn of(&mut self, normal: &Normal, priors: &[Prior; COLUMNS], model: &Model) -> Option<()> {
        self.size = model.len();
        let mut elements = self.elements.iter_mut();
        for (i, &row) in model.iter().enumerate() {
            for (j, &column) in model.iter().enumerate().take(i + 1) {
                let prior = if i == j { priors.get(usize::from(row))?.information } else { 0.0 };
                *elements.next()? = normal.get(usize::from(row), usize::from(column)) + prior;
            }
        }
        factorise(self.elements.get_mut(..self.size * (self.size + 1) / 2)?)
    }

    /// x with L L^T x = rhs.
    pub fn solve(&self, rhs: &mut [f32; MAX_COLUMNS]) {
        let rhs = rhs.get_mut(..self.size).unwrap_or_default();
        solve_lower(&self.elements, rhs);
        solve_upper(&self.elements, rhs);
    }
}
