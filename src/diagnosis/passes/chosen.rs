use super::{at, each_parameter, limits::SIGNIFICANT, square};
use crate::compensation::effect::MAX_PARAMETERS;

/// An effect in the model.
#[derive(Clone, Copy)]
pub(super) struct Chosen {
    pub index: u8,
    pub evidence: f32,
    pub p_value: f32,
    /// Sum of squares of what its parameters turn that are seen to be there, and of how many.
    pub turned: [f32; 2],
    /// The same of each parameter alone, were it 1.
    pub turned_by: [f32; MAX_PARAMETERS],
    pub residual_before_rad: f32,
    pub residual_after_rad: f32,
    /// Sandwich deviations of its scaled parameters.
    pub sigma: [f32; MAX_PARAMETERS],
    /// Whether this window alone would not have shown it.
    pub by_history: bool,
    /// Whether it stays as it flies, since this window is explained better with it than without.
    pub stays: bool,
    /// Its scaled parameters while P was free, and how much it turned then and the deviation of that.
    pub free: [f32; MAX_PARAMETERS],
    pub free_size_rad: (f32, f32),
    /// Whether P as it flies, which was identified beside it, has it in: what is left of it does not show or not matter, and it is not taken out.
    pub in_p: bool,
    /// Whether it shows, but turns too little to matter: then it stays in the solution, so that nothing like it is found in its place, and
    /// is not taken out.
    pub too_small: bool,
}

impl Chosen {
    pub const NONE: Self = Self {
        index: 0,
        evidence: 0.0,
        p_value: 0.0,
        turned: [0.0; 2],
        turned_by: [0.0; MAX_PARAMETERS],
        residual_before_rad: 0.0,
        residual_after_rad: 0.0,
        sigma: [0.0; MAX_PARAMETERS],
        by_history: false,
        stays: false,
        free: [0.0; MAX_PARAMETERS],
        free_size_rad: (0.0, 0.0),
        in_p: false,
        too_small: false,
    };

    /// How much that of it turns which is seen to be there, and the deviation of that: radians rms. `x`: its scaled parameters.
    pub fn size_rad(&self, x: &[f32; MAX_PARAMETERS]) -> (f32, f32) {
        let [sum, count] = self.turned;
        if count <= 0.0 {
            return (0.0, 0.0);
        }
        let seen = each_parameter().filter(|k| self.is_seen(*k, at(x, *k)));
        let by_chance = seen.fold(0.0, |by_chance, k| by_chance + self.by_chance(k));
        (libm::sqrtf(sum / count), libm::sqrtf(by_chance / count))
    }

    /// Whether what is seen of it stands out from the deviation of all its parts, the others included, in noise of so many times the variance, and from
    /// what else turns the vector by that mean square.
    pub fn stands_out(&self, noise: f32, else_turned: f32) -> bool {
        let [sum, count] = self.turned;
        let by_chance = each_parameter().fold(0.0, |by_chance, k| by_chance + self.by_chance(k));
        count > 0.0 && sum > SIGNIFICANT * SIGNIFICANT * (noise * by_chance + else_turned * count)
    }

    /// Square of what the deviation of parameter `k` turns, summed as `turned_by` is.
    fn by_chance(&self, k: usize) -> f32 {
        at(&self.turned_by, k) * square(at(&self.sigma, k))
    }

    /// Whether scaled parameter `k` of value `x` is seen to be there: in a vertical hole the offset along the axis is not.
    pub fn is_seen(&self, k: usize, x: f32) -> bool {
        libm::fabsf(x) >= SIGNIFICANT * at(&self.sigma, k)
    }
}
