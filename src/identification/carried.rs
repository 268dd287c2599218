#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use crate::algebra::Packed;
use nalgebra::{Matrix3, Vector3};

/// What the windows so far have taught about theta = (P row-major, c): an information matrix and a mean, of samples that no
/// later window holds, so that nothing counts twice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    pub information: Packed<12, 78>,
    pub mean: [f32; 12],
    /// When it held, microseconds.
    t_us: u64,
}

/// How fast what was learnt goes stale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forgetting {
    /// Random walk of c, rad/s per root second.
    pub bias_walk_rad_s_rts: f32,
    /// Time in which the information falls to 1/e, seconds.
    pub forgetting_s: f32,
}

impl Carried {
    pub const fn nothing() -> Self {
        Self { information: Packed::zero(), mean: [0.0; 12], t_us: 0 }
    }

    /// Whether nothing has been learnt yet.
    pub fn is_empty(&self) -> bool {
        (0..12).all(|i| self.information.get(i, i) <= 0.0)
    }

    /// What is left of it at `t_us`: everything is forgotten exponentially, and c walks.
    pub fn aged(&self, t_us: u64, forgetting: &Forgetting) -> Self {
        let mut aged = Self { t_us, ..*self };
        let since_s = t_us.saturating_sub(self.t_us) as f32 * 1e-6;
        let keep = libm::expf(-since_s / forgetting.forgetting_s);
        aged.information = Packed::zero();
        aged.information.add_scaled(&self.information, keep);
        let walk = forgetting.bias_walk_rad_s_rts;
        let variance = walk * walk * since_s;
        // (I^-1 + G Q G^T)^-1 = I - q I G (1 + q G^T I G)^-1 G^T I, G picking c and Q being q times the identity: holds for a
        // singular I too, and for any q.
        let mut middle = Matrix3::<f32>::identity();
        for i in 0..3 {
            for j in 0..3 {
                middle[(i, j)] += variance * aged.information.get(9 + i, 9 + j);
            }
        }
        if let Some(inverse) = middle.try_inverse() {
            let before = aged.information;
            for i in 0..12 {
                for j in 0..=i {
                    let mut taken = 0.0;
                    for k in 0..3 {
                        for l in 0..3 {
                            taken += before.get(i, 9 + k) * inverse[(k, l)] * before.get(9 + l, j);
                        }
                    }
                    aged.information.add(i, j, -variance * taken);
                }
            }
        }
        aged
    }

    /// The gyro's bias stepped by so much, compensated frame, rad/s: what was learnt before is moved.
    pub fn step_bias(&mut self, t_us: u64, by_rad_s: &Vector3<f32>) {
        if self.t_us < t_us {
            self.mean.iter_mut().skip(9).zip(by_rad_s.iter()).for_each(|(c, by)| *c += by);
        }
    }

    /// Adds the normal equations N x = h of more samples about `theta`, which hold at `t_us`. Without a solution it stays as it was.
    pub fn learn(&mut self, t_us: u64, theta: &[f32; 12], normal: &Packed<12, 78>, rhs: &[f32; 12]) {
        let mut information = self.information;
        information.add_scaled(normal, 1.0);
        // Directions that nothing has informed yet have no mean to be solved for: a trace of information at the nominal model.
        let mut solvable = information;
        for i in 0..12 {
            solvable.add(i, i, FLOOR);
        }
        let offset = core::array::from_fn(|i| self.mean[i] - theta[i]);
        let mut h = self.information.times(&offset);
        for (h, new) in h.iter_mut().zip(rhs) {
            *h += new;
        }
        let Some(factor) = solvable.cholesky() else { return };
        let x = factor.solve(&h);
        if x.iter().all(|x| x.is_finite()) {
            *self = Self { information, mean: core::array::from_fn(|i| theta[i] + x[i]), t_us };
        }
    }

    /// Twice the cost of theta: its squared Mahalanobis distance from the mean.
    pub fn distance(&self, theta: &[f32; 12]) -> f32 {
        self.information.quadratic(&core::array::from_fn(|i| theta[i] - self.mean[i]))
    }
}

/// Information that any parameter is given to make a factor exist: a deviation of 1, far beyond every prior.
const FLOOR: f32 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;

    const FORGETTING: Forgetting = Forgetting { bias_walk_rad_s_rts: 1e-3, forgetting_s: 1000.0 };

    /// Information 4 about every parameter but P00, of which there is none, with coupling between P11 and c1.
    fn carried() -> Carried {
        let mut normal = Packed::zero();
        for i in 1..12 {
            normal.add(i, i, 4.0e6);
        }
        normal.add(10, 4, 2.0e6);
        let mut carried = Carried::nothing();
        let x: [f32; 12] = core::array::from_fn(|i| 1e-3 * i as f32);
        carried.learn(0, &[0.5; 12], &normal, &normal.times(&x));
        carried
    }

    #[test]
    fn equations_of_two_lots_together_give_the_mean_of_both() {
        let mut both = carried();
        for i in 1..12 {
            assert!((both.mean[i] - 0.5 - 1e-3 * i as f32).abs() < 1e-6, "{i}");
        }
        let mut normal = Packed::zero();
        normal.add(11, 11, 4.0e6);
        let mut rhs = [0.0; 12];
        rhs[11] = 4.0e6 * 0.02;
        both.learn(5, &[0.5; 12], &normal, &rhs);
        assert!((both.mean[11] - (0.5 + 0.5 * (0.011 + 0.02))).abs() < 1e-6);
        assert!((both.information.get(11, 11) - 8.0e6).abs() < 10.0);
        assert!(both.distance(&both.mean) < 1e-6 && !both.is_empty() && Carried::nothing().is_empty());
    }

    #[test]
    fn a_walk_adds_its_variance_to_c_alone_and_time_forgets() {
        let aged = carried().aged(100_000_000, &FORGETTING);
        let keep = libm::expf(-0.1);
        // c2 is coupled to nothing: variance 1 / (4e6 keep) + 1e-6 * 100.
        let variance = 1.0 / (4.0e6 * keep) + 1e-4;
        assert!((aged.information.get(11, 11) * variance - 1.0).abs() < 1e-4);
        assert!((aged.information.get(0, 0)).abs() < 1e-3);
        assert!((aged.information.get(1, 1) / (4.0e6 * keep) - 1.0).abs() < 1e-4);
        // P11 is coupled to c1, of which almost nothing is left: what remains is the information about P11 alone,
        // 4 - 2^2 / 4 = 3.
        assert!((aged.information.get(4, 4) / (3.0e6 * keep) - 1.0).abs() < 0.01, "{}", aged.information.get(4, 4));
    }
}
