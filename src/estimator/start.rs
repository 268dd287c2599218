//! Start of the filter: from the factory's prior, or about a stored model.

use super::{
    Estimator, Settings, Task,
    columns::P,
    disagreement::Disagreement,
    drift::P_DRIFT,
    parameters::Parameters,
    real::{M3, Real, V3},
    share::Share,
};
use crate::compensation::{ActiveEffects, Effect, GyroModel};

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Starts afresh.
    pub fn configure(&mut self, settings: &Settings, library: &'static [&'static dyn Effect]) {
        self.candidates.configure(library);
        self.settings = *settings;
        self.has_sample = false;
        self.dropped_s = T::ZERO;
        self.waiting.clear();
        self.lost = 0;
        self.compose_with(&settings.factory);
        self.builder.start(settings.sample_period_s, settings.is_instant);
        self.remainder.start();
        self.was_unexplained = false;
        (self.unread, self.turned, self.fieldless) = (Share::zero(), Share::zero(), Share::zero());
        self.rests.start();
        let [x, y, z] = self.settings.factory.b_rad_s.map(T::of);
        self.bias = V3::new(x, y, z);
        self.begin();
        self.posterior.clear();
        self.known_attitude.clear();
    }

    /// From the factory's prior.
    pub(super) fn begin(&mut self) {
        self.sigma = self.settings.sigma.map(T::of);
        self.prior_p = widened_matrix(&self.settings.factory);
        self.is_restored = false;
        self.task = Task::Next;
        self.held.clear();
        (self.held_before, self.rate_before) = (None, None);
        self.candidates.begin();
        self.evidence.clear();
        self.weighed_us = 0;
        (self.unexplained, self.nodes) = (T::ZERO, 0);
        self.field_unit = T::ZERO;
        (self.is_aligned, self.has_begun) = (false, false);
        self.alignment.start();
        self.globals.start();
        self.node.referred = 0;
        self.updates = self.updates.wrapping_add(1);
        self.rests.interrupt();
        self.start_node();
        self.left_over.start();
        self.centre.clear();
        (self.motion_s, self.gap_s, self.unwalked_s) = (T::ZERO, T::ZERO, T::ZERO);
        (self.innovation, self.innovations) = (T::ZERO, 0);
        (self.of_field, self.of_force) = (Disagreement::zero(), Disagreement::zero());
        self.of_gyro = Disagreement::zero();
        self.linearise();
    }

    /// The parameters at the present globals.
    pub(super) fn linearise(&mut self) {
        let mut x = self.globals.x;
        for (x, sigma) in x.iter_mut().zip(&self.sigma) {
            *x *= *sigma;
        }
        self.parameters = Parameters::new(&x, &self.bias, &self.prior_p);
    }

    /// A model that was stored, with its deviations (P row-major, then b): P's prior is about it, as wide as it was
    /// known and may have drifted. The bias is another one at every start, and is as unknown as without. The effects
    /// that were taken out still are. Forgotten where the samples contradict it.
    pub fn restore(&mut self, model: &GyroModel, deviations: &[f32; 12], effects: &ActiveEffects) {
        self.prior_p = widened_matrix(model);
        for (column, deviation) in P.columns().zip(deviations) {
            let width = libm::sqrtf(deviation * deviation + P_DRIFT * P_DRIFT);
            if let Some(sigma) = self.sigma.get_mut(column)
                && *sigma > T::of(width)
            {
                *sigma = T::of(width);
            }
        }
        self.candidates.restore(effects);
        self.is_restored = true;
        self.linearise();
    }
}

/// P of a model, in the estimator's numbers.
fn widened_matrix<T: Real>(model: &GyroModel) -> M3<T> {
    let p = model.p_matrix();
    M3::from_fn(|i, j| p.get((i, j)).map_or(T::ZERO, |x| T::of(*x)))
}
