#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use crate::algebra::{Cholesky, Jacobi, Packed, dot};

/// A direction counts as observed when its posterior deviation is under half of its prior one: information at least fourfold.
const LEAST_RATIO: f32 = 4.0;

/// What a window sees of the 12 parameters: the eigen-directions of the posterior information in the prior's metric.
#[derive(Clone, Debug)]
pub(crate) struct Observability {
    prior: Cholesky<12, 78>,
    /// Of the posterior's information, in the prior's whitened coordinates.
    eigen: Jacobi<12>,
}

impl Observability {
    /// To be worked on until it is done; `None` when the prior cannot be factorised.
    pub fn new(prior_information: &Packed<12, 78>, posterior_information: &Packed<12, 78>) -> Option<Self> {
        let prior = prior_information.cholesky()?;
        // E = L^-1 H L^-T, column by column.
        let mut ratio = [[0.0; 12]; 12];
        for i in 0..12 {
            let mut unit = [0.0; 12];
            unit[i] = 1.0;
            ratio[i] = prior.solve_lower(&posterior_information.times(&prior.solve_upper(&unit)));
        }
        // Symmetric but for rounding.
        for i in 0..12 {
            for j in 0..i {
                let mean = 0.5 * (ratio[i][j] + ratio[j][i]);
                (ratio[i][j], ratio[j][i]) = (mean, mean);
            }
        }
        Some(Self { prior, eigen: Jacobi::new(&ratio) })
    }

    /// One piece of the eigen-decomposition; false when it is done.
    pub fn work(&mut self) -> bool {
        self.eigen.sweep()
    }

    fn is_observed(&self, direction: usize) -> bool {
        self.eigen.value(direction) > LEAST_RATIO
    }

    /// Observed directions.
    pub fn rank(&self) -> u8 {
        (0..12).filter(|k| self.is_observed(*k)).count() as u8
    }

    /// The part of a change of theta that lies in the observed directions.
    pub fn observed_part(&self, change: &[f32; 12]) -> [f32; 12] {
        let whitened = self.prior.times_upper(change);
        let mut kept = [0.0; 12];
        for k in (0..12).filter(|k| self.is_observed(*k)) {
            let direction = self.eigen.vector(k);
            let along = dot(&direction, &whitened);
            for (x, d) in kept.iter_mut().zip(direction) {
                *x += along * d;
            }
        }
        self.prior.solve_upper(&kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_seen_is_kept() {
        let mut prior = Packed::<12, 78>::zero();
        for i in 0..12 {
            prior.add(i, i, 400.0 + 30.0 * i as f32);
        }
        // Rows that see parameters 0 and 5 together and 7 alone.
        let mut posterior = prior;
        let mut together = [0.0; 12];
        together[0] = 1.0;
        together[5] = 1.0;
        posterior.add_outer(&together, 1e6);
        let mut alone = [0.0; 12];
        alone[7] = 1.0;
        posterior.add_outer(&alone, 1e5);
        let mut observability = Observability::new(&prior, &posterior).unwrap();
        while observability.work() {}
        assert_eq!(observability.rank(), 2);
        let mut change = [0.1; 12];
        let kept = observability.observed_part(&change);
        assert!((kept[7] - 0.1).abs() < 1e-4);
        assert!((kept[0] + kept[5] - 0.2).abs() < 1e-3, "the seen sum is kept");
        assert!(kept[1].abs() < 1e-4 && kept[11].abs() < 1e-4, "the unseen stays");
        change[0] = 0.3;
        change[5] = -0.3;
        let kept = observability.observed_part(&change);
        assert!((kept[0] + kept[5]).abs() < 0.03, "a change along the unseen difference is dropped");
    }
}
