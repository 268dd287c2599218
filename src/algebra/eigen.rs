#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

/// Most sweeps; f32 needs about 6.
const SWEEPS: u8 = 12;

/// Eigenvalues and eigenvectors of a symmetric matrix by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5),
/// sweep by sweep. Always ends.
#[derive(Clone, Debug)]
pub(crate) struct Jacobi<const D: usize> {
    a: [[f32; D]; D],
    v: [[f32; D]; D],
    sweeps: u8,
}

impl<const D: usize> Jacobi<D> {
    pub fn new(matrix: &[[f32; D]; D]) -> Self {
        let mut v = [[0.0; D]; D];
        for (i, row) in v.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        Self { a: *matrix, v, sweeps: 0 }
    }

    /// One sweep; false when none is needed any more.
    pub fn sweep(&mut self) -> bool {
        let mut off = 0.0;
        let mut diagonal = 0.0;
        for i in 0..D {
            diagonal += self.a[i][i] * self.a[i][i];
            for j in 0..i {
                off += self.a[i][j] * self.a[i][j];
            }
        }
        let converged = off <= 1e-12 * diagonal;
        if converged || off.is_nan() || self.sweeps == SWEEPS {
            return false;
        }
        for p in 0..D {
            for q in p + 1..D {
                rotate(&mut self.a, &mut self.v, p, q);
            }
        }
        self.sweeps += 1;
        true
    }

    /// Eigenvalue `k`; 0 beyond the last.
    pub fn value(&self, k: usize) -> f32 {
        self.a.get(k).and_then(|row| row.get(k)).copied().unwrap_or(0.0)
    }

    /// The unit eigenvector that belongs to it.
    pub fn vector(&self, k: usize) -> [f32; D] {
        self.v.map(|row| row.get(k).copied().unwrap_or(0.0))
    }
}

/// One Jacobi rotation that makes a[p][q] zero.
fn rotate<const D: usize>(a: &mut [[f32; D]; D], v: &mut [[f32; D]; D], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let root = libm::sqrtf(1.0 + tau * tau);
    let t = if tau >= 0.0 { 1.0 / (tau + root) } else { -1.0 / (root - tau) };
    let c = 1.0 / libm::sqrtf(1.0 + t * t);
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..D {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
    for row in v.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    #[test]
    fn a_random_matrix_times_its_eigenvector_is_eigenvalue_times_eigenvector() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        for _ in 0..20 {
            let mut a = [[0.0_f32; 12]; 12];
            for i in 0..12 {
                for j in 0..=i {
                    a[i][j] = generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
                    a[j][i] = a[i][j];
                }
            }
            let mut eigen = Jacobi::new(&a);
            while eigen.sweep() {}
            for k in 0..12 {
                let vector = eigen.vector(k);
                for row in 0..12 {
                    let product: f32 = (0..12).map(|j| a[row][j] * vector[j]).sum();
                    assert!((product - eigen.value(k) * vector[row]).abs() < 1e-5);
                }
            }
        }
    }
}
